//! Transfers that pydronecan made, read and written.

use super::message::{
    GET_NODE_INFO_ID, GET_NODE_INFO_SIGNATURE, Health, MEASUREMENT_ID, MEASUREMENT_SIGNATURE, Measurement,
    NODE_STATUS_ID, NODE_STATUS_SIGNATURE, NodeInfo, NodeMode, NodeStatus, PROXIMITY_ID, PROXIMITY_SIGNATURE,
    Proximity, ProximityReading, RangeReading,
};
use super::transfer::split;
use super::{FrameId, Reassembler, Transfer, float16_decode, float16_encode};
use crate::can::testing::{frames, golden, list};
use drover_contract::{CanNode, Stamp};
use serde_json::Value;

fn byte(row: &Value, key: &str) -> u8 {
    u8::try_from(row[key].as_u64().unwrap()).unwrap()
}

fn bytes<const N: usize>(row: &Value, key: &str) -> [u8; N] {
    let list = list(row, key).iter().map(|byte| byte.as_u64().unwrap() as u8);
    list.collect::<Vec<u8>>().try_into().unwrap()
}

fn number(row: &Value, key: &str) -> Option<f64> {
    Some(row[key].as_f64().unwrap())
}

fn signature_of(id: &FrameId) -> Option<u64> {
    match *id {
        FrameId::Message { type_id: PROXIMITY_ID, .. } => Some(PROXIMITY_SIGNATURE),
        FrameId::Message { type_id: MEASUREMENT_ID, .. } => Some(MEASUREMENT_SIGNATURE),
        FrameId::Message { type_id: NODE_STATUS_ID, .. } => Some(NODE_STATUS_SIGNATURE),
        FrameId::Service { type_id: GET_NODE_INFO_ID, .. } => Some(GET_NODE_INFO_SIGNATURE),
        _ => None,
    }
}

/// The one transfer that a row's frames make.
fn read(row: &Value) -> Transfer {
    let mut reassembler = Reassembler::new(4);
    let frames = frames(row);
    let mut transfers = frames.iter().filter_map(|frame| reassembler.accept(Stamp::ZERO, frame, signature_of));
    let transfer = transfers.next().unwrap();
    assert!(transfers.next().is_none());
    assert_eq!(transfer.transfer_id, byte(row, "transfer_id"));
    transfer
}

fn message_id(row: &Value, type_id: u16) -> FrameId {
    let (priority, source) = (byte(row, "transfer_priority"), CanNode(byte(row, "node")));
    FrameId::Message { priority, type_id, source }
}

/// Check that `payload` under `id` makes exactly the row's frames.
fn check_written(row: &Value, id: FrameId, signature: u64, payload: &[u8]) {
    assert_eq!(split(id, signature, byte(row, "transfer_id"), payload), frames(row), "{row}");
}

/// The row's reading with the numbers under `suffix`: "" those given to pydronecan, "_wire" those that arrive.
fn proximity(row: &Value, suffix: &str) -> Proximity {
    let reading = [ProximityReading::NoData, ProximityReading::NotConnected, ProximityReading::Good];
    Proximity {
        sensor_id: byte(row, "sensor_id"),
        reading: reading[usize::from(byte(row, "reading"))],
        flags: byte(row, "flags"),
        yaw_deg: number(row, &format!("yaw_deg{suffix}")),
        pitch_deg: number(row, &format!("pitch_deg{suffix}")),
        distance_m: number(row, &format!("distance_m{suffix}")),
    }
}

fn measurement(row: &Value, suffix: &str) -> Measurement {
    let reading = [RangeReading::Undefined, RangeReading::Valid, RangeReading::TooClose, RangeReading::TooFar];
    let angles: Vec<i8> = list(row, "roll_pitch_yaw").iter().map(|angle| angle.as_i64().unwrap() as i8).collect();
    Measurement {
        timestamp_us: row["timestamp_us"].as_u64().unwrap(),
        sensor_id: byte(row, "sensor_id"),
        roll_pitch_yaw: angles.try_into().unwrap(),
        orientation_defined: row["orientation_defined"].as_bool().unwrap(),
        field_of_view_rad: number(row, &format!("field_of_view_rad{suffix}")),
        sensor_type: byte(row, "sensor_type"),
        reading: reading[usize::from(byte(row, "reading"))],
        range_m: number(row, &format!("range_m{suffix}")),
    }
}

