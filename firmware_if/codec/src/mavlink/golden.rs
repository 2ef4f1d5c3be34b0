//! Frames that pymavlink made (tests/golden/mavlink/make.py): ours must be the same bytes, and read as the same fields.

use super::device::{
    AckResult, Ask, Command, Demand, Inbound, Received, Sector, Speaker, Telemetry, decode, text_pieces,
};
use super::raw::{BatteryStatus, CommandAck, DistanceSensor, Heartbeat, SysStatus, TextPiece};
use super::wire::{Frame, WireCounters, frames};
use super::{MavHost, MavHostParams, mode, obstacle, outbox};
use drover_contract::{Battery, Beam, Event, MavId, Pose, Scan, Stamp, Twist};
use std::collections::BTreeMap;
use std::time::Duration;

/// A frame with the fields that pymavlink gave it.
pub(crate) struct Golden {
    pub(crate) bytes: Vec<u8>,
    fields: BTreeMap<&'static str, &'static str>,
}

impl Golden {
    fn integer(&self, field: &str) -> u32 {
        self.fields[field].parse().expect("an integer")
    }

    fn number(&self, field: &str) -> f64 {
        self.fields[field].parse().expect("a number")
    }

    fn numbers(&self, field: &str) -> Vec<f64> {
        self.fields[field].split(',').map(|number| number.parse().expect("a number")).collect()
    }

    fn text(&self, field: &str) -> String {
        String::from_utf8(unhex(self.fields[field])).expect("text")
    }

    fn frame(&self) -> Frame<'_> {
        let mut found = frames(&self.bytes);
        let frame = found.next().expect("something").expect("a frame");
        assert_eq!(found.next(), None);
        assert_eq!(u32::from(frame.from.system), self.integer("from_system"));
        assert_eq!(u32::from(frame.from.component), self.integer("from_component"));
        frame
    }
}

fn unhex(hex: &str) -> Vec<u8> {
    let digit = |index: usize| u8::from_str_radix(&hex[index..index + 2], 16).expect("hex");
    (0..hex.len()).step_by(2).map(digit).collect()
}

/// The vectors of a file, by label.
pub(crate) fn vectors(file: &'static str) -> BTreeMap<&'static str, Golden> {
    let lines = file.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let mut words = line.split(' ');
            let label = words.next().expect("label");
            let bytes = unhex(words.next().expect("frame"));
            let fields = words.map(|word| word.split_once('=').expect("field=value")).collect();
            (label, Golden { bytes, fields })
        })
        .collect()
}

fn host() -> BTreeMap<&'static str, Golden> {
    vectors(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/host.txt")))
}

fn device() -> BTreeMap<&'static str, Golden> {
    vectors(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/device.txt")))
}

const COMPUTER: MavId = MavId { system: 7, component: 191 };

fn computer_says(message: &mavlink::dialects::common::MavMessage) -> Vec<u8> {
    super::wire::Emitter::new(COMPUTER).encode(message)
}

fn autopilot_says(telemetry: &Telemetry) -> Vec<u8> {
    Speaker::new(MavId { system: 7, component: 1 }).encode(telemetry)
}

#[test]
fn what_the_host_sends_is_what_pymavlink_would_send() {
    use super::request::Request;
    let golden = host();
    let request = |request, confirmation| computer_says(&outbox::command(7, request, confirmation));
    assert_eq!(computer_says(&outbox::heartbeat()), golden["heartbeat"].bytes);
    assert_eq!(request(Request::Mode(mode::HOLD), 0), golden["hold"].bytes);
    assert_eq!(request(Request::Mode(mode::GUIDED), 1), golden["guided_again"].bytes);
    assert_eq!(request(Request::Arm(true), 0), golden["arm"].bytes);
    assert_eq!(request(Request::Arm(false), 0), golden["disarm"].bytes);
    assert_eq!(request(Request::Interval { message: 32, hz: 40 }, 0), golden["position_40_hz"].bytes);
}

