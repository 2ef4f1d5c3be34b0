//! The host against an autopilot that says exactly what a test wants.

use super::device::{AckResult, Ask, Command, Demand, Inbound, Speaker, Telemetry, decode};
use super::golden::vectors;
use super::wire::WireCounters;
use super::{MavHost, MavHostParams, mode};
use drover_contract::{
    Battery, Beam, DriveState, Event, Limits, MavId, Pose, SafeCommand, Scan, Stamp, Twist, Watchdog,
};
use std::time::Duration;

const LIMITS: Limits = Limits {
    speed_mps_max: 1.0,
    reverse_mps_max: 0.5,
    yaw_rate_radps_max: 1.0,
    accel_mps2_max: 1.0,
    brake_mps2: 1.0,
    yaw_accel_radps2_max: 1.0,
};
const HOST: MavId = MavId { system: 7, component: 191 };
const ELSE: &str = "somebody else (or a failsafe): set GUIDED and arm, or start this program anew";

/// A host, and a mouth for the autopilot of its robot.
struct Rig {
    host: MavHost,
    autopilot: Speaker,
    now: Stamp,
}

impl Rig {
    fn new() -> Self {
        let params = MavHostParams {
            robot: 7,
            component: 191,
            telemetry_hz: 40,
            lidar_component: 196,
            range_m_min: 0.1,
            range_m_max: 9.0,
            link_timeout: Duration::from_millis(500),
        };
        let host = MavHost::new(params, Stamp::ZERO);
        Self { host, autopilot: Speaker::new(MavId { system: 7, component: 1 }), now: Stamp::ZERO }
    }

    fn say(&mut self, telemetry: &Telemetry) {
        let bytes = self.autopilot.encode(telemetry);
        self.host.handle_datagram(self.now, &bytes);
    }

    fn heartbeat(&mut self, custom_mode: u32, armed: bool) {
        self.say(&Telemetry::Heartbeat { custom_mode, armed });
    }

    fn prearm(&mut self, prearm_ok: bool) {
        self.say(&Telemetry::SysStatus { prearm_ok, obstacles_ok: true, battery: Battery::default() });
    }

    fn ack(&mut self, command: u16, result: AckResult) {
        self.say(&Telemetry::Ack { command, result, to: HOST });
    }

    fn text(&mut self, words: &str) {
        self.say(&Telemetry::Text { severity: 2, text: words.into(), id: 0, chunk: 0 });
    }

    fn position(&mut self, boot_ms: u32) {
        self.say(&Telemetry::Attitude { boot_ms, yaw_rad: 0.0, yaw_rate_radps: 0.0 });
        self.say(&Telemetry::Position { boot_ms, pose_wb: Pose::default(), twist_b: Twist::ZERO });
    }

    /// Let `span` pass, serving every deadline on its way.
    fn wait(&mut self, span: Duration) {
        let end = self.now + span;
        while let Some((due, what)) = self.host.poll_timeout().filter(|(due, _)| *due <= end) {
            self.now = self.now.max(due);
            self.host.handle_timeout(self.now);
            let next = self.host.poll_timeout();
            assert!(next.is_none_or(|next| next > (due, what)), "{what} at {due} is served again and again");
        }
        self.now = end;
    }

    /// Everything sent since the last call, without the host's own heartbeats and time questions.
    fn sent(&mut self) -> Vec<Inbound> {
        let mut counters = WireCounters::default();
        let mut sent = Vec::new();
        while let Some(bytes) = self.host.poll_output() {
            let received = decode(7, &bytes, &mut counters);
            assert_eq!(received.len(), 1, "one frame a datagram");
            assert_eq!(received[0].from, HOST);
            sent.extend(received.into_iter().map(|it| it.what));
        }
        sent.retain(|what| !matches!(what, Inbound::Heartbeat { .. } | Inbound::TimeQuestion { .. }));
        sent
    }

    fn asked(&mut self) -> Vec<Ask> {
        let asks = self.sent().into_iter().map(|what| match what {
            Inbound::Command(Command { ask, .. }) => ask,
            other => panic!("{other:?} is no command"),
        });
        asks.collect()
    }

    fn state(&self) -> &DriveState {
        self.host.drive_state()
    }

