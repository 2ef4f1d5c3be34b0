//! The virtual chassis alone, and driven by the robot's own host over frames, in virtual time.

use super::{AgilexSimParams, VirtualAgilex};
use crate::firmware::BodyState;
use drover_codec::can::agilex::wire::{ChassisFrame, HostFrame, Motion, SystemState, Vehicle};
use drover_codec::can::agilex::{AgilexHost, AgilexParams, Model};
use drover_contract::{CanFrame, CanId, DriveState, Event, Limits, Odometry, SafeCommand, Stamp, Twist, WheelTravel};
use std::time::Duration;

const TRACK_M: f64 = 0.49;
const STEP_MS: u64 = 10;
const LIMITS: Limits = Limits {
    speed_mps_max: 10.0,
    reverse_mps_max: 10.0,
    yaw_rate_radps_max: 10.0,
    accel_mps2_max: 1.0,
    brake_mps2: 1.0,
    yaw_accel_radps2_max: 1.0,
};

fn ms(ms: u64) -> Stamp {
    Stamp::from_millis(ms)
}

fn chassis(model: Model) -> VirtualAgilex {
    VirtualAgilex::new(AgilexSimParams::new(model, TRACK_M), 1)
}

fn motion(speed_mmps: i16, yaw_rate_mradps: i16) -> CanFrame {
    HostFrame::Motion(Motion { speed_mmps, yaw_rate_mradps, ..Motion::default() }).emit()
}

fn enabled() -> VirtualAgilex {
    let mut chassis = chassis(Model::ScoutMini);
    chassis.handle_frame(ms(0), &HostFrame::ControlMode(1).emit());
    chassis
}

fn said(chassis: &mut VirtualAgilex) -> Vec<ChassisFrame> {
    std::iter::from_fn(|| chassis.poll_output()).map(|frame| ChassisFrame::parse(&frame).unwrap()).collect()
}

fn state_of(chassis: &mut VirtualAgilex, at_ms: u64) -> SystemState {
    chassis.step(ms(at_ms), &BodyState::default());
    let state = |frame: &ChassisFrame| if let ChassisFrame::State(state) = frame { Some(*state) } else { None };
    said(chassis).iter().find_map(state).unwrap()
}

#[test]
fn standby_obeys_nothing_but_the_mode_command() {
    let mut chassis = chassis(Model::ScoutMini);
    chassis.set_fault(0x0100);
    chassis.set_fault(0);
    chassis.handle_frame(ms(0), &motion(500, 0));
    chassis.handle_frame(ms(0), &HostFrame::ClearErrors(0).emit());
    assert_eq!(chassis.demand(), Twist::ZERO);
    let state = state_of(&mut chassis, 0);
    assert_eq!((state.vehicle, state.mode, state.errors), (Vehicle::Exception, 0, 0x0100));
}

#[test]
fn it_stops_500_ms_after_the_last_command_and_stays_in_can_mode() {
    let mut chassis = enabled();
    chassis.handle_frame(ms(100), &motion(500, -200));
    chassis.step(ms(599), &BodyState::default());
    assert_eq!(chassis.demand(), Twist::new(0.5, -0.2));
    chassis.step(ms(600), &BodyState::default());
    assert_eq!(chassis.demand(), Twist::ZERO);
    assert_eq!(state_of(&mut chassis, 700).mode, 1);
    chassis.handle_frame(ms(800), &motion(100, 0));
    assert_eq!(chassis.demand(), Twist::new(0.1, 0.0));
}

#[test]
fn commands_are_cut_to_what_the_model_can_do() {
    let mut chassis = enabled();
    chassis.handle_frame(ms(0), &motion(-5000, 4000));
    assert_eq!(chassis.demand(), Twist::new(-3.0, 2.5235));
}

#[test]
fn the_mode_byte_is_each_models_own() {
    let remote_mode = |model| {
        let mut chassis = chassis(model);
        chassis.set_remote_control(true);
        state_of(&mut chassis, 0).mode
    };
    assert_eq!([Model::Scout, Model::Hunter, Model::Tracer].map(remote_mode), [3, 2, 0]);
    assert_eq!(state_of(&mut chassis(Model::Tracer), 0).mode, 1, "a Tracer starts in command mode");
}

