//! The host of a chassis, frame by frame. The same against a whole virtual chassis is in `drover-world`.

use super::wire::{ChassisFrame, HostFrame, Motion, SystemState, Vehicle};
use super::{AgilexHost, AgilexParams, Model};
use crate::can::testing::frame;
use drover_contract::{CanFrame, CanId, DriveState, Event, Limits, SafeCommand, Severity, Stamp, Twist, Watchdog};
use proptest::prelude::*;
use std::time::Duration;

const LINK_TIMEOUT: Duration = Duration::from_millis(400);

fn ms(ms: u64) -> Stamp {
    Stamp::from_millis(ms)
}

fn host_of(model: Model) -> AgilexHost {
    AgilexHost::new(AgilexParams { model, track_m: 0.49, link_timeout: LINK_TIMEOUT }, Stamp::ZERO)
}

fn host() -> AgilexHost {
    host_of(Model::ScoutMini)
}

fn state(vehicle: Vehicle, mode: u8, errors: u16) -> CanFrame {
    let state = SystemState { vehicle, mode, battery_dv: 270, errors, park: 0, counter: 0 };
    ChassisFrame::State(state).emit()
}

fn outputs(host: &mut AgilexHost) -> Vec<HostFrame> {
    std::iter::from_fn(|| host.poll_output()).map(|frame| HostFrame::parse(&frame).unwrap()).collect()
}

fn drives(host: &mut AgilexHost) -> Vec<String> {
    let told = |event| if let Event::Drive(drive) = event { Some(drive.to_string()) } else { None };
    std::iter::from_fn(|| host.poll_event()).filter_map(told).collect()
}

fn texts(host: &mut AgilexHost) -> Vec<(Severity, String)> {
    let told = |event| if let Event::Text(severity, text) = event { Some((severity, text)) } else { None };
    std::iter::from_fn(|| host.poll_event()).filter_map(told).collect()
}

fn forward() -> SafeCommand {
    let limits = Limits {
        speed_mps_max: 3.0,
        reverse_mps_max: 3.0,
        yaw_rate_radps_max: 3.0,
        accel_mps2_max: 1.0,
        brake_mps2: 1.0,
        yaw_accel_radps2_max: 1.0,
    };
    SafeCommand::bounded(Twist::new(0.25, 0.3), &limits).unwrap()
}

fn ready() -> AgilexHost {
    let mut host = host();
    host.handle_frame(ms(0), &state(Vehicle::Normal, 1, 0));
    assert_eq!(host.drive_state(), &DriveState::Ready(Watchdog::Fixed(Duration::from_millis(500))));
    _ = drives(&mut host);
    host
}

#[test]
fn can_mode_is_asked_for_again_until_the_chassis_shows_it() {
    let mut host = host();
    host.handle_frame(ms(0), &state(Vehicle::Normal, 0, 0));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
    host.handle_frame(ms(100), &state(Vehicle::Normal, 0, 0));
    assert_eq!(outputs(&mut host), []);
    assert_eq!(host.poll_timeout(), Some((ms(250), "agilex retry")));
    host.handle_timeout(ms(250));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
    host.handle_frame(ms(300), &state(Vehicle::Normal, 1, 0));
    assert_eq!(drives(&mut host), ["silent", "in standby: asking for CAN mode", "ready"]);
    host.handle_timeout(ms(600));
    assert_eq!((outputs(&mut host), host.counters().enables), (vec![], 2));
}

#[test]
fn no_command_leaves_before_the_drive_is_ready_and_none_is_kept() {
    let mut host = host();
    host.command(ms(0), forward());
    host.handle_frame(ms(1), &state(Vehicle::Normal, 0, 0));
    host.command(ms(2), forward());
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
    host.handle_frame(ms(100), &state(Vehicle::Normal, 1, 0));
    assert_eq!((outputs(&mut host), host.counters().commands_refused), (vec![], 2));
    host.command(ms(101), forward());
    let motion = Motion { speed_mmps: 250, yaw_rate_mradps: 300, ..Motion::default() };
    assert_eq!(outputs(&mut host), [HostFrame::Motion(motion)]);
}

#[test]
fn a_newer_command_takes_the_place_of_one_not_sent_yet() {
    let mut host = ready();
    host.command(ms(1), forward());
    host.command(ms(2), SafeCommand::STOP);
    assert_eq!(outputs(&mut host), [HostFrame::Motion(Motion::default())]);
}

#[test]
fn a_command_not_sent_yet_is_taken_back_when_the_drive_is_lost() {
    let mut host = ready();
    host.command(ms(1), forward());
    host.handle_frame(ms(2), &state(Vehicle::EmergencyStop, 1, 0));
    assert_eq!(outputs(&mut host), []);
}