    fn refusal(&self) -> String {
        match self.state() {
            DriveState::Refused(why) => why.clone(),
            other => panic!("{other:?} is no refusal"),
        }
    }

    /// All the way to ready, at the current moment.
    fn bring_up(&mut self) {
        self.heartbeat(mode::HOLD, false);
        self.prearm(true);
        for command in [176, 400, 176, 511, 511, 511, 511] {
            self.ack(command, AckResult::Accepted);
        }
        self.heartbeat(mode::GUIDED, true);
        assert_eq!(*self.state(), DriveState::Ready(Watchdog::Fixed(Duration::from_secs(3))));
        self.sent();
    }

    /// Its heartbeats show this for half a minute, and the host asks for nothing and drives nothing.
    fn stays_alone(&mut self, custom_mode: u32, armed: bool) {
        for _ in 0..75 {
            self.heartbeat(custom_mode, armed);
            self.drive(0.5);
            self.wait(Duration::from_millis(400));
        }
        assert_eq!(self.sent(), []);
        self.refusal();
    }

    /// Its heartbeat shows armed and GUIDED: it is stopped and telemetry asked for, no mode; then it drives.
    fn is_given_back(&mut self) {
        self.heartbeat(mode::GUIDED, true);
        self.drive(0.5);
        let sent = self.sent();
        assert!(matches!(&sent[0], Inbound::Setpoint(it) if it.demand(&Pose::default()) == Demand::Twist(Twist::ZERO)));
        assert!(matches!(sent[1..], [Inbound::Command(Command { ask: Ask::Interval { message: 32, .. }, .. })]));
        for _ in 0..4 {
            self.ack(511, AckResult::Accepted);
        }
        assert!(matches!(self.state(), DriveState::Ready(_)));
        self.sent();
        self.drive(0.5);
        assert_eq!(self.setpoints(), [Demand::Twist(Twist::new(0.5, 0.0))]);
    }

    /// The next time question; the link is kept alive until it comes.
    fn time_question(&mut self) -> i64 {
        let ready = matches!(self.state(), DriveState::Ready(_));
        for _ in 0..60 {
            self.heartbeat(if ready { mode::GUIDED } else { mode::MANUAL }, ready);
            self.wait(Duration::from_millis(100));
            let mut counters = WireCounters::default();
            while let Some(bytes) = self.host.poll_output() {
                for received in decode(7, &bytes, &mut counters) {
                    if let Inbound::TimeQuestion { asked_ns } = received.what {
                        return asked_ns;
                    }
                }
            }
        }
        panic!("no time question");
    }

    fn drive(&mut self, speed_mps: f64) {
        let command = SafeCommand::bounded(Twist::new(speed_mps, 0.0), &LIMITS).expect("finite");
        self.host.command(self.now, command);
    }

    fn setpoints(&mut self) -> Vec<Demand> {
        let sent = self.sent().into_iter().filter_map(|what| match what {
            Inbound::Setpoint(setpoint) => Some(setpoint.demand(&Pose::default())),
            _ => None,
        });
        sent.collect()
    }
}

const fn interval(message: u32, interval_us: i64) -> Ask {
    Ask::Interval { message, interval_us }
}

#[test]
fn hold_comes_before_arming_and_arming_before_guided() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::MANUAL, false);
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"));
    assert!(rig.sent().is_empty());
    rig.prearm(false);
    assert!(rig.sent().is_empty());
    rig.prearm(true);
    assert_eq!(rig.asked(), [Ask::Mode(mode::HOLD)]);
    rig.ack(176, AckResult::Accepted);
    assert_eq!(rig.asked(), [Ask::Arm { arm: true, force: false }]);
    rig.ack(400, AckResult::Accepted);
    assert_eq!(rig.asked(), [Ask::Mode(mode::GUIDED)]);
    rig.ack(176, AckResult::Accepted);
    for ask in [interval(32, 25_000), interval(30, 25_000), interval(1, 1_000_000), interval(147, 1_000_000)] {
        assert_eq!(rig.asked(), [ask]);
        rig.ack(511, AckResult::Accepted);
    }
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for its heartbeat to show GUIDED"));
    rig.heartbeat(mode::GUIDED, true);
    assert_eq!(*rig.state(), DriveState::Ready(Watchdog::Fixed(Duration::from_secs(3))));
}