#[test]
fn setpoints_are_what_pymavlink_would_send_and_never_hold_a_nan() {
    let golden = host();
    let setpoint =
        |speed, turn| computer_says(&outbox::setpoint(7, Stamp::from_millis(12_345), Twist::new(speed, turn)));
    assert_eq!(setpoint(0.75, 0.5), golden["forward_left"].bytes, "left is negative on the wire");
    assert_eq!(setpoint(-0.25, -1.25), golden["backward_right"].bytes);
    let stop = computer_says(&outbox::setpoint(7, Stamp::ZERO, Twist::ZERO));
    assert_eq!(stop, golden["stop"].bytes);
    for bad in [f64::NAN, f64::INFINITY, 1.0e300] {
        assert_eq!(setpoint(bad, 0.0), setpoint(0.0, 0.0));
        assert_eq!(setpoint(0.5, bad), setpoint(0.0, 0.0));
    }
    assert_eq!(outbox::stop_frame(COMPUTER), golden["stop"].bytes);
}

fn received(label: &str) -> Vec<Received> {
    decode(7, &host()[label].bytes, &mut WireCounters::default())
}

fn command(label: &str) -> Command {
    match received(label)[..] {
        [Received { what: Inbound::Command(command), .. }] => command,
        ref other => panic!("{label}: {other:?}"),
    }
}

#[test]
fn the_autopilot_reads_commands_even_those_that_no_dialect_knows() {
    assert_eq!(command("hold"), Command { id: 176, ask: Ask::Mode(4) });
    assert_eq!(command("guided_again").ask, Ask::Mode(15));
    assert_eq!(command("command_int_mode").ask, Ask::Mode(15));
    assert_eq!(command("arm").ask, Ask::Arm { arm: true, force: false });
    assert_eq!(command("v1_arm").ask, Ask::Arm { arm: true, force: false });
    assert_eq!(command("signed_arm").ask, Ask::Arm { arm: true, force: false });
    assert_eq!(command("force_arm").ask, Ask::Arm { arm: true, force: true });
    assert_eq!(command("disarm").ask, Ask::Arm { arm: false, force: false });
    assert_eq!(command("position_40_hz").ask, Ask::Interval { message: 32, interval_us: 25_000 });
    assert_eq!(command("unknown_command"), Command { id: 60_980, ask: Ask::Unknown });
    assert!(received("for_another_system").is_empty());
}

#[test]
fn the_autopilot_reads_everything_else_that_it_is_sent() {
    let from = MavId { system: 255, component: 190 };
    assert_eq!(received("set_mode"), [Received { from, what: Inbound::SetMode { custom_mode: 4 } }]);
    let all_at_4_hz = Inbound::DataStream { stream: 0, hz: 4, on: true };
    assert_eq!(received("data_stream"), [Received { from, what: all_at_4_hz }]);
    let question = Inbound::TimeQuestion { asked_ns: 123_456_789_001 };
    assert_eq!(received("time_question"), [Received { from: COMPUTER, what: question }]);
    assert_eq!(received("heartbeat"), [Received { from: COMPUTER, what: Inbound::Heartbeat { vehicle_type: 18 } }]);
    let demand = |label| match received(label)[..] {
        [Received { what: Inbound::Setpoint(setpoint), .. }] => setpoint.demand(&Pose::default()),
        ref other => panic!("{label}: {other:?}"),
    };
    assert_eq!(demand("forward_left"), Demand::Twist(Twist::new(0.75, 0.5)));
    assert_eq!(demand("backward_right"), Demand::Twist(Twist::new(-0.25, -1.25)));
    assert_eq!(demand("not_a_number"), Demand::Twist(Twist::ZERO));
}

const BATTERY: Battery = Battery { voltage_v: Some(12.6), current_a: Some(1.5), charge: Some(0.9) };

#[test]
fn what_the_autopilot_says_is_what_pymavlink_would_say() {
    let golden = device();
    let armed = autopilot_says(&Telemetry::Heartbeat { custom_mode: mode::GUIDED, armed: true });
    assert_eq!(armed, golden["heartbeat_guided_armed"].bytes);
    let ready = Telemetry::SysStatus { prearm_ok: true, obstacles_ok: true, battery: BATTERY };
    assert_eq!(autopilot_says(&ready), golden["sys_status_ready"].bytes);
    let early = Telemetry::SysStatus { prearm_ok: false, obstacles_ok: false, battery: Battery::default() };
    assert_eq!(autopilot_says(&early), golden["sys_status_not_ready"].bytes);
    assert_eq!(autopilot_says(&Telemetry::BatteryStatus { battery: BATTERY }), golden["battery"].bytes);
    let ack = |command, result, to| autopilot_says(&Telemetry::Ack { command, result, to });
    assert_eq!(ack(400, AckResult::Accepted, COMPUTER), golden["ack_accepted"].bytes);
    assert_eq!(ack(400, AckResult::Failed, COMPUTER), golden["ack_failed"].bytes);
    let station = MavId { system: 255, component: 190 };
    assert_eq!(ack(60_980, AckResult::Unsupported, station), golden["ack_unknown_command"].bytes);
    assert_eq!(autopilot_says(&Telemetry::Version), golden["version"].bytes);
}

