//! A robot's loop, fed with what its tape says that it was given: turn by turn, at the same times.

use crate::assemble::{Assembly, Hardware, assemble};
use crate::robot_loop::RobotLoop;
use crate::witness::{Recording, Witness};
use drover_config::{Links, RobotFile};
use drover_contract::{CanBus, Clock, Link, Stamp};
use drover_core::StopReason;
use drover_io::{
    MemoryBus, MemoryLink, MemoryNode, OpenError, Tape, TapeEntry, TapeEvent, TapePort, TapeSink, frame_of, memory_link,
};
use std::cell::Cell;
use std::sync::{Arc, Mutex, PoisonError};

/// Messages of one turn and port at most: more than a loop reads.
const QUEUE: usize = 8192;

/// Run the robot of `file` again, in its life `epoch` that began at `began`, on what `tape` says that it was given.
/// What the new run's own tape holds: with the same code, the same entries. `witness` sees it decide.
///
/// # Errors
/// [`OpenError`] if the file's links do not fit its kind.
pub fn rerun(
    file: RobotFile,
    (epoch, began): (u32, Stamp),
    tape: &[TapeEntry],
    witness: Box<dyn Witness>,
) -> Result<Vec<TapeEntry>, OpenError> {
    let kept = Arc::new(Kept::default());
    let recording = Recording { tape: Tape::new(file.robot.id, kept.clone()), witness };
    let (hardware, mut far) = FarEnds::of(&file.robot.links);
    let (beacons, far_beacons) = memory_link(QUEUE);
    far.beacons = Some(far_beacons);
    let assembly = Assembly { file, hardware, beacons: Box::new(beacons), epoch, recording: Some(recording) };
    let mut robot = assemble(assembly, began)?.robot;
    let mut rest = tape;
    while let Some((turn, after)) = next_turn(rest) {
        give(&mut robot, &mut far, turn);
        rest = after;
    }
    drop(robot);
    Ok(std::mem::take(&mut *kept.0.lock().unwrap_or_else(PoisonError::into_inner)))
}

/// The entries up to the next turn's beginning, and those from there.
fn next_turn(entries: &[TapeEntry]) -> Option<(&[TapeEntry], &[TapeEntry])> {
    if entries.is_empty() {
        return None;
    }
    let ends = entries.iter().skip(1).position(|entry| entry.event == TapeEvent::Turn);
    Some(entries.split_at(ends.map_or(entries.len(), |at| at + 1)))
}

/// One turn: what was received is there before it begins, and the clock shows what it showed.
fn give(robot: &mut RobotLoop, far: &mut FarEnds, entries: &[TapeEntry]) {
    let mut clock = Readings::default();
    let mut turns = false;
    let mut told = None;
    for entry in entries {
        match &entry.event {
            TapeEvent::Turn => {
                turns = true;
                clock.push(entry.stamp);
            }
            TapeEvent::Clock => clock.push(entry.stamp),
            TapeEvent::Received(port, bytes) => far.send(*port, bytes),
            TapeEvent::Sent(..) => {}
            TapeEvent::ToldToEnd(why) => told = Some((entry.stamp, reason(why))),
        }
    }
    if turns {
        robot.turn(&clock);
    }
    far.drain();
    // It is told between two turns.
    if let Some((stamp, reason)) = told {
        robot.begin_end(stamp, reason);
    }
}

fn reason(words: &str) -> StopReason {
    match words {
        "operator" => StopReason::Operator,
        "shutdown" => StopReason::Shutdown,
        _ => StopReason::Fault("as recorded"),
    }
}

/// Keeps what the new run tapes.
#[derive(Default)]
struct Kept(Mutex<Vec<TapeEntry>>);

impl TapeSink for Kept {
    fn take(&self, _robot: u32, entries: Vec<TapeEntry>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(entries);
    }
}

/// Shows one after the other what a clock showed; the last for ever.
#[derive(Default)]
struct Readings {
    stamps: Vec<Stamp>,
    next: Cell<usize>,
}

impl Readings {
    fn push(&mut self, stamp: Stamp) {
        self.stamps.push(stamp);
    }
}

impl Clock for Readings {
    fn now(&self) -> Stamp {
        let at = self.next.get();
        self.next.set(at + 1);
        let shown = self.stamps.get(at).or(self.stamps.last());
        shown.copied().unwrap_or_default()
    }
}

/// The other ends of a robot's links.
#[derive(Default)]
struct FarEnds {
    autopilot: Option<MemoryLink>,
    drive: Option<MemoryNode>,
    lidar: Option<MemoryNode>,
    beacons: Option<MemoryLink>,
}

impl FarEnds {
    fn of(links: &Links) -> (Hardware, Self) {
        match links {
            Links::Mavlink { .. } => {
                let (near, far) = memory_link(QUEUE);
                let stop = Box::new(|_: &[u8]| {});
                let ends = Self { autopilot: Some(far), ..Self::default() };
                (Hardware::Mavlink { link: Box::new(near), stop }, ends)
            }
            Links::Can { .. } => {
                let (drive, lidar) = (MemoryBus::new(QUEUE), MemoryBus::new(QUEUE));
                let ends = Self { drive: Some(drive.node()), lidar: Some(lidar.node()), ..Self::default() };
                let stop = Box::new(MemoryBus::new(1).node());
                let hardware = Hardware::Can { drive: Box::new(drive.node()), lidar: Box::new(lidar.node()), stop };
                (hardware, ends)
            }
        }
    }

    fn send(&mut self, port: TapePort, bytes: &[u8]) {
        let frame = || frame_of(bytes);
        // What cannot be given shows as a difference of the two tapes.
        let _ = match port {
            TapePort::Autopilot => self.autopilot.as_mut().map(|link| link.send(bytes)),
            TapePort::Beacons => self.beacons.as_mut().map(|link| link.send(bytes)),
            TapePort::DriveBus => self.drive.as_mut().zip(frame()).map(|(bus, frame)| bus.send(&frame)),
            TapePort::LidarBus => self.lidar.as_mut().zip(frame()).map(|(bus, frame)| bus.send(&frame)),
        };
    }

    /// Nobody reads what the robot sends: its tape has it.
    fn drain(&mut self) {
        let mut buf = [0; 2048];
        for link in [&mut self.autopilot, &mut self.beacons].into_iter().flatten() {
            while let Ok(Some(_)) = link.try_recv(&mut buf) {}
        }
        for bus in [&mut self.drive, &mut self.lidar].into_iter().flatten() {
            while let Ok(Some(_)) = bus.try_recv() {}
        }
    }
}