#[test]
fn acknowledgements_alone_never_make_a_drive_ready() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::MANUAL, false);
    rig.prearm(true);
    for command in [176, 400, 176, 511, 511, 511, 511] {
        rig.ack(command, AckResult::Accepted);
    }
    rig.wait(Duration::from_millis(900));
    rig.heartbeat(mode::HOLD, true);
    rig.drive(0.5);
    assert!(rig.setpoints().is_empty());
    rig.heartbeat(mode::HOLD, true);
    rig.wait(Duration::from_secs(3));
    assert_eq!(rig.refusal(), "its heartbeat shows mode HOLD");
    assert_eq!(rig.host.counters().withheld, 1);
}

#[test]
fn a_command_leaves_at_once_when_ready_and_the_newest_replaces_one_that_has_not_left() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.drive(0.25);
    rig.drive(0.5);
    assert_eq!(rig.setpoints(), [Demand::Twist(Twist::new(0.5, 0.0))]);
    assert!(rig.setpoints().is_empty(), "nothing is sent twice");
}

#[test]
fn silence_after_a_request_is_answered_by_repeating_it_and_then_by_saying_so() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    rig.ack(176, AckResult::Accepted);
    rig.sent();
    for _ in 0..3 {
        rig.wait(Duration::from_millis(699));
        assert!(rig.sent().is_empty());
        rig.wait(Duration::from_millis(1));
        assert_eq!(rig.asked(), [Ask::Arm { arm: true, force: false }]);
        rig.heartbeat(mode::HOLD, false);
    }
    rig.wait(Duration::from_millis(700));
    assert_eq!(rig.refusal(), "arming not acknowledged");
    rig.heartbeat(mode::HOLD, false);
    rig.wait(Duration::from_millis(1001));
    assert_eq!(rig.asked(), [Ask::Mode(mode::HOLD)], "from the start, after a pause");
}

#[test]
fn a_repeated_request_counts_its_repetitions() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    rig.wait(Duration::from_millis(710));
    let commands: Vec<_> = std::iter::from_fn(|| rig.host.poll_output()).filter(|bytes| bytes[7] == 76).collect();
    let confirmations: Vec<u8> = commands.iter().map(|bytes| bytes.get(10 + 32).copied().unwrap_or(0)).collect();
    // The CRC follows directly where a zero was cut off.
    assert_eq!(commands.iter().map(|bytes| bytes[1]).collect::<Vec<_>>(), [32, 33]);
    assert_eq!(confirmations[1], 1);
}

#[test]
fn a_refusal_carries_the_autopilots_own_words_whichever_comes_first() {
    let refused = |text_first: bool| {
        let mut rig = Rig::new();
        rig.heartbeat(mode::HOLD, false);
        rig.prearm(true);
        rig.ack(176, AckResult::Accepted);
        if text_first {
            rig.text("Arm: Need Position Estimate");
        }
        rig.ack(400, AckResult::Failed);
        if !text_first {
            rig.text("Arm: Need Position Estimate");
        }
        rig.refusal()
    };
    assert_eq!(refused(true), "arming failed (Arm: Need Position Estimate)");
    assert_eq!(refused(false), refused(true));
}

#[test]
fn pauses_between_tries_grow_and_stay_bounded() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    let mut pauses = Vec::new();
    for _ in 0..6 {
        rig.ack(176, AckResult::Failed);
        rig.sent();
        let refused_at = rig.now;
        while rig.sent().is_empty() {
            rig.heartbeat(mode::HOLD, false);
            rig.wait(Duration::from_millis(100));
        }
        pauses.push(rig.now.since(refused_at).as_secs());
    }
    assert_eq!(pauses, [1, 2, 4, 8, 8, 8]);
}

