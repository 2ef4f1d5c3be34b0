//! Our own messages, decoded by a reader that knows nothing but their schema.

use super::message::Own;
use super::{Beacon, BeaconHeard, Decision, HeardLink, LinkHealth, State, Wire, WireGroup};
use crate::{Heard, Place, RobotMoment, Truth};
use drover_contract::{BehaviourState, Pose, RobotId, Stamp, Twist};
use foxglove::Encode;
use prost::Message;
use prost_reflect::{DescriptorPool, DynamicMessage, ReflectMessage, Value};

fn bytes_of<M: Encode>(message: &M) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.encode(&mut bytes).expect("room for a message");
    assert_eq!(message.encoded_len(), Some(bytes.len()));
    bytes
}

/// What a reader gets that has the schema and the bytes.
fn read<M: Encode + Own>(message: &M) -> DynamicMessage {
    let schema = M::get_schema().expect("a schema");
    assert_eq!((schema.name, schema.encoding), (format!("drover.{}", M::NAME), "protobuf".to_string()));
    let pool = DescriptorPool::decode(schema.data.as_ref()).expect("a schema that needs nothing else");
    let descriptor = pool.get_message_by_name(&format!("drover.{}", M::NAME)).expect("the message itself");
    let read = DynamicMessage::decode(descriptor, bytes_of(message).as_slice()).expect("bytes that fit the schema");
    assert_eq!(read.unknown_fields().count(), 0);
    assert_eq!(read.encode_to_vec(), bytes_of(message), "every field means the same to both");
    read
}

fn value(message: &DynamicMessage, name: &str) -> Value {
    message.get_field_by_name(name).expect("the schema has this field").into_owned()
}

fn robot() -> RobotMoment {
    RobotMoment {
        id: 7,
        state: "active".into(),
        reason: "driving".into(),
        changed: Some("obstacle".into()),
        link: "ready".into(),
        truth: Some(Truth {
            place: Place { x_m: 1.0, y_m: 2.0, yaw_rad: 0.5 },
            twist_b: [0.3, -0.1],
            in_contact: true,
        }),
        believed: Some(Place { x_m: 1.1, y_m: 2.1, yaw_rad: 0.6 }),
        pos_bound_m: 0.2,
        twist_b: [0.31, -0.11],
        command_b: [0.4, 0.0],
        request_b: Some([0.5, 0.0]),
        target_w: Some([0.0, 9.0]),
        nearest_m: Some(0.0),
        scan_age_ms: Some(0),
        link_age_ms: Some(12),
        progress: 0.75,
        reached: true,
        charge: Some(0.9),
        heard: Vec::new(),
        scan: None,
    }
}

#[test]
fn a_state_is_read_by_its_schema_alone() {
    let read = read(&State::new(1.5, &robot()));
    assert_eq!(value(&read, "time_s"), Value::F64(1.5));
    assert_eq!(value(&read, "id"), Value::U32(7));
    assert_eq!(value(&read, "changed"), Value::String("obstacle".into()));
    assert_eq!(value(&read, "link_age_ms"), Value::U64(12));
    assert_eq!(value(&read, "in_contact"), Value::Bool(true));
    assert!(read.has_field_by_name("nearest_m"), "0 is a reading");
    let empty = self::read(&State::new(0.0, &RobotMoment::default()));
    assert!(!empty.has_field_by_name("nearest_m"), "nothing is not 0");
}

#[test]
fn a_state_comes_back_as_it_was() {
    for robot in [robot(), RobotMoment::default()] {
        let state = State::new(3.25, &robot);
        let back = State::decode(bytes_of(&state).as_slice()).expect("what was encoded");
        assert_eq!(back, state);
        assert_eq!(back.robot(), robot);
    }
}

#[test]
fn a_decision_is_read_by_its_schema_alone() {
    let decision = Decision {
        stamp_us: 5,
        verdict: "held: obstacle".into(),
        request_speed_mps: Some(0.0),
        scan_age_us: Some(40),
        ..Decision::default()
    };
    let read = read(&decision);
    assert_eq!(value(&read, "verdict"), Value::String("held: obstacle".into()));
    assert!(read.has_field_by_name("request_speed_mps") && !read.has_field_by_name("changed"));
    assert_eq!(value(&read, "scan_age_us"), Value::U64(40));
}

#[test]
fn links_are_read_by_their_schema_alone() {
    let heard = Heard { id: 2, age_ms: 30, kept: true };
    let health = LinkHealth { robot: 1, received: 9, heard: vec![HeardLink::from(&heard)], ..LinkHealth::default() };
    assert_eq!(Heard::from(&health.heard[0]), heard);
    let read = read(&health);
    assert_eq!(value(&read, "received"), Value::U64(9));
    let list = value(&read, "heard");
    let first = list.as_list().and_then(|list| list.first()).and_then(Value::as_message).expect("a peer");
    assert_eq!(value(first, "age_ms"), Value::U64(30));
    assert_eq!(self::read(&health.heard[0]).descriptor().full_name(), "drover.HeardLink");
}

#[test]
fn a_beacon_is_read_by_its_schema_alone_and_comes_back() {
    let beacon = drover_contract::Beacon {
        robot: RobotId(4),
        epoch: 2,
        seq: 100,
        sent: Stamp::from_micros(123_456),
        pose_wb: Pose { x_m: 1.0, y_m: -2.0, yaw_rad: 3.0 },
        twist_b: Twist { speed_mps: 0.5, yaw_rate_radps: -0.25 },
        accel_mps2: 0.125,
        pos_bound_m: 0.3,
        radius_m: 0.2,
        state: BehaviourState::Held,
        progress: 0.5,
        leader: Some(RobotId(1)),
    };
    let told = Beacon::from(&beacon);
    assert_eq!(told.beacon(), Some(beacon));
    let lone = drover_contract::Beacon { leader: None, ..beacon };
    assert_eq!(Beacon::from(&lone).beacon(), Some(lone));
    assert_eq!(Beacon { state: "asleep".into(), ..told.clone() }.beacon(), None);
    assert_eq!(value(&read(&told), "state"), Value::String("held".into()));
    assert_eq!(value(&read(&told), "leader"), Value::U32(1));
    assert!(!read(&Beacon::from(&lone)).has_field_by_name("leader"), "nobody is absent, not 0");
    let read = read(&BeaconHeard { by: 1, stamp_us: 7, beacon: Some(told) });
    let inner = value(&read, "beacon");
    assert_eq!(value(inner.as_message().expect("a beacon"), "seq"), Value::U32(100));
}

#[test]
fn a_batch_from_the_wire_is_read_by_its_schema_alone() {
    let group = WireGroup { length: 3, planes: vec![0xfd, 0x00, 0xff] };
    let wire = Wire { robot: 3, marks: vec![0, 26], gaps_us: vec![0], order: vec![1], groups: vec![group.clone(); 2] };
    let read = read(&wire);
    assert_eq!(value(&read, "marks").as_bytes().map(|marks| marks.to_vec()), Some(vec![0, 26]));
    let list = value(&read, "groups");
    let groups = list.as_list().expect("a list");
    assert_eq!(groups.len(), 2);
    let planes = value(groups[1].as_message().expect("a group"), "planes");
    assert_eq!(planes.as_bytes().map(|planes| planes.to_vec()), Some(group.planes.clone()));
    assert_eq!(value(&self::read(&group), "length"), Value::U32(3));
}