#[test]
fn motion_and_texts_of_the_autopilot_are_what_pymavlink_would_say() {
    let golden = device();
    let limits = (0.2, 8.0);
    let sector = |index, nearest_m| {
        let sector = Sector { index, nearest_m, range_m_min: limits.0, range_m_max: limits.1 };
        autopilot_says(&Telemetry::Sector { boot_ms: 5000, sector })
    };
    assert_eq!(sector(0, Some(2.5)), golden["sector_ahead"].bytes);
    assert_eq!(sector(6, None), golden["sector_left_empty"].bytes);
    let text = |severity, words| text_pieces(severity, words, 9).iter().map(autopilot_says).collect::<Vec<_>>();
    assert_eq!(text(2, "Arm: Need Position Estimate"), [golden["text"].bytes.clone()]);
    let pieces = text(6, "Requested rate for message ID 32 too fast. Increase SCHED_LOOP_RATE");
    assert_eq!(pieces.len(), 2);
    assert_eq!(pieces[0], golden["text_piece_0"].bytes);
    let attitude =
        Telemetry::Attitude { boot_ms: 5000, yaw_rad: std::f64::consts::FRAC_PI_2 - 0.5, yaw_rate_radps: 0.125 };
    assert_eq!(autopilot_says(&attitude), golden["attitude"].bytes);
}

#[test]
fn telemetry_reads_as_the_fields_that_pymavlink_wrote() {
    let golden = device();
    let heartbeat = Heartbeat::read(golden["heartbeat_guided_armed"].frame().payload);
    assert!(heartbeat.armed());
    assert_eq!((heartbeat.custom_mode, heartbeat.vehicle_type, heartbeat.autopilot), (15, 10, 3));
    assert!(!Heartbeat::read(golden["heartbeat_hold_disarmed"].frame().payload).armed());
    assert_eq!(Heartbeat::read(golden["heartbeat_v1"].frame().payload), heartbeat);
    assert_eq!(Heartbeat::read(golden["heartbeat_unknown_enums"].frame().payload).vehicle_type, 250);

    let status = SysStatus::read(golden["sys_status_ready"].frame().payload);
    assert_eq!(status.health, golden["sys_status_ready"].integer("onboard_control_sensors_health"));
    assert_eq!((status.voltage_mv, status.current_ca, status.remaining), (12_600, 150, 90));
    let early = SysStatus::read(golden["sys_status_not_ready"].frame().payload);
    assert_eq!(early.health & SysStatus::PREARM, 0);
    assert_eq!((early.voltage_mv, early.current_ca, early.remaining), (u16::MAX, -1, -1));

    let battery = BatteryStatus::read(golden["battery"].frame().payload);
    assert_eq!(battery, BatteryStatus { id: 0, voltage_mv: Some(12_600), current_ca: 150, remaining: 90 });
    let ack = CommandAck::read(golden["ack_unknown_command"].frame().payload);
    assert_eq!(ack, CommandAck { command: 60_980, result: 3, target_system: 255, target_component: 190 });
    assert_eq!(CommandAck::read(golden["ack_without_target"].frame().payload).target_system, 0);
    let sector = DistanceSensor::read(golden["sector_left_empty"].frame().payload);
    assert_eq!(sector, DistanceSensor { min_cm: 20, max_cm: 800, current_cm: 800, orientation: 6 });
    let piece = &golden["text_piece_1"];
    let read = TextPiece::read(piece.frame().payload);
    assert_eq!((read.text, read.id, read.chunk, read.severity), (piece.text("text").as_bytes(), 9, 1, 6));
}

