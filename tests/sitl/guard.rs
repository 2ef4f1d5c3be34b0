//! A loop that panics or hangs, mid-run, measured at the body: the guard's stop, not the drive's watchdog.

use crate::common::{Place, first_swarm};
use drover_bridge::NearSide;
use drover_config::Links;
use drover_contract::{Clock, Link, LinkError};
use drover_io::{OsClock, memory_link};
use drover_robot::{Assembly, Guard, Hardware, Report, Shutdown, Teller, assemble, drive};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::runtime::Runtime;
use tokio::sync::watch;
use tokio::task::JoinHandle;

const CALM: u8 = 0;
const PANIC: u8 = 1;
const HANG: u8 = 2;

/// A link that makes its loop panic or hang when it is told to.
struct Trap<L> {
    inner: L,
    trigger: Arc<AtomicU8>,
}

impl<L: Link> Link for Trap<L> {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        match self.trigger.load(Ordering::Relaxed) {
            PANIC => panic!("the trap has sprung"),
            HANG => std::thread::sleep(Duration::from_secs(60)),
            _ => {}
        }
        self.inner.try_recv(buf)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.inner.send(bytes)
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }
}

/// The leader's loop in this process, under way.
struct Trapped {
    place: Place,
    trigger: Arc<AtomicU8>,
    report: JoinHandle<Report>,
    runtime: Runtime,
    _guard: Guard,
    _end: watch::Sender<Option<Shutdown>>,
}

fn under_way() -> Trapped {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(first_swarm(folder.path(), &[]), folder);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("a runtime");
    let NearSide::Mavlink(autopilot) = &place.near_sides[0] else { panic!("the leader speaks MAVLink") };
    let _context = runtime.enter();
    let hardware = Hardware::open(&Links::Mavlink { autopilot: autopilot.clone() }).expect("a free port");
    let Hardware::Mavlink { link, stop } = hardware else { panic!("a MAVLink link") };
    let trigger = Arc::new(AtomicU8::new(CALM));
    let link = Box::new(Trap { inner: link, trigger: Arc::clone(&trigger) });
    let (beacons, _) = memory_link(8);
    let file = place.swarm().robot_file(1).expect("robot 1");
    let hardware = Hardware::Mavlink { link, stop };
    let assembly = Assembly { file, hardware, beacons: Box::new(beacons), epoch: 1, recording: None };
    let clock = OsClock::new();
    let robot = assemble(assembly, clock.now()).expect("it fits");
    let guard = Guard::start().expect("a thread");
    let heart = guard.add(1, robot.hang_limit, robot.stop);
    let (end, end_seen) = watch::channel(None);
    let teller = Teller { period: Duration::from_secs(1), tell: |_| {} };
    let report = runtime.spawn(drive(robot.robot, clock, heart, end_seen, teller));
    place.wait("the leader drives", 30.0, |place| place.speed_mps(0) > 0.3);
    Trapped { place, trigger, report, runtime, _guard: guard, _end: end }
}

/// docs/safety.md: guard, way to the wheels, brake; and 0.1 s for a noisy machine.
fn bound_s(trapped: &Trapped, guard_s: f64) -> f64 {
    let motion = trapped.place.swarm().kind_of(&trapped.place.swarm().robots[0]).motion;
    guard_s + 0.02 + 0.1 + 0.1 + motion.speed_mps_max / motion.brake_mps2
}

#[test]
fn a_panic_is_caught_reported_and_followed_by_the_guards_stop() {
    let trapped = under_way();
    trapped.trigger.store(PANIC, Ordering::Relaxed);
    let (took_s, bound_s) = (trapped.place.last_motion_s(0, 5.0), bound_s(&trapped, 0.0));
    println!("stood {took_s:.2} s after the panic, bound {bound_s:.2} s");
    assert!(took_s <= bound_s, "moved for {took_s:.2} s after the panic; the bound is {bound_s:.2} s");
    let report = trapped.runtime.block_on(trapped.report).expect("the panic was caught");
    assert_eq!(report.panic.as_deref(), Some("the trap has sprung"));
    assert!(!report.seen_stopped);
}

#[test]
fn a_hanging_loop_is_stopped_from_outside_long_before_the_drives_watchdog() {
    let trapped = under_way();
    let tick_s = f64::from(trapped.place.swarm().kind_of(&trapped.place.swarm().robots[0]).timeouts.tick_ms) * 1e-3;
    trapped.trigger.store(HANG, Ordering::Relaxed);
    let (took_s, bound_s) = (trapped.place.last_motion_s(0, 5.0), bound_s(&trapped, 5.0 * tick_s));
    println!("stood {took_s:.2} s after the hang began, bound {bound_s:.2} s");
    assert!(took_s <= bound_s, "moved for {took_s:.2} s while its loop hung; the bound is {bound_s:.2} s");
    assert!(bound_s < 3.0, "a bound above the autopilot's own timeout would prove nothing about the guard");
    trapped.runtime.shutdown_background();
}
