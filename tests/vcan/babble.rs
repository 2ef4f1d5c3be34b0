//! Somebody else on both buses who says anything at all.

use crate::scout::{Scout, lives};
use crate::support::Driven;
use drover_contract::{CanBus, CanFrame, CanId};
use drover_io::SocketCanBus;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// Frames a second on each bus.
const RATE_HZ: u64 = 500;
/// Everything that an AgileX chassis says. What its host says is left out: no robot can keep a stranger who commands
/// its chassis from doing so.
const CHASSIS: [u16; 14] =
    [0x211, 0x221, 0x231, 0x241, 0x251, 0x252, 0x253, 0x254, 0x261, 0x262, 0x311, 0x361, 0x362, 0x151];

/// What is said.
#[derive(Clone, Copy)]
enum Talk {
    /// Any identifier, any bytes.
    Noise,
    /// The identifiers of the chassis and of the lidar node, any bytes.
    Forged,
}

/// A thread that talks until it is told to end.
struct Babbler {
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<u64>>,
}

impl Babbler {
    fn start(scout: &Scout, talk: Talk) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let (ended, interfaces) = (Arc::clone(&end), [scout.drive.clone(), scout.lidar.clone()]);
        let thread = std::thread::spawn(move || {
            let mut buses = interfaces.map(|name| SocketCanBus::open(&name).expect("an interface that is up"));
            let mut chance = Pcg32::seed_from_u64(7);
            let mut sent = 0;
            while !ended.load(Ordering::Relaxed) {
                // Several at once, for a sleep is not that short.
                for _ in 0..RATE_HZ / 100 {
                    for bus in &mut buses {
                        // A full queue is a busy bus; there is enough noise without this frame.
                        sent += u64::from(bus.send(&frame(&mut chance, talk)).is_ok());
                    }
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            sent
        });
        Self { end, thread: Some(thread) }
    }

    /// Silence; how many frames were sent.
    fn end(mut self) -> u64 {
        self.end.store(true, Ordering::Relaxed);
        self.thread.take().expect("it ends once").join().expect("it does not panic")
    }
}

impl Drop for Babbler {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
    }
}

fn frame(chance: &mut Pcg32, talk: Talk) -> CanFrame {
    let id = match (talk, chance.random_bool(0.5)) {
        (Talk::Noise, true) => CanId::Standard(chance.random_range(0..0x800)),
        (Talk::Noise, false) => CanId::Extended(chance.random_range(0..0x2000_0000)),
        (Talk::Forged, true) => CanId::Standard(CHASSIS[chance.random_range(0..CHASSIS.len())]),
        // NodeStatus, range Measurement and Proximity of DroneCAN, from the lidar's own node id.
        (Talk::Forged, false) => {
            let kinds = [341_u32, 1_050, 21_910];
            CanId::Extended((0x10 << 24) | (kinds[chance.random_range(0..kinds.len())] << 8) | 42)
        }
    };
    let mut data = [0_u8; 8];
    data.iter_mut().for_each(|byte| *byte = chance.random());
    let length = chance.random_range(0..=8);
    CanFrame::new(id, &data[..length]).expect("a frame within bounds")
}

/// It lives, it goes on telling how it is, and nothing of it has panicked.
fn assert_well(robot: &Driven, scout: &Scout) {
    assert!(lives(robot), "{}", robot.errors());
    assert!(!robot.errors().contains("panicked"), "{}", robot.errors());
    let ticks = |robot: &Driven| robot.view().and_then(|view| view["ticks"].as_u64()).unwrap_or_default();
    let before = ticks(robot);
    std::thread::sleep(Duration::from_millis(500));
    assert!(ticks(robot) > before, "it ticks no more: {:#}", robot.view().unwrap_or_default());
    assert!(!scout.touched(), "it drove into a wall");
}

#[test]
fn a_stranger_who_babbles_on_both_buses_does_not_keep_the_robot_from_driving() {
    let (scout, robot) = Scout::driving();
    let path_m = |scout: &Scout| scout.place.plant.with(|plant| plant.truth(0).path_m);
    let before_m = path_m(&scout);
    let babbler = Babbler::start(&scout, Talk::Noise);
    std::thread::sleep(Duration::from_secs(5));
    assert_well(&robot, &scout);
    let sent = babbler.end();
    let driven_m = path_m(&scout) - before_m;
    println!("{sent} frames of noise in 5.5 s; it drove {driven_m:.2} m meanwhile");
    assert!(sent > 2_000, "only {sent} frames");
    assert!(driven_m > 1.0, "it drove {driven_m:.2} m in 5.5 s");
    assert_eq!(robot.terminate(), Some(130), "stopped, and seen to stop");
    assert!(!scout.place.moves(0));
}

#[test]
fn a_stranger_who_speaks_as_the_chassis_and_the_lidar_breaks_nothing_and_the_robot_ends_standing() {
    let (scout, robot) = Scout::driving();
    let babbler = Babbler::start(&scout, Talk::Forged);
    std::thread::sleep(Duration::from_secs(5));
    assert_well(&robot, &scout);
    println!("{} forged frames; at last {}", babbler.end(), robot.view().unwrap_or_default()["reason"]);
    // Half a transfer and a forged state are forgotten within the link's timeout; then an operator ends it.
    std::thread::sleep(Duration::from_millis(1_500));
    assert_eq!(robot.terminate(), Some(130), "stopped, and seen to stop");
    assert!(!scout.place.moves(0));
}