#[test]
fn telemetry_that_is_not_needed_may_be_refused() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    for command in [176, 400, 176, 511, 511] {
        rig.ack(command, AckResult::Accepted);
    }
    rig.ack(511, AckResult::Denied);
    rig.ack(511, AckResult::Denied);
    rig.heartbeat(mode::GUIDED, true);
    assert!(matches!(rig.state(), DriveState::Ready(_)));

    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    for command in [176, 400, 176] {
        rig.ack(command, AckResult::Accepted);
    }
    rig.ack(511, AckResult::Denied);
    assert_eq!(rig.refusal(), "message 32 at 40 Hz denied");
}

#[test]
fn a_pre_arm_bit_that_never_rises_is_waited_for_only_so_long() {
    let mut rig = Rig::new();
    for _ in 0..59 {
        rig.heartbeat(mode::HOLD, false);
        rig.wait(Duration::from_secs(1));
        assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"));
    }
    rig.heartbeat(mode::HOLD, false);
    rig.wait(Duration::from_millis(1100));
    assert_eq!(rig.asked(), [Ask::Mode(mode::HOLD)], "the autopilot itself refuses if it must");
}

#[test]
fn a_human_who_takes_over_is_left_alone_until_they_let_go() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.drive(0.5);
    rig.heartbeat(mode::MANUAL, true);
    assert!(rig.setpoints().is_empty(), "not even what was decided before");
    assert_eq!(rig.refusal(), format!("MANUAL was set by {ELSE}"));
    rig.stays_alone(mode::MANUAL, true);
    rig.stays_alone(mode::HOLD, true);
    assert_eq!(rig.refusal(), format!("HOLD was set by {ELSE}"));
    rig.is_given_back();
}

#[test]
fn a_human_who_drives_at_first_contact_is_waited_for_until_hold() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::MANUAL, true);
    assert_eq!(rig.refusal(), "somebody drives it in mode MANUAL, waiting for HOLD");
    rig.stays_alone(mode::MANUAL, true);
    rig.heartbeat(mode::HOLD, true);
    rig.wait(Duration::from_millis(1001));
    assert_eq!(rig.asked(), [Ask::Mode(mode::HOLD)]);
}

#[test]
fn a_drive_that_is_disarmed_behind_our_back_stays_disarmed_until_it_is_given_back() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.text("EKF failsafe");
    rig.heartbeat(mode::HOLD, false);
    assert_eq!(rig.refusal(), format!("it was disarmed (mode HOLD) by {ELSE} (EKF failsafe)"));
    rig.stays_alone(mode::HOLD, false);
    rig.stays_alone(mode::GUIDED, false);
    assert_eq!(rig.refusal(), format!("it was disarmed (mode GUIDED) by {ELSE}"));
    rig.is_given_back();
}

#[test]
fn what_somebody_else_set_outlasts_silence_and_a_restart_of_the_autopilot_ends_it() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(60_000);
    rig.heartbeat(mode::HOLD, true);
    rig.wait(Duration::from_secs(5));
    assert_eq!(*rig.state(), DriveState::Silent);
    rig.heartbeat(mode::HOLD, true);
    assert_eq!(rig.refusal(), format!("HOLD was set by {ELSE}"));
    rig.position(66_000);
    rig.stays_alone(mode::HOLD, true);
    rig.position(900);
    assert_eq!(*rig.state(), DriveState::Silent);
    rig.heartbeat(mode::MANUAL, false);
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"));
}

#[test]
fn a_mode_that_changed_while_the_link_was_silent_is_somebody_elses_too() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(60_000);
    rig.wait(Duration::from_secs(5));
    assert_eq!(*rig.state(), DriveState::Silent);
    rig.heartbeat(mode::HOLD, true);
    assert_eq!(rig.refusal(), format!("HOLD was set by {ELSE}"));
    rig.stays_alone(mode::HOLD, true);
    rig.is_given_back();
}

#[test]
fn a_link_that_is_back_finds_the_drive_ours_and_asks_for_no_mode() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.wait(Duration::from_secs(1));
    rig.sent();
    assert_eq!(*rig.state(), DriveState::Silent);
    rig.is_given_back();
}

#[test]
fn hold_that_comes_while_telemetry_is_asked_for_anew_is_respected() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.wait(Duration::from_secs(1));
    rig.heartbeat(mode::GUIDED, true);
    rig.ack(511, AckResult::Accepted);
    rig.sent();
    rig.heartbeat(mode::HOLD, true);
    assert_eq!(rig.refusal(), format!("HOLD was set by {ELSE}"));
    rig.ack(511, AckResult::Accepted);
    rig.stays_alone(mode::HOLD, true);
    rig.wait(Duration::from_millis(100));
    rig.is_given_back();
}

