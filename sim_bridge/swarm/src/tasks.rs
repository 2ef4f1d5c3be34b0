//! Robots as tasks of this process: the same loop and the same links as in the field, beacons over the modelled radio.

use crate::ether::Ether;
use drover_bridge::{CanEnd, NearSide, PlantHandle};
use drover_config::RobotFile;
use drover_contract::{Clock, Link};
use drover_io::{MemoryLink, OpenError, OsClock, Recorder, memory_link};
use drover_robot::{Assembly, Guard, Hardware, Report, Shutdown, View, assemble, drive};
use drover_world::Radio;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

/// Messages that a beacon link keeps for a robot that does not read.
const BEACON_QUEUE: usize = 1024;
/// How often the ether carries beacons on.
const ETHER_PERIOD: Duration = Duration::from_millis(5);

/// What a running robot tells: its index and its newest view.
pub(crate) type ViewSender = mpsc::Sender<(usize, View)>;

/// What every task of a run is given.
pub(crate) struct TaskContext<'a> {
    pub(crate) clock: &'a OsClock,
    pub(crate) guard: &'a Guard,
    pub(crate) views: ViewSender,
    pub(crate) end: watch::Receiver<Option<Shutdown>>,
    pub(crate) recorder: Option<&'a Recorder>,
    pub(crate) epoch: u32,
}

/// Start one robot's loop.
pub(crate) fn spawn(
    index: usize,
    file: RobotFile,
    near: NearSide,
    beacons: Box<dyn Link>,
    context: &TaskContext<'_>,
) -> Result<JoinHandle<Report>, OpenError> {
    let hardware = hardware(near)?;
    let assembly = Assembly { file, hardware, beacons, epoch: context.epoch, recorder: context.recorder };
    let opened = assemble(assembly, context.clock)?;
    let id = opened.robot.file().robot.id;
    let heart = context.guard.add(id, opened.hang_limit, opened.stop);
    let (views, end, clock) = (context.views.clone(), context.end.clone(), *context.clock);
    let tell = move |view: View| {
        // A full queue drops this view; the next one is newer anyway.
        let _ = views.try_send((index, view));
    };
    Ok(tokio::spawn(drive(opened.robot, clock, heart, end, tell)))
}

fn hardware(near: NearSide) -> Result<Hardware, OpenError> {
    match near {
        NearSide::Mavlink(address) => Hardware::open(&drover_config::Links::Mavlink { autopilot: address }),
        NearSide::Can { drive: CanEnd::Node(drive), lidar: CanEnd::Node(lidar) } => {
            let stop = Box::new(drive.sibling());
            Ok(Hardware::Can { drive: Box::new(drive), lidar: Box::new(lidar), stop })
        }
        NearSide::Can { drive, lidar } => {
            let address = |end: CanEnd| match end {
                CanEnd::Address(address) => address,
                CanEnd::Node(_) => String::new(),
            };
            Hardware::open(&drover_config::Links::Can { drive: address(drive), lidar: address(lidar) })
        }
    }
}

/// Beacon links of `count` robots: the robots' ends, and the ether's.
pub(crate) fn beacon_links(count: usize) -> (Vec<MemoryLink>, Vec<MemoryLink>) {
    (0..count).map(|_| memory_link(BEACON_QUEUE)).unzip()
}

/// Carry beacons until the run's task is aborted.
pub(crate) async fn carry_beacons(ends: Vec<MemoryLink>, radio: Radio, plant: PlantHandle, clock: OsClock) {
    let mut ether = Ether::new(radio, ends);
    let mut ticker = tokio::time::interval(ETHER_PERIOD);
    ticker.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    loop {
        ticker.tick().await;
        let positions_w = plant.positions();
        ether.turn(clock.now(), &positions_w);
    }
}

