//! AgileX frames that others made: printed in the maker's manuals, and by the maker's own Python package.

use super::wire::{ChassisFrame, HostFrame, Vehicle};
use super::{AgilexHost, AgilexParams, Model};
use crate::can::testing::{frame, golden, list};
use drover_contract::{CanFrame, Event, Limits, SafeCommand, Stamp, Twist};
use proptest::prelude::*;
use serde_json::Value;
use std::time::Duration;

const LIMITS: Limits = Limits {
    speed_mps_max: 3.0,
    reverse_mps_max: 3.0,
    yaw_rate_radps_max: 3.0,
    accel_mps2_max: 1.0,
    brake_mps2: 1.0,
    yaw_accel_radps2_max: 1.0,
};

fn host(model: Model) -> AgilexHost {
    AgilexHost::new(AgilexParams { model, track_m: 0.49, link_timeout: Duration::from_millis(500) }, Stamp::ZERO)
}

/// What a ready host sends for a row's twist.
fn command_frame(row: &Value) -> CanFrame {
    let mut host = host(Model::ScoutMini);
    host.handle_frame(Stamp::ZERO, &frame("211#0001011800000001"));
    let twist = Twist::new(row["speed_mps"].as_f64().unwrap(), row["yaw_rate_radps"].as_f64().unwrap());
    host.command(Stamp::ZERO, SafeCommand::bounded(twist, &LIMITS).unwrap());
    host.poll_output().unwrap()
}

#[test]
fn commands_are_the_bytes_that_the_manuals_print() {
    for row in list(&golden("agilex_manual.json"), "commands") {
        assert_eq!(command_frame(row), frame(row["frame"].as_str().unwrap()), "{}", row["source"]);
    }
}

#[test]
fn commands_are_the_bytes_that_the_makers_package_writes() {
    let document = golden("agilex_pyagxrobots.json");
    let (enable, commands) = list(&document, "write").split_last().unwrap();
    assert_eq!(commands.len(), 40);
    for row in commands {
        assert_eq!(command_frame(row), frame(row["frame"].as_str().unwrap()), "{row}");
    }
    let mut standby = host(Model::ScoutMini);
    standby.handle_frame(Stamp::ZERO, &frame("211#0000011800000001"));
    assert_eq!(standby.poll_output(), Some(frame(enable["frame"].as_str().unwrap())));
}

/// Whether `parsed` holds what the package found, to a fraction of one step of the wire.
fn agrees(parsed: ChassisFrame, row: &Value) -> bool {
    let same = |key: &str, ours: f64| (row[key].as_f64().unwrap() - ours).abs() < 0.06 * step(key);
    let int = |key: &str, ours: i64| row[key].as_i64() == Some(ours);
    match parsed {
        ChassisFrame::State(state) => {
            let vehicle = [Vehicle::Normal, Vehicle::EmergencyStop, Vehicle::Exception];
            vehicle[row["vehicle"].as_u64().unwrap() as usize] == state.vehicle
                && int("mode", state.mode.into())
                && same("battery_v", f64::from(state.battery_dv) * 0.1)
        }
        ChassisFrame::Motion(motion) => {
            same("speed_mps", f64::from(motion.speed_mmps) * 1e-3)
                && same("yaw_rate_radps", f64::from(motion.yaw_rate_mradps) * 1e-3)
                && same("lateral_mps", f64::from(motion.lateral_mmps) * 1e-3)
                && same("steering_rad", f64::from(motion.steering_mrad) * 1e-3)
        }
        ChassisFrame::MotorFast { motor, rpm, current_da, pulses } => {
            int("motor", motor.into())
                && int("rpm", rpm.into())
                && same("current_a", f64::from(current_da) * 0.1)
                && int("pulses", pulses.into())
        }
        ChassisFrame::MotorSlow { motor, voltage_dv, driver_c, motor_c, state } => {
            int("motor", motor.into())
                && same("voltage_v", f64::from(voltage_dv) * 0.1)
                && int("driver_c", driver_c.into())
                && int("motor_c", motor_c.into())
                && int("state", state.into())
        }
        ChassisFrame::Odometer { left_mm, right_mm } => {
            int("left_mm", left_mm.into()) && int("right_mm", right_mm.into())
        }
        ChassisFrame::Remote(_) | ChassisFrame::Bms { .. } | ChassisFrame::V1 => false,
    }
}

fn step(key: &str) -> f64 {
    if key.ends_with("_mps") || key.ends_with("_rad") || key.ends_with("_radps") { 0.001 } else { 0.1 }
}

#[test]
fn feedback_is_read_as_the_makers_package_reads_it() {
    let document = golden("agilex_pyagxrobots.json");
    assert_eq!(list(&document, "read").len(), 100);
    for row in list(&document, "read") {
        let parsed = ChassisFrame::parse(&frame(row["frame"].as_str().unwrap())).unwrap();
        assert!(agrees(parsed, row), "{row} is not {parsed:?}");
    }
}

#[test]
fn a_battery_of_a_hunter_counts_in_hundredths_of_a_volt() {
    let volts = |model: Model| {
        let mut host = host(model);
        host.handle_frame(Stamp::ZERO, &frame("361#505F010400640000"));
        std::iter::from_fn(|| host.poll_event()).find_map(|event| match event {
            Event::Battery(battery) => battery.voltage_v,
            _ => None,
        })
    };
    assert!((volts(Model::Scout).unwrap() - 26.0).abs() < 1e-9);
    assert!((volts(Model::Hunter).unwrap() - 2.6).abs() < 1e-9);
}

proptest! {
    #[test]
    fn any_frame_is_read_or_refused_and_what_is_read_is_written_back(
        id in 0_u16..=0x7FF, data: [u8; 8], len in 0_usize..=8
    ) {
        let frame = CanFrame::new(drover_contract::CanId::Standard(id), &data[..len]).unwrap();
        match ChassisFrame::parse(&frame) {
            // Bytes 6 and 7 of a slow motor frame and byte 6 of the remote control are reserved; v1 is not written.
            Ok(ChassisFrame::V1 | ChassisFrame::Remote(_) | ChassisFrame::MotorSlow { .. }) | Err(_) => {}
            Ok(parsed) => prop_assert_eq!(parsed.emit(), frame),
        }
        if let Ok(parsed) = HostFrame::parse(&frame) {
            prop_assert_eq!(HostFrame::parse(&parsed.emit()), Ok(parsed));
        }
    }

    #[test]
    fn reserved_bytes_do_not_change_what_is_read(data: [u8; 8]) {
        for id in [0x241, 0x263] {
            let frame = CanFrame::new(drover_contract::CanId::Standard(id), &data).unwrap();
            let parsed = ChassisFrame::parse(&frame).unwrap();
            prop_assert_eq!(ChassisFrame::parse(&parsed.emit()), Ok(parsed));
        }
    }
}