#[test]
fn frames_come_at_the_manuals_rates() {
    let mut chassis = chassis(Model::ScoutMini);
    let mut counts = std::collections::BTreeMap::new();
    for step in 0..1000 {
        chassis.step(ms(step), &BodyState::default());
        while let Some(frame) = chassis.poll_output() {
            let CanId::Standard(id) = frame.id() else { unreachable!() };
            assert_eq!(frame.data().len(), 8);
            *counts.entry(id).or_insert(0) += 1;
        }
    }
    let mut expected = vec![(0x211, 10), (0x221, 50), (0x241, 50)];
    expected.extend((0x251..=0x254).map(|id| (id, 10)));
    expected.extend((0x261..=0x264).map(|id| (id, 10)));
    expected.extend([(0x311, 50), (0x361, 2)]);
    assert_eq!(counts.into_iter().collect::<Vec<_>>(), expected);
}

#[test]
fn feedback_is_what_the_wheels_did() {
    let mut chassis = enabled();
    let wheels = |left_m, right_m| BodyState { wheels: WheelTravel { left_m, right_m }, ..BodyState::default() };
    chassis.step(ms(0), &wheels(5.0, 7.0));
    _ = said(&mut chassis);
    chassis.step(ms(20), &wheels(5.010, 7.020)); // 0.5 and 1.0 m/s
    let frames = said(&mut chassis);
    assert!(frames.contains(&ChassisFrame::Odometer { left_mm: 10, right_mm: 20 }));
    let turned = Motion { speed_mmps: 750, yaw_rate_mradps: 1020, ..Motion::default() };
    assert!(frames.contains(&ChassisFrame::Motion(turned)), "{frames:?}");
}

#[test]
fn frames_that_arrive_between_two_steps_do_not_change_the_speed_it_measures() {
    let mut chassis = enabled();
    let wheels = |m| BodyState { wheels: WheelTravel { left_m: m, right_m: m }, ..BodyState::default() };
    let step = Duration::from_millis(STEP_MS);
    for count in 0..20_u16 {
        let now = Stamp::ZERO + step * u32::from(count);
        chassis.step(now, &wheels(0.005 * f64::from(count))); // 0.5 m/s
        let motions = said(&mut chassis).into_iter().filter(|frame| matches!(frame, ChassisFrame::Motion(_)));
        let even = Motion { speed_mmps: if count == 0 { 0 } else { 500 }, ..Motion::default() };
        assert!(motions.into_iter().all(|frame| frame == ChassisFrame::Motion(even)));
        chassis.handle_frame(now + (step - Duration::from_micros(10)), &motion(500, 0));
    }
}

#[test]
fn its_odometer_wraps_where_a_real_one_does() {
    let mut chassis = enabled();
    chassis.step(ms(0), &BodyState::default());
    _ = said(&mut chassis);
    let wheels = WheelTravel { left_m: 2_147_483.648, right_m: -2_147_483.649 };
    chassis.step(ms(20), &BodyState { wheels, ..BodyState::default() });
    assert!(said(&mut chassis).contains(&ChassisFrame::Odometer { left_mm: i32::MIN, right_mm: i32::MAX }));
}

#[test]
fn one_seed_says_the_same_twice_and_another_does_not() {
    let talk = |seed| {
        let mut chassis = VirtualAgilex::new(AgilexSimParams::new(Model::ScoutMini, TRACK_M), seed);
        (0..50).for_each(|step| chassis.step(ms(step * 10), &BodyState::default()));
        std::iter::from_fn(move || chassis.poll_output()).collect::<Vec<_>>()
    };
    assert_eq!(talk(1), talk(1));
    assert_ne!(talk(1), talk(2));
}

/// A host and a chassis on one wire, with a body that follows at once.
struct Rig {
    host: AgilexHost,
    chassis: VirtualAgilex,
    wheels: WheelTravel,
    now_ms: u64,
    drives: Vec<String>,
    odometry: Option<Odometry>,
    enables: u32,
}