#[test]
fn a_chassis_that_fell_back_to_standby_is_enabled_again() {
    let mut host = ready();
    host.handle_frame(ms(100), &state(Vehicle::Normal, 0, 0));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
    host.command(ms(101), forward());
    assert_eq!(outputs(&mut host), []);
    host.handle_frame(ms(200), &state(Vehicle::Normal, 1, 0));
    assert_eq!(outputs(&mut host), []);
    assert_eq!(drives(&mut host), ["in standby: asking for CAN mode", "ready"]);
}

#[test]
fn the_remote_control_is_named_and_not_argued_with() {
    let mut host = ready();
    host.handle_frame(ms(100), &state(Vehicle::Normal, 3, 0));
    host.handle_timeout(ms(450));
    assert_eq!(outputs(&mut host), []);
    assert_eq!(drives(&mut host), ["refused: the remote control has it: switch it to command mode"]);
}

#[test]
fn after_the_remote_control_can_mode_is_asked_for_even_if_the_chassis_shows_it() {
    let mut host = ready();
    host.handle_frame(ms(100), &state(Vehicle::Normal, 3, 0));
    host.handle_frame(ms(200), &state(Vehicle::Normal, 1, 0));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
    assert_eq!(host.drive_state().to_string(), "ready");
}

#[test]
fn a_tracer_that_starts_in_remote_control_is_asked_all_the_same() {
    let mut host = host_of(Model::Tracer);
    host.handle_frame(ms(0), &state(Vehicle::Normal, 0, 0));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1)]);
}

#[test]
fn an_emergency_stop_lasts_as_long_as_the_host_whatever_the_chassis_shows_afterwards() {
    let mut host = ready();
    host.handle_frame(ms(100), &state(Vehicle::EmergencyStop, 1, 0));
    assert_eq!(drives(&mut host), ["refused: emergency stop pressed: start this program anew once it is safe"]);
    let released = [(Vehicle::Exception, 1), (Vehicle::Normal, 0), (Vehicle::Normal, 3), (Vehicle::Normal, 1)];
    for (at, (vehicle, mode)) in (2..).zip(released) {
        host.handle_frame(ms(at * 100), &state(vehicle, mode, 0));
        host.command(ms(at * 100), forward());
        host.handle_timeout(ms(at * 100 + 50));
    }
    let why = "emergency stop was pressed: start this program anew once it is safe";
    assert_eq!((drives(&mut host), outputs(&mut host)), (vec![format!("refused: {why}")], vec![]));
    host.handle_timeout(ms(2_000));
    host.handle_frame(ms(5_000), &state(Vehicle::Normal, 0, 0));
    assert_eq!(drives(&mut host), ["silent".to_owned(), format!("refused: {why}")], "a power cycle ends nothing");
    host.handle_timeout(ms(5_300));
    assert_eq!(outputs(&mut host), []);
}

#[test]
fn an_exception_is_named_and_cleared_until_it_is_gone() {
    let mut host = ready();
    host.handle_frame(ms(100), &state(Vehicle::Exception, 1, 0x0100));
    assert_eq!(outputs(&mut host), [HostFrame::ClearErrors(0)]);
    host.handle_frame(ms(350), &state(Vehicle::Exception, 0, 0x0100));
    assert_eq!(outputs(&mut host), [HostFrame::ControlMode(1), HostFrame::ClearErrors(0)]);
    let why = "exception: battery undervoltage fault (error bits 0x0100); clearing it again and again";
    assert_eq!(drives(&mut host), [format!("refused: {why}")]);
    host.handle_frame(ms(400), &state(Vehicle::Normal, 1, 0));
    assert_eq!(drives(&mut host), ["ready"]);
}

#[test]
fn a_chassis_without_a_system_state_is_silent_after_the_timeout_whatever_else_it_sends() {
    let mut host = ready();
    let (at, what) = host.poll_timeout().unwrap();
    assert_eq!(what, "agilex system state");
    host.handle_timeout(ms(400));
    assert_eq!(host.drive_state().to_string(), "ready");
    host.handle_timeout(at);
    assert_eq!(host.drive_state(), &DriveState::Silent);
    host.handle_frame(ms(450), &frame("221#0000000000000000"));
    assert_eq!(host.drive_state().to_string(), "waiting for the system state (0x211)");
    host.handle_timeout(ms(900));
    assert_eq!(host.drive_state(), &DriveState::Silent);
    assert_eq!(host.poll_timeout(), None);
}

#[test]
fn a_command_after_the_silence_is_refused_even_if_nobody_woke_the_host() {
    let mut host = ready();
    host.command(ms(401), forward());
    assert_eq!((outputs(&mut host), host.counters().commands_refused), (vec![], 1));
}

#[test]
fn a_chassis_of_protocol_v1_is_refused_by_name() {
    let mut host = host();
    host.handle_frame(ms(0), &frame("151#0001011800000001"));
    host.handle_frame(ms(1), &state(Vehicle::Normal, 1, 0));
    let why = "refused: speaks protocol v1 (frame 0x151 seen): update the chassis' firmware to protocol v2";
    assert_eq!(drives(&mut host), ["silent", why]);
    assert_eq!(outputs(&mut host), []);
    host.handle_timeout(ms(401));
    assert_eq!(host.drive_state(), &DriveState::Silent);
}