/// A host of robot 7 whose events can be collected.
fn listener() -> MavHost {
    let params = MavHostParams {
        robot: 7,
        component: 191,
        telemetry_hz: 40,
        lidar_component: 196,
        range_m_min: 0.1,
        range_m_max: 9.0,
        link_timeout: Duration::from_secs(1),
    };
    MavHost::new(params, Stamp::ZERO)
}

fn heard(labels: &[&str]) -> Vec<Event> {
    let (mut host, golden) = (listener(), device());
    for label in labels {
        host.handle_datagram(Stamp::from_millis(10), &golden[label].bytes);
    }
    std::iter::from_fn(|| host.poll_event()).collect()
}

fn scan(label: &str) -> Scan {
    match heard(&[label]).pop() {
        Some(Event::Scan(scan)) => scan,
        other => panic!("{label}: {other:?}"),
    }
}

#[test]
fn position_and_attitude_become_a_pose_in_the_world_and_a_twist_of_the_body() {
    let golden = &device()["position"];
    let events = heard(&["attitude", "position"]);
    let [Event::Pose(fix), Event::Odometry(odometry)] = &events[..] else { panic!("{events:?}") };
    assert_eq!((fix.pose_wb.x_m, fix.pose_wb.y_m), (golden.number("y"), golden.number("x")));
    assert!((fix.pose_wb.yaw_rad - (std::f64::consts::FRAC_PI_2 - 0.5)).abs() < 1e-6);
    let forward =
        golden.number("vx") * drover_contract::math::cos(0.5) + golden.number("vy") * drover_contract::math::sin(0.5);
    assert!((odometry.twist_b.speed_mps - forward).abs() < 1e-6);
    assert!((odometry.twist_b.yaw_rate_radps - 0.125).abs() < 1e-9);
    assert!(heard(&["position"]).is_empty(), "without an attitude there is no pose");
    assert!(heard(&["attitude_nan", "position"]).is_empty());
}

#[test]
fn a_scan_is_turned_into_the_body_frame() {
    let golden = &device()["obstacles"];
    let scan = scan("obstacles");
    assert_eq!(scan.beams.len(), 72);
    assert!((scan.angle_first_rad - 20.0_f64.to_radians()).abs() < 1e-9, "20 degrees left of the front");
    assert!((scan.angle_step_rad + 5.0_f64.to_radians()).abs() < 1e-9, "then clockwise");
    assert_eq!((scan.range_m_min, scan.range_m_max), (0.2, 12.0));
    for (index, cm) in golden.numbers("distances").into_iter().enumerate() {
        let wanted = match index {
            3 => Beam::Clear,
            70 | 71 => Beam::Unknown,
            _ => Beam::Hit(cm * 0.01),
        };
        assert_eq!(scan.beams[index], wanted, "beam {index}");
    }
}

#[test]
fn coarse_and_backward_scans_are_understood_and_north_aligned_ones_refused() {
    let coarse = scan("obstacles_coarse");
    assert_eq!(coarse.beams, vec![Beam::Hit(2.5); 36], "the integer step counts if there is no other");
    let backward = scan("obstacles_counter_clockwise");
    assert!((backward.angle_first_rad + 90.0_f64.to_radians()).abs() < 1e-9);
    assert!(backward.angle_step_rad > 0.0);
    let events = heard(&["obstacles_north_aligned", "obstacles_north_aligned"]);
    assert!(matches!(&events[..], [Event::Text(_, words)] if words.contains("frame is 0")), "said once: {events:?}");
}

#[test]
fn a_scan_that_comes_back_is_the_scan_that_went_out() {
    let golden = device();
    let mut sent = scan("obstacles");
    sent.beams[70] = Beam::Clear;
    let telemetry = Telemetry::Obstacles { boot_us: 1_000_000, scan: sent.clone() };
    let bytes = Speaker::new(MavId { system: 7, component: 196 }).encode(&telemetry);
    assert_eq!(bytes.len(), golden["obstacles"].bytes.len());
    let frame = frames(&bytes).next().expect("one").expect("good");
    let limits = obstacle::RangeLimits { range_m_min: 0.1, range_m_max: 9.0 };
    let back = obstacle::decode(sent.stamp, frame.payload, limits).expect("a scan");
    assert_eq!(back.beams, sent.beams);
    assert!((back.angle_first_rad - sent.angle_first_rad).abs() < 1e-6);
}