impl Rig {
    fn new(model: Model) -> Self {
        let params = AgilexParams { model, track_m: TRACK_M, link_timeout: Duration::from_millis(400) };
        Self {
            host: AgilexHost::new(params, ms(0)),
            chassis: chassis(model),
            wheels: WheelTravel::default(),
            now_ms: 0,
            drives: vec![],
            odometry: None,
            enables: 0,
        }
    }

    /// A chassis that obeys, and a host that knows.
    fn ready() -> Self {
        let mut rig = Self::new(Model::ScoutMini);
        rig.run(300, None);
        assert!(rig.is_ready(), "{:?}", rig.drives);
        rig
    }

    fn is_ready(&self) -> bool {
        matches!(self.host.drive_state(), DriveState::Ready(_))
    }

    /// Let `span_ms` pass, with `command` given every 50 ms.
    fn run(&mut self, span_ms: u64, command: Option<Twist>) {
        let until = self.now_ms + span_ms;
        while self.now_ms < until {
            if let Some(twist) = command.filter(|_| self.now_ms.is_multiple_of(50)) {
                self.host.command(ms(self.now_ms), SafeCommand::bounded(twist, &LIMITS).unwrap());
            }
            self.step();
        }
    }

    fn step(&mut self) {
        self.now_ms += STEP_MS;
        let now = ms(self.now_ms);
        let twist = self.chassis.demand();
        let (dt_s, half) = (STEP_MS as f64 * 1e-3, twist.yaw_rate_radps * TRACK_M / 2.0);
        self.wheels.left_m += (twist.speed_mps - half) * dt_s;
        self.wheels.right_m += (twist.speed_mps + half) * dt_s;
        self.chassis.step(now, &BodyState { wheels: self.wheels, twist_b: twist, ..BodyState::default() });
        while let Some(frame) = self.chassis.poll_output() {
            self.host.handle_frame(now, &frame);
        }
        self.host.handle_timeout(now);
        while let Some(frame) = self.host.poll_output() {
            self.enables += u32::from(HostFrame::parse(&frame) == Ok(HostFrame::ControlMode(1)));
            self.chassis.handle_frame(now, &frame);
        }
        while let Some(event) = self.host.poll_event() {
            match event {
                Event::Drive(drive) => self.drives.push(drive.to_string()),
                Event::Odometry(odometry) => self.odometry = Some(odometry),
                _ => {}
            }
        }
    }
}

const FORWARD: Twist = Twist::new(0.5, 0.2);

#[test]
fn a_host_brings_every_model_from_power_on_to_driving() {
    for model in [Model::Scout, Model::ScoutMini, Model::Tracer, Model::Hunter, Model::Bunker] {
        let mut rig = Rig::new(model);
        rig.run(400, Some(FORWARD));
        assert!(rig.is_ready(), "{model:?}: {:?}", rig.drives);
        assert_eq!(rig.chassis.demand(), FORWARD, "{model:?}");
        assert_eq!(rig.odometry.unwrap().twist_b, FORWARD, "{model:?}");
    }
}

#[test]
fn odometry_follows_the_wheels() {
    let mut rig = Rig::ready();
    rig.run(2_000, Some(FORWARD));
    let told = rig.odometry.unwrap().wheels.unwrap();
    assert!((told.left_m - rig.wheels.left_m).abs() < 0.02, "{told:?} is not {:?}", rig.wheels);
    assert!((told.right_m - rig.wheels.right_m).abs() < 0.02, "{told:?} is not {:?}", rig.wheels);
}

#[test]
fn a_host_that_falls_silent_leaves_a_chassis_that_stops_by_itself() {
    let mut rig = Rig::ready();
    rig.run(1_000, Some(FORWARD)); // the last command is given 50 ms before the end and arrives one step later
    rig.run(450, None);
    assert_eq!(rig.chassis.demand(), FORWARD);
    rig.run(20, None);
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    assert!(rig.is_ready(), "it stays in CAN mode");
}