fn node_status(row: &Value) -> NodeStatus {
    let mode = match byte(row, "mode") {
        0 => NodeMode::Operational,
        1 => NodeMode::Initialization,
        2 => NodeMode::Maintenance,
        3 => NodeMode::SoftwareUpdate,
        _ => NodeMode::Offline,
    };
    NodeStatus {
        uptime_s: row["uptime_s"].as_u64().unwrap() as u32,
        health: [Health::Ok, Health::Warning, Health::Error, Health::Critical][usize::from(byte(row, "health"))],
        mode,
        sub_mode: byte(row, "sub_mode"),
        vendor: row["vendor"].as_u64().unwrap() as u16,
    }
}

fn node_info(row: &Value) -> NodeInfo {
    NodeInfo {
        status: NodeStatus { uptime_s: row["uptime_s"].as_u64().unwrap() as u32, ..NodeStatus::default() },
        software: bytes(row, "software"),
        hardware: bytes(row, "hardware"),
        unique_id: bytes(row, "unique_id"),
        name: row["name"].as_str().unwrap().to_owned(),
    }
}

fn rows(kind: &str) -> Vec<Value> {
    let document = golden("dronecan.json");
    let rows: Vec<Value> = list(&document, "rows").iter().filter(|row| row["kind"] == kind).cloned().collect();
    assert!(rows.len() >= 8, "too few rows of kind {kind}");
    rows
}

#[test]
fn proximity_is_read_and_written_as_pydronecan_does() {
    for row in rows("proximity") {
        let transfer = read(&row);
        assert_eq!(transfer.id, message_id(&row, PROXIMITY_ID));
        assert_eq!(Proximity::parse(&transfer.payload), Some(proximity(&row, "_wire")), "{row}");
        check_written(&row, transfer.id, PROXIMITY_SIGNATURE, &proximity(&row, "").emit());
    }
}

#[test]
fn measurement_is_read_and_written_as_pydronecan_does() {
    for row in rows("measurement") {
        let transfer = read(&row);
        assert_eq!(transfer.id, message_id(&row, MEASUREMENT_ID));
        assert_eq!(Measurement::parse(&transfer.payload), Some(measurement(&row, "_wire")), "{row}");
        check_written(&row, transfer.id, MEASUREMENT_SIGNATURE, &measurement(&row, "").emit());
    }
}

#[test]
fn node_status_is_read_and_written_as_pydronecan_does() {
    for row in rows("node_status") {
        let transfer = read(&row);
        assert_eq!(transfer.id, message_id(&row, NODE_STATUS_ID));
        assert_eq!(NodeStatus::parse(&transfer.payload), Some(node_status(&row)), "{row}");
        check_written(&row, transfer.id, NODE_STATUS_SIGNATURE, &node_status(&row).emit());
    }
}

#[test]
fn an_answer_of_many_frames_is_put_together_and_written_as_pydronecan_does() {
    for row in rows("node_info") {
        let transfer = read(&row);
        let id = FrameId::Service {
            priority: byte(&row, "transfer_priority"),
            type_id: GET_NODE_INFO_ID,
            request: false,
            destination: CanNode(byte(&row, "destination")),
            source: CanNode(byte(&row, "node")),
        };
        assert_eq!((transfer.id, &transfer.payload), (id, &node_info(&row).emit()), "{row}");
        check_written(&row, id, GET_NODE_INFO_SIGNATURE, &transfer.payload);
    }
}

#[test]
fn halves_are_the_bits_that_pydronecan_makes() {
    for row in list(&golden("dronecan.json"), "halves") {
        let bits = row["bits"].as_u64().unwrap() as u16;
        assert_eq!(float16_encode(row["value"].as_f64().unwrap()), bits, "{row}");
        assert!(float16_decode(bits).is_some());
    }
}

#[test]
fn signatures_are_the_ones_that_pydronecan_computes() {
    let signatures = [
        ("proximity", PROXIMITY_SIGNATURE),
        ("measurement", MEASUREMENT_SIGNATURE),
        ("node_status", NODE_STATUS_SIGNATURE),
        ("node_info", GET_NODE_INFO_SIGNATURE),
    ];
    let document = golden("dronecan.json");
    for (kind, signature) in signatures {
        assert_eq!(document["signatures"][kind], format!("{signature:016X}"), "{kind}");
    }
}
