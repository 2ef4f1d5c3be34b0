//! A swarm against the wall clock: open every link, start every robot, watch, end in good order, summarise.

use crate::children::ChildRobot;
use crate::ether::Ether;
use crate::recording::RunFolder;
use crate::summary::{RunFacts, Summary, Tally, summarise};
use crate::tasks::{TaskContext, ViewSender, beacon_links, carry_beacons, prepare, start};
use crate::watcher::Watcher;
use drover_bridge::{Bridge, BridgeError, CanBacking, CanChoice, NearSide, PlantHandle, pace};
use drover_config::Swarm;
use drover_contract::Clock;
use drover_io::{BeaconSocket, OpenError, PacedClock};
use drover_record::{Controls, Onlooker, Pace, Recorder, RecorderOptions, Setting};
use drover_robot::{Guard, Report, Shutdown, epoch_from_unix};
use std::future::Future;
use std::path::PathBuf;
use thiserror::Error;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

/// Views that may wait to be looked at.
const VIEW_QUEUE: usize = 4096;
/// Messages for all robots that may wait.
const SAYINGS: usize = 8;

/// How a swarm is brought up.
pub struct UpOptions<'a, W> {
    /// The `drover` binary, if every robot is to be a process of its own.
    pub processes: Option<PathBuf>,
    /// Whether anything is recorded.
    pub record: bool,
    /// Called about twenty times a second with the time, s, and what every robot last said, in the file's order.
    pub on_view: W,
    /// Somebody who looks on, and may ask things of the run.
    pub onlooker: Option<&'a mut dyn Onlooker>,
}

