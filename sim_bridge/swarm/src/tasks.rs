//! Robots as tasks of this process: the same loop and the same links as in the field, beacons over the modelled radio.

use crate::ether::Ether;
use drover_bridge::{CanEnd, NearSide, PlantHandle};
use drover_config::RobotFile;
use drover_contract::{Clock, Link};
use drover_io::{MemoryLink, OpenError, PacedClock, memory_link};
use drover_record::Recorder;
use drover_robot::{Assembled, Assembly, Guard, Hardware, Report, Shutdown, Teller, View, assemble, drive};
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

/// Messages that a beacon link keeps for a robot that does not read.
const BEACON_QUEUE: usize = 1024;
/// How often the ether carries beacons on.
const ETHER_PERIOD: Duration = Duration::from_millis(5);

/// How often a robot tells how it is doing.
const VIEW_PERIOD: Duration = Duration::from_millis(50);

/// What a running robot tells: its index and its newest view.
pub(crate) type ViewSender = mpsc::Sender<(usize, View)>;

/// What every task of a run is given.
pub(crate) struct TaskContext<'a> {
    pub(crate) clock: &'a PacedClock,
    pub(crate) guard: &'a Guard,
    pub(crate) views: ViewSender,
    pub(crate) end: watch::Receiver<Option<Shutdown>>,
    pub(crate) recorder: Option<&'a Recorder>,
    pub(crate) epoch: u32,
}

/// Open one robot's links and put its loop together; nothing runs yet.
pub(crate) fn prepare(
    file: RobotFile,
    near: NearSide,
    beacons: Box<dyn Link>,
    context: &TaskContext<'_>,
) -> Result<Assembled, OpenError> {
    let hardware = hardware(near)?;
    let now = context.clock.now();
    let recording = context.recorder.map(|recorder| recorder.robot(&file, context.epoch, now));
    assemble(Assembly { file, hardware, beacons, epoch: context.epoch, recording }, now)
}

/// Start robot `index`'s loop.
pub(crate) fn start(index: usize, robot: Assembled, context: &TaskContext<'_>) -> JoinHandle<Option<Report>> {
    let heart = context.guard.add(robot.robot.file().robot.id, robot.hang_limit, robot.stop);
    let (views, end, clock) = (context.views.clone(), context.end.clone(), context.clock.clone());
    let tell = move |view: View| {
        // A full queue drops this view; the next one is newer anyway.
        let _ = views.try_send((index, view));
    };
    let teller = Teller { period: VIEW_PERIOD, tell };
    tokio::spawn(async move { Some(drive(robot.robot, clock, heart, end, teller).await) })
}

fn hardware(near: NearSide) -> Result<Hardware, OpenError> {
    if let Some(links) = near.links() {
        return Hardware::open(&links);
    }
    match near {
        NearSide::Can { drive: CanEnd::Node(drive), lidar: CanEnd::Node(lidar) } => {
            let stop = Box::new(drive.sibling());
            Ok(Hardware::Can { drive: Box::new(drive), lidar: Box::new(lidar), stop })
        }
        NearSide::Mavlink(address)
        | NearSide::Can { drive: CanEnd::Address(address), .. }
        | NearSide::Can { lidar: CanEnd::Address(address), .. } => {
            Err(OpenError::new(address, "one bus in memory and one elsewhere", "give both addresses or none"))
        }
    }
}

/// Beacon links of `count` robots: the robots' ends, and the ether's.
pub(crate) fn beacon_links(count: usize) -> (Vec<MemoryLink>, Vec<MemoryLink>) {
    (0..count).map(|_| memory_link(BEACON_QUEUE)).unzip()
}

/// Carry beacons until the run's task is aborted; what is sent to `said` is said to every robot at once, as by a
/// transmitter that stands beside it.
pub(crate) async fn carry_beacons(
    mut ether: Ether,
    plant: PlantHandle,
    clock: PacedClock,
    mut said: mpsc::Receiver<Vec<u8>>,
) {
    let mut ticker = tokio::time::interval(ETHER_PERIOD);
    ticker.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    loop {
        ticker.tick().await;
        while let Ok(message) = said.try_recv() {
            ether.say_to_all(&message);
        }
        let positions_w = plant.positions();
        ether.turn(clock.now(), &positions_w[..]);
    }
}