#[test]
fn shutting_down_stops_first_and_then_gives_the_chassis_back_for_good() {
    let mut host = ready();
    host.command(ms(1), forward());
    host.shutdown(ms(2));
    assert_eq!(outputs(&mut host), [HostFrame::Motion(Motion::default()), HostFrame::ControlMode(0)]);
    host.handle_frame(ms(100), &state(Vehicle::Normal, 0, 0));
    host.command(ms(101), forward());
    host.handle_timeout(ms(600));
    assert_eq!(outputs(&mut host), []);
    assert_eq!(AgilexHost::stop_frames(), [frame("111#0000000000000000")]);
}

#[test]
fn odometry_is_the_twist_fed_back_and_the_wheels_if_they_are_counted() {
    let mut host = host();
    host.handle_frame(ms(0), &frame("221#FF06012C00000000"));
    for (at, odometer) in [(20, "311#000004D2FFFFFDC9"), (40, "311#000004DCFFFFFDCE")] {
        host.handle_frame(ms(at), &frame(odometer));
    }
    host.handle_frame(ms(41), &frame("221#00FAFED400000000"));
    let odometry = |event| if let Event::Odometry(odometry) = event { Some(odometry) } else { None };
    let told: Vec<_> = std::iter::from_fn(|| host.poll_event()).filter_map(odometry).collect();
    assert_eq!((told[0].twist_b, told[0].wheels), (Twist::new(-0.25, 0.3), None));
    assert_eq!((told[1].stamp, told[1].twist_b), (ms(41), Twist::new(0.25, -0.3)));
    let wheels = told[1].wheels.unwrap();
    assert!((wheels.left_m - 0.010).abs() < 1e-12 && (wheels.right_m - 0.005).abs() < 1e-12);
}

#[test]
fn a_motor_fault_is_told_once_when_it_comes_and_once_when_it_goes() {
    let mut host = host();
    for state in ["0A", "0A", "00", "00"] {
        host.handle_frame(ms(0), &frame(&format!("263#0118002D1E{state}0000")));
    }
    let fault = "motor 3: motor over-temperature, driver over-temperature (state byte 0x0A)";
    let expected = [(Severity::Error, fault.to_owned()), (Severity::Info, "motor 3: no fault any more".to_owned())];
    assert_eq!(texts(&mut host), expected);
}

#[test]
fn a_battery_monitor_outranks_the_voltage_in_the_system_state() {
    let mut host = host();
    host.handle_frame(ms(0), &frame("361#505F010400640000"));
    host.handle_frame(ms(1), &state(Vehicle::Normal, 1, 0));
    let battery = |event| if let Event::Battery(battery) = event { Some(battery) } else { None };
    let told: Vec<_> = std::iter::from_fn(|| host.poll_event()).filter_map(battery).collect();
    assert_eq!(told.len(), 1);
    assert!((told[0].charge.unwrap() - 0.8).abs() < 1e-9 && (told[0].current_a.unwrap() - 10.0).abs() < 1e-9);
}

#[test]
fn frames_of_a_wrong_length_or_with_extended_identifiers_are_counted_and_ignored() {
    let mut host = host();
    host.handle_frame(ms(0), &frame("211#00010118000000"));
    let data = [0, 1, 1, 0x18, 0, 0, 0, 0];
    host.handle_frame(ms(0), &CanFrame::new(CanId::Extended(0x211), &data).unwrap());
    assert_eq!(host.drive_state(), &DriveState::Silent);
    assert_eq!((host.counters().malformed, host.counters().foreign), (1, 1));
}

const IDS: [u16; 7] = [0x111, 0x151, 0x211, 0x221, 0x263, 0x311, 0x361];

proptest! {
    #[test]
    fn whatever_comes_only_a_ready_drive_is_moved_and_nothing_grows(
        frames in prop::collection::vec((prop::sample::select(&IDS[..]), any::<[u8; 8]>(), 0_u8..4, 0_u64..300), 0..200)
    ) {
        let (mut host, mut now) = (host(), 0);
        for (id, mut data, mode, step_ms) in frames {
            data[0] %= 4;
            data[1] = mode;
            now += step_ms;
            host.handle_frame(ms(now), &CanFrame::new(CanId::Standard(id), &data).unwrap());
            host.command(ms(now), forward());
            let ready = matches!(host.drive_state(), DriveState::Ready(_));
            let moving = outputs(&mut host).iter().any(|frame| matches!(frame, HostFrame::Motion(_)));
            prop_assert_eq!(moving, ready);
        }
        prop_assert!(std::iter::from_fn(|| host.poll_event()).count() <= 64);
    }
}