#[test]
fn telemetry_that_is_refused_after_the_return_never_leads_to_a_mode_being_set() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.wait(Duration::from_secs(1));
    rig.heartbeat(mode::GUIDED, true);
    rig.ack(511, AckResult::Denied);
    assert_eq!(rig.refusal(), "message 32 at 40 Hz denied");
    rig.sent();
    rig.wait(Duration::from_millis(500));
    rig.heartbeat(mode::HOLD, false);
    assert_eq!(rig.refusal(), format!("it was disarmed (mode HOLD) by {ELSE}"));
    rig.stays_alone(mode::HOLD, false);
}

#[test]
fn a_restart_shows_in_answered_time_questions_where_telemetry_is_off() {
    let mut rig = Rig::new();
    rig.bring_up();
    for now_ns in [90_000_000_000, 95_000_000_000, 2_000_000_000] {
        assert!(matches!(rig.state(), DriveState::Ready(_)), "before {now_ns}");
        let asked_ns = rig.time_question();
        rig.say(&Telemetry::Time { now_ns, asked_ns, to: HOST });
    }
    assert_eq!(*rig.state(), DriveState::Silent);
    rig.heartbeat(mode::MANUAL, false);
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"));
    let asked_ns = rig.time_question();
    rig.say(&Telemetry::Time { now_ns: 7_000_000_000, asked_ns, to: HOST });
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"), "noticed once");
}

#[test]
fn an_autopilot_that_falls_silent_is_lost_within_the_link_timeout_and_found_again() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(1000);
    rig.wait(Duration::from_millis(499));
    assert!(matches!(rig.state(), DriveState::Ready(_)));
    rig.drive(0.5);
    rig.wait(Duration::from_millis(1));
    assert_eq!(*rig.state(), DriveState::Silent);
    assert!(rig.setpoints().is_empty());
    rig.is_given_back();
}

#[test]
fn telemetry_without_heartbeats_does_not_keep_a_link_alive() {
    let mut rig = Rig::new();
    rig.bring_up();
    for step in 0..40 {
        rig.position(1000 + step * 100);
        rig.wait(Duration::from_millis(100));
    }
    assert_eq!(*rig.state(), DriveState::Silent);
}

#[test]
fn an_autopilot_that_restarts_is_brought_up_from_the_start() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(60_000);
    rig.position(61_000);
    rig.drive(0.5);
    rig.position(900);
    assert_eq!(*rig.state(), DriveState::Silent);
    assert!(rig.setpoints().is_empty());
    rig.heartbeat(mode::MANUAL, false);
    assert_eq!(*rig.state(), DriveState::BringUp("waiting for pre-arm check"), "what it knew before is gone");
}

#[test]
fn messages_that_overtake_each_other_are_no_restart() {
    let mut rig = Rig::new();
    rig.bring_up();
    for boot_ms in [60_000, 59_950, 60_025, 59_100, 60_050] {
        rig.position(boot_ms);
    }
    assert!(matches!(rig.state(), DriveState::Ready(_)));
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(u32::MAX - 10);
    rig.position(15);
    assert!(matches!(rig.state(), DriveState::Ready(_)), "its clock wraps after 49 days");
}

#[test]
fn rates_that_somebody_else_changed_are_asked_for_again() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.position(1000);
    rig.wait(Duration::from_millis(400));
    rig.heartbeat(mode::GUIDED, true);
    rig.wait(Duration::from_millis(100));
    assert_eq!(rig.asked(), [interval(32, 25_000), interval(30, 25_000)]);
    assert!(matches!(rig.state(), DriveState::Ready(_)));
}