#[test]
fn after_a_power_cycle_the_mode_is_sent_again_and_nothing_moves_before_a_fresh_command() {
    let mut rig = Rig::ready();
    rig.run(1_000, Some(FORWARD));
    let (enables, travelled) = (rig.enables, rig.odometry.unwrap().wheels.unwrap());
    rig.chassis.power_cycle(ms(rig.now_ms));
    rig.run(2_000, None);
    assert!(rig.is_ready());
    assert_eq!(rig.enables, enables + 1);
    let told = &rig.drives[rig.drives.len() - 4..];
    let steps = ["silent", "waiting for the system state (0x211)", "in standby: asking for CAN mode", "ready"];
    assert_eq!(told, steps);
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    rig.run(100, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), FORWARD);
    let told = rig.odometry.unwrap().wheels.unwrap();
    let gone_on = (travelled.left_m..travelled.left_m + 0.1).contains(&told.left_m);
    assert!(gone_on, "the counters' reset is not travel: {travelled:?}, then {told:?}");
}

#[test]
fn a_power_cycle_too_short_to_notice_as_silence_is_noticed_by_its_mode() {
    let mut rig = Rig::ready();
    rig.chassis = VirtualAgilex::new(AgilexSimParams { boot: Duration::ZERO, ..rig.chassis.params }, 1);
    rig.run(1_000, Some(FORWARD));
    let before = rig.odometry.unwrap().wheels.unwrap();
    rig.chassis.power_cycle(ms(rig.now_ms));
    rig.run(500, None);
    assert!(rig.is_ready());
    let after = rig.odometry.unwrap().wheels.unwrap();
    assert!((after.left_m - before.left_m).abs() < 0.05, "{before:?}, then {after:?}");
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
}

#[test]
fn the_remote_control_masks_commands_and_its_return_needs_a_fresh_one() {
    let mut rig = Rig::ready();
    rig.run(500, Some(FORWARD));
    rig.chassis.set_remote_control(true);
    rig.run(500, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    assert_eq!(rig.host.drive_state().to_string(), "refused: the remote control has it: switch it to command mode");
    rig.chassis.set_remote_control(false);
    rig.run(500, None);
    assert!(rig.is_ready());
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    rig.run(100, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), FORWARD);
}

#[test]
fn an_emergency_stop_stops_at_once_and_only_a_new_host_clears_it_after_its_release() {
    let mut rig = Rig::ready();
    rig.run(500, Some(FORWARD));
    rig.chassis.set_estop(true);
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    rig.run(500, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    let why = "refused: emergency stop pressed: start this program anew once it is safe";
    assert_eq!(rig.host.drive_state().to_string(), why);
    rig.chassis.set_estop(false);
    rig.run(5_000, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    let why = "refused: emergency stop was pressed: start this program anew once it is safe";
    assert_eq!(rig.host.drive_state().to_string(), why);
    rig.host = Rig::new(Model::ScoutMini).host;
    rig.run(700, None);
    assert!(rig.is_ready(), "{:?}", rig.drives);
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    rig.run(100, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), FORWARD);
}

#[test]
fn a_fault_in_standby_is_cleared_although_standby_hears_only_the_mode() {
    let mut rig = Rig::new(Model::ScoutMini);
    rig.chassis.set_fault(0x0100);
    rig.run(500, Some(FORWARD));
    assert!(rig.host.drive_state().to_string().contains("battery undervoltage fault"));
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    rig.chassis.set_fault(0);
    rig.run(600, None);
    assert!(rig.is_ready(), "{:?}", rig.drives);
}

#[test]
fn a_host_that_shuts_down_leaves_the_chassis_standing_in_standby() {
    let mut rig = Rig::ready();
    rig.run(500, Some(FORWARD));
    rig.host.shutdown(ms(rig.now_ms));
    rig.run(50, Some(FORWARD));
    assert_eq!(rig.chassis.demand(), Twist::ZERO);
    assert_eq!(state_of(&mut rig.chassis, rig.now_ms + 100).mode, 0);
}