/// A swarm could not be brought up. Nothing has moved.
#[derive(Debug, Error)]
pub enum UpError {
    /// A firmware's link could not be opened.
    #[error(transparent)]
    Bridge(#[from] BridgeError),
    /// A robot's link could not be opened.
    #[error("robot {robot}: {source}")]
    Robot {
        /// Which robot.
        robot: u32,
        /// What went wrong and what to do.
        source: OpenError,
    },
    /// The beacon plane could not be joined.
    #[error("beacon plane: {0}")]
    Beacons(OpenError),
    /// The recording could not be made.
    #[error("recording: {0}")]
    Recording(OpenError),
    /// Folder, process or thread: what the system said.
    #[error("{0:#}")]
    System(#[from] anyhow::Error),
}

/// The robots' side of a run.
pub(crate) struct Robots {
    pub(crate) running: Vec<JoinHandle<Option<Report>>>,
    /// Watches robots that are tasks; a process has a guard of its own.
    _guard: Option<Guard>,
    pub(crate) ether: Option<JoinHandle<()>>,
}

/// Bring a swarm up, run it until every robot has reached the end, its duration is over, somebody who looks on asks for
/// another run, or `interrupt` is ready; stop every robot and see it stand; summarise.
///
/// # Errors
/// [`UpError`] if something the run needs is missing; nothing has moved then.
pub async fn up<W, I>(swarm: &Swarm, options: UpOptions<'_, W>, interrupt: I) -> Result<Summary, UpError>
where
    W: FnMut(f64, &[Tally]),
    I: Future<Output = ()>,
{
    let clock = PacedClock::new();
    let folder = if options.record || options.processes.is_some() { Some(RunFolder::create(swarm)?) } else { None };
    let recorder =
        folder.as_ref().filter(|_| options.record).map(|folder| record(folder, swarm, &clock)).transpose()?;
    let can = CanChoice::best(swarm, options.processes.is_some());
    let (bridge, near_sides) = Bridge::open(swarm, can.backing, clock.now())?;
    let plant = bridge.plant();
    let pacing = tokio::spawn(pace(bridge, clock.clone()));
    let (views, views_in) = mpsc::channel(VIEW_QUEUE);
    let (end, end_seen) = watch::channel(None);
    let (say, said) = mpsc::channel(SAYINGS);
    let processes = options.processes.clone();
    let start = Start {
        swarm,
        plant: &plant,
        clock: &clock,
        folder: folder.as_ref(),
        recorder: recorder.as_ref(),
        record: options.record,
        views,
        end: end_seen,
        said,
    };
    let robots = match &processes {
        None => start.tasks(near_sides)?,
        Some(binary) => start.processes(near_sides, binary)?,
    };
    let mut watcher = Watcher::new(swarm, &clock, &plant, views_in, say);
    watcher.recorder = recorder.as_ref();
    watcher.processes = processes.is_some();
    let mut eyes = options;
    if let Some(onlooker) = &mut eyes.onlooker {
        onlooker.begin(Setting::of_swarm(swarm, clock.unix_offset_us()), controls(processes.is_some()));
    }
    let (ended, time_s) = watcher.watch(&robots, &mut eyes, &end, interrupt).await;
    watcher.collect(robots).await;
    let facts = RunFacts {
        ended,
        time_s,
        world_rate: plant.with(|plant| plant.time().as_secs_f64()) / clock.now().as_secs_f64(),
        can: if can.backing == CanBacking::Vcan { "vcan" } else { "memory" },
        can_detail: can.words,
        processes: processes.is_some(),
        recording: folder
            .as_ref()
            .filter(|_| recorder.is_some())
            .map(|folder| folder.recording().display().to_string()),
        recording_dropped: 0,
        recording_failed: None,
    };
    let mut summary = plant.with(|plant| summarise(swarm, plant, (&watcher.tallies, &watcher.measures), facts));
    watcher.show_end(&mut eyes, &summary);
    pacing.abort();
    // Its ports are free once it is gone: another run may follow at once.
    let _ = pacing.await;
    keep(&mut summary, folder.as_ref(), recorder.as_ref());
    keep_maps(&watcher.tallies, folder.as_ref());
    Ok(summary)
}

/// What may be asked of a run: a robot's process has a clock of its own.
const fn controls(processes: bool) -> Controls {
    Controls { stop: true, pace: !processes, restart: true, seek: false }
}

fn record(folder: &RunFolder, swarm: &Swarm, clock: &PacedClock) -> Result<Recorder, UpError> {
    let unix_offset_us = clock.unix_offset_us();
    let options = RecorderOptions { path: folder.recording(), pace: Pace::RealTime, unix_offset_us };
    Recorder::create(options, &Setting::of_swarm(swarm, unix_offset_us)).map_err(UpError::Recording)
}

/// Write the summary into the recording and beside it.
fn keep(summary: &mut Summary, folder: Option<&RunFolder>, recorder: Option<&Recorder>) {
    if let (Some(recorder), Ok(document)) = (recorder, serde_json::to_value(&*summary)) {
        recorder.finish(&document);
        // The disk may have been full at the very end.
        let state = recorder.state();
        (summary.recording_dropped, summary.recording_failed) = (state.dropped, state.failed);
    }
    let Some(folder) = folder else { return };
    let text = serde_json::to_string_pretty(summary).unwrap_or_default();
    if let Err(error) = folder.write("summary.json", &text) {
        // The run is over and its summary is in our hands: a full disk must not take it from the user.
        tracing::error!("{error:#}");
    }
}

/// Write the maps that robots made beside the recording; a robot that is a process writes its own.
fn keep_maps(tallies: &[Tally], folder: Option<&RunFolder>) {
    let Some(folder) = folder else { return };
    for map in tallies.iter().filter_map(|tally| tally.report.as_ref()?.map.as_ref()) {
        if let Err(error) = map.write(folder.path()) {
            tracing::error!("a map was not written to {}: {error}", folder.path().display());
        }
    }
}

/// What is needed to start robots.
struct Start<'a> {
    swarm: &'a Swarm,
    plant: &'a PlantHandle,
    clock: &'a PacedClock,
    folder: Option<&'a RunFolder>,
    recorder: Option<&'a Recorder>,
    record: bool,
    views: ViewSender,
    end: watch::Receiver<Option<Shutdown>>,
    said: mpsc::Receiver<Vec<u8>>,
}

impl Start<'_> {
    fn tasks(self, near_sides: Vec<NearSide>) -> Result<Robots, UpError> {
        let guard = Guard::start().map_err(anyhow::Error::from)?;
        let (near_beacons, far_beacons) = beacon_links(self.swarm.robots.len());
        let context = TaskContext {
            clock: self.clock,
            guard: &guard,
            views: self.views,
            end: self.end,
            recorder: self.recorder,
            epoch: epoch_from_unix(),
        };
        // All links first, then all loops: a robot that cannot start keeps every other one standing.
        let mut prepared = Vec::new();
        for (robot, (near, beacons)) in self.swarm.robots.iter().zip(near_sides.into_iter().zip(near_beacons)) {
            let Some(file) = self.swarm.robot_file(robot.id) else { continue };
            let opened = prepare(file, near, Box::new(beacons), &context)
                .map_err(|source| UpError::Robot { robot: robot.id, source })?;
            prepared.push(opened);
        }
        let running = prepared.into_iter().enumerate().map(|(index, robot)| start(index, robot, &context)).collect();
        let ether = Ether::new(self.swarm, far_beacons);
        let ether = carry_beacons(ether, self.plant.clone(), self.clock.clone(), self.said);
        Ok(Robots { running, _guard: Some(guard), ether: Some(tokio::spawn(ether)) })
    }

    fn processes(self, near_sides: Vec<NearSide>, binary: &std::path::Path) -> Result<Robots, UpError> {
        let plane = &self.swarm.beacon;
        // Opened once here, so that a plane that cannot work is said before anything starts.
        drop(BeaconSocket::open(&plane.group, plane.port, &plane.interface).map_err(UpError::Beacons)?);
        let folder = self.folder.ok_or_else(|| anyhow::anyhow!("robots as processes need a folder for their files"))?;
        let mut running = Vec::new();
        for (index, near) in near_sides.into_iter().enumerate() {
            let Some(mut file) = self.swarm.robot_file(self.swarm.robots[index].id) else { continue };
            if let Some(links) = near.links() {
                file.robot.links = links;
            }
            file.record_dir = self.record.then(|| folder.path().display().to_string());
            let child = ChildRobot::start(binary, &file, folder.path())?;
            running.push(tokio::spawn(child.attend(index, self.views.clone(), self.end.clone())));
        }
        Ok(Robots { running, _guard: None, ether: None })
    }
}