#[test]
fn another_vehicle_is_refused_by_name_and_never_commanded() {
    let golden = vectors(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/device.txt")));
    let mut rig = Rig::new();
    rig.host.handle_datagram(rig.now, &golden["heartbeat_unknown_enums"].bytes);
    assert_eq!(rig.refusal(), "vehicle type 250 with autopilot 251 is not an ArduPilot ground rover");
    rig.wait(Duration::from_secs(3));
    assert!(rig.sent().is_empty());
}

#[test]
fn only_the_own_autopilot_and_the_own_lidar_are_listened_to() {
    let mut rig = Rig::new();
    let heartbeat = Telemetry::Heartbeat { custom_mode: mode::HOLD, armed: false };
    let beams = vec![Beam::Hit(1.0); 72];
    let scan = Scan {
        stamp: Stamp::ZERO,
        angle_first_rad: 0.0,
        angle_step_rad: 5.0_f64.to_radians(),
        range_m_min: 0.1,
        range_m_max: 9.0,
        beams,
    };
    let obstacles = Telemetry::Obstacles { boot_us: 0, scan };
    for (system, component) in [(8, 1), (7, 2), (7, 191), (255, 190)] {
        let mut other = Speaker::new(MavId { system, component });
        rig.host.handle_datagram(rig.now, &other.encode(&heartbeat));
        rig.host.handle_datagram(rig.now, &other.encode(&obstacles));
    }
    let mut bridge = Speaker::new(MavId { system: 7, component: 196 });
    rig.host.handle_datagram(rig.now, &bridge.encode(&heartbeat));
    rig.say(&obstacles);
    assert_eq!(*rig.state(), DriveState::Silent);
    assert_eq!(rig.host.poll_event(), None);
    rig.host.handle_datagram(rig.now, &bridge.encode(&obstacles));
    assert!(matches!(rig.host.poll_event(), Some(Event::Scan(_))));
    assert_eq!(rig.host.counters().foreign, 8);
}

#[test]
fn acknowledgements_for_somebody_else_count_for_nothing() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.prearm(true);
    rig.sent();
    let to = MavId { system: 255, component: 190 };
    rig.say(&Telemetry::Ack { command: 176, result: AckResult::Accepted, to });
    rig.ack(400, AckResult::Accepted);
    assert!(rig.sent().is_empty());
    assert_eq!(*rig.state(), DriveState::BringUp("setting HOLD"));
    assert_eq!(rig.host.counters().stray_acks, 2);
}

#[test]
fn an_orderly_end_stops_holds_disarms_and_brings_nothing_up_again() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.drive(0.5);
    rig.host.shutdown(rig.now);
    let sent = rig.sent();
    assert!(matches!(&sent[0], Inbound::Setpoint(it) if it.demand(&Pose::default()) == Demand::Twist(Twist::ZERO)));
    let asks = [Ask::Mode(mode::HOLD), Ask::Arm { arm: false, force: false }];
    assert_eq!(sent[1..], asks.map(|ask| Inbound::Command(Command { id: id_of(ask), ask })));
    rig.heartbeat(mode::GUIDED, true);
    rig.wait(Duration::from_millis(401));
    assert_eq!(rig.asked(), asks, "again, until its heartbeat shows it");
    rig.heartbeat(mode::HOLD, false);
    rig.wait(Duration::from_secs(10));
    rig.heartbeat(mode::HOLD, false);
    rig.drive(0.5);
    rig.wait(Duration::from_secs(1));
    assert!(rig.sent().is_empty());
}

#[test]
fn an_orderly_end_leaves_a_drive_alone_that_somebody_else_has_taken() {
    let mut rig = Rig::new();
    rig.bring_up();
    rig.heartbeat(mode::MANUAL, true);
    rig.sent();
    rig.host.shutdown(rig.now);
    rig.wait(Duration::from_secs(3));
    assert!(rig.asked().is_empty(), "somebody drives it");
    assert!(rig.sent().iter().all(|it| !matches!(it, Inbound::Setpoint(_))));
}

fn id_of(ask: Ask) -> u16 {
    match ask {
        Ask::Mode(_) => 176,
        Ask::Arm { .. } => 400,
        Ask::Interval { .. } | Ask::Message(_) | Ask::Unknown => 0,
    }
}

#[test]
fn the_emergency_stop_is_a_zero_setpoint() {
    let rig = Rig::new();
    let mut counters = WireCounters::default();
    let stop = decode(7, rig.host.stop_bytes(), &mut counters)[0].what;
    assert!(matches!(stop, Inbound::Setpoint(it) if it.demand(&Pose::default()) == Demand::Twist(Twist::ZERO)));
}

#[test]
fn the_host_speaks_first_and_once_a_second() {
    let mut rig = Rig::new();
    rig.wait(Duration::from_millis(5500));
    let mut sequence = Vec::new();
    while let Some(bytes) = rig.host.poll_output() {
        assert_eq!((bytes[5], bytes[6], bytes[7]), (7, 191, 0), "a heartbeat of ours");
        sequence.push(bytes[4]);
    }
    assert_eq!(sequence, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn a_time_question_comes_back_as_a_round_trip() {
    let mut rig = Rig::new();
    rig.heartbeat(mode::HOLD, false);
    rig.wait(Duration::from_millis(1001));
    let mut counters = WireCounters::default();
    let all = std::iter::from_fn(|| rig.host.poll_output()).flat_map(|bytes| decode(7, &bytes, &mut counters));
    let asked =
        all.filter_map(|it| if let Inbound::TimeQuestion { asked_ns } = it.what { Some(asked_ns) } else { None });
    let asked_ns = asked.last().expect("a question");
    rig.now = rig.now + Duration::from_millis(12);
    rig.say(&Telemetry::Time { now_ns: 77, asked_ns: 1, to: HOST });
    assert_eq!(rig.host.round_trip(), None, "an answer to nothing");
    rig.say(&Telemetry::Time { now_ns: 77, asked_ns, to: HOST });
    assert_eq!(rig.host.round_trip(), Some(Duration::from_millis(13)));
}

#[test]
fn nothing_that_arrives_makes_the_host_panic_grow_or_forget() {
    let file = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/device.txt"));
    let frames: Vec<Vec<u8>> = vectors(file).into_values().map(|golden| golden.bytes).collect();
    let mut rig = Rig::new();
    rig.bring_up();
    let mut state = 7_u64;
    let mut chance = move |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..30_000 {
        let mut bytes = frames[chance(frames.len())].clone();
        bytes.truncate(1 + chance(bytes.len()));
        let at = chance(bytes.len());
        bytes[at] ^= 1 << chance(8);
        bytes.splice(at..at, (0..chance(4)).map(|_| 0xFD));
        rig.host.handle_datagram(rig.now, &bytes);
    }
    rig.host.handle_datagram(rig.now, &[0xFD; 100_000]);
    rig.host.handle_datagram(rig.now, &[]);
    let events = std::iter::from_fn(|| rig.host.poll_event()).count();
    assert!(events <= 256, "{events}");
    assert!(matches!(rig.state(), DriveState::Ready(_)), "a broken frame changes nothing");
    let counters = rig.host.counters().wire;
    assert!(counters.broken > 10_000 && counters.truncated > 1_000 && counters.noise > 100, "{counters:?}");
}

#[test]
fn several_frames_with_garbage_between_them_are_all_heard() {
    let mut rig = Rig::new();
    let heartbeat = rig.autopilot.encode(&Telemetry::Heartbeat { custom_mode: mode::HOLD, armed: false });
    let status = rig.autopilot.encode(&Telemetry::SysStatus {
        prearm_ok: true,
        obstacles_ok: true,
        battery: Battery::default(),
    });
    let unknown = [0xFD, 2, 0, 0, 0, 7, 1, 0x20, 0xCB, 0, 1, 2, 9, 9];
    let datagram = [&[0xFE, 0xFD, 1][..], &heartbeat, &unknown, &[0x55; 9], &status, &[0xFD, 9]].concat();
    rig.host.handle_datagram(rig.now, &datagram);
    assert_eq!(*rig.state(), DriveState::BringUp("setting HOLD"));
    let counters = rig.host.counters().wire;
    assert_eq!((counters.frames, counters.unknown), (2, 1));
}

#[test]
fn outputs_that_nobody_fetches_stay_bounded() {
    let mut rig = Rig::new();
    rig.wait(Duration::from_secs(1000));
    assert_eq!(std::iter::from_fn(|| rig.host.poll_output()).count(), 64);
    assert_eq!(rig.host.counters().outputs_dropped, 937);
}
