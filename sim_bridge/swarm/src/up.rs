//! A swarm against the wall clock: open every link, start every robot, watch, end in good order, summarise.

use crate::children::ChildRobot;
use crate::ether::Ether;
use crate::recording::RunFolder;
use crate::summary::{RunFacts, Summary, Tally, summarise};
use crate::tasks::{TaskContext, ViewSender, beacon_links, carry_beacons, prepare, start};
use drover_bridge::{Bridge, BridgeError, CanBacking, CanChoice, NearSide, PlantHandle, pace};
use drover_config::Swarm;
use drover_contract::Clock;
use drover_io::{BeaconSocket, OpenError, OsClock, Recorder};
use drover_robot::{Guard, Report, Shutdown, StopReason, View, epoch_from_unix};
use std::future::Future;
use std::path::PathBuf;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

/// How often the run is looked at.
const WATCH_PERIOD: Duration = Duration::from_millis(100);
/// Robots that were told to end have this long.
const END_PATIENCE: Duration = Duration::from_secs(12);
/// Views that may wait to be looked at.
const VIEW_QUEUE: usize = 4096;

/// How a swarm is brought up.
pub struct UpOptions<W> {
    /// The `drover` binary, if every robot is to be a process of its own.
    pub processes: Option<PathBuf>,
    /// Whether anything is recorded.
    pub record: bool,
    /// Called about ten times a second with the time, s, and what every robot last said, in the file's order.
    pub on_view: W,
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
struct Robots {
    running: Vec<JoinHandle<Option<Report>>>,
    /// Watches robots that are tasks; a process has a guard of its own.
    _guard: Option<Guard>,
    ether: Option<JoinHandle<()>>,
}

/// Bring a swarm up, run it until every robot has reached the end, its duration is over or `interrupt` is ready; stop
/// every robot and see it stand; summarise.
///
/// # Errors
/// [`UpError`] if something the run needs is missing; nothing has moved then.
pub async fn up<W, I>(swarm: &Swarm, options: UpOptions<W>, interrupt: I) -> Result<Summary, UpError>
where
    W: FnMut(f64, &[Tally]),
    I: Future<Output = ()>,
{
    let clock = OsClock::new();
    let folder = if options.record || options.processes.is_some() { Some(RunFolder::create(swarm)?) } else { None };
    let recorder = match &folder {
        // A robot's process records its own links.
        Some(folder) if options.record && options.processes.is_none() => {
            Some(Recorder::in_folder(folder.path(), clock.unix_offset_us()).map_err(UpError::Recording)?)
        }
        Some(_) | None => None,
    };
    let can = CanChoice::best(swarm, options.processes.is_some());
    let (bridge, near_sides) = Bridge::open(swarm, can.backing, clock.now())?;
    let plant = bridge.plant();
    let pacing = tokio::spawn(pace(bridge, clock));
    let (views, views_in) = mpsc::channel(VIEW_QUEUE);
    let (end, end_seen) = watch::channel(None);
    let start = Start {
        swarm,
        plant: &plant,
        clock: &clock,
        folder: folder.as_ref(),
        recorder: recorder.as_ref(),
        record: options.record,
        views,
        end: end_seen,
    };
    let robots = match &options.processes {
        None => start.tasks(near_sides)?,
        Some(binary) => start.processes(near_sides, binary)?,
    };
    let mut watcher = Watcher { views: views_in, tallies: vec![Tally::default(); swarm.robots.len()], options };
    let (ended, time_s) = watcher.watch(swarm, &clock, &end, interrupt).await;
    watcher.collect(robots).await;
    let facts = RunFacts {
        ended: ended.into(),
        time_s,
        world_rate: plant.with(|plant| plant.time().as_secs_f64()) / clock.now().as_secs_f64(),
        can: if can.backing == CanBacking::Vcan { "vcan" } else { "memory" },
        can_detail: can.words,
        processes: watcher.options.processes.is_some(),
        recording: folder.as_ref().map(|folder| folder.path().display().to_string()),
        recording_dropped: recorder.as_ref().map_or(0, Recorder::dropped),
    };
    let summary = plant.with(|plant| summarise(swarm, plant, &watcher.tallies, facts));
    pacing.abort();
    if let Some(folder) = &folder {
        let text = serde_json::to_string_pretty(&summary).unwrap_or_default();
        if let Err(error) = folder.write("summary.json", &text) {
            // The run is over and its summary is in our hands: a full disk must not take it from the user.
            tracing::error!("{error:#}");
        }
    }
    Ok(summary)
}

/// What is needed to start robots.
struct Start<'a> {
    swarm: &'a Swarm,
    plant: &'a PlantHandle,
    clock: &'a OsClock,
    folder: Option<&'a RunFolder>,
    recorder: Option<&'a Recorder>,
    record: bool,
    views: ViewSender,
    end: watch::Receiver<Option<Shutdown>>,
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
        let ether = carry_beacons(Ether::new(self.swarm, far_beacons), self.plant.clone(), *self.clock);
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

/// Looks at what the robots say.
struct Watcher<W> {
    views: mpsc::Receiver<(usize, View)>,
    tallies: Vec<Tally>,
    options: UpOptions<W>,
}

impl<W: FnMut(f64, &[Tally])> Watcher<W> {
    /// Watch until the end, then tell every robot. Why it ended, and when.
    async fn watch<I: Future<Output = ()>>(
        &mut self,
        swarm: &Swarm,
        clock: &OsClock,
        end: &watch::Sender<Option<Shutdown>>,
        interrupt: I,
    ) -> (&'static str, f64) {
        let began = clock.now();
        let mut ticker = tokio::time::interval(WATCH_PERIOD);
        tokio::pin!(interrupt);
        let (why, reason) = loop {
            tokio::select! {
                _ = ticker.tick() => {}
                () = &mut interrupt => break ("interrupted", StopReason::Operator),
            }
            let time_s = clock.now().since(began).as_secs_f64();
            self.look(time_s);
            if self.tallies.iter().all(|tally| tally.view.as_ref().is_some_and(|view| view.reached)) {
                break ("every robot reached the end", StopReason::Shutdown);
            }
            if time_s >= swarm.duration_s {
                break ("the time was over", StopReason::Shutdown);
            }
        };
        self.tallies.iter_mut().for_each(Tally::note_end);
        // Nobody listening means that every robot has ended by itself.
        let _ = end.send(Some(Shutdown(reason)));
        (why, clock.now().since(began).as_secs_f64())
    }

    fn look(&mut self, time_s: f64) {
        while let Ok((index, view)) = self.views.try_recv() {
            self.tallies[index].see(view, time_s);
        }
        (self.options.on_view)(time_s, &self.tallies);
    }

    /// Await every robot's last words; what is still running after a patience is ended.
    async fn collect(&mut self, robots: Robots) {
        let limit = tokio::time::Instant::now() + END_PATIENCE;
        for (tally, mut running) in self.tallies.iter_mut().zip(robots.running) {
            match tokio::time::timeout_at(limit, &mut running).await {
                Ok(report) => tally.report = report.ok().flatten(),
                Err(_) => running.abort(),
            }
        }
        while let Ok((index, view)) = self.views.try_recv() {
            self.tallies[index].view = Some(view);
        }
        if let Some(ether) = robots.ether {
            ether.abort();
        }
    }
}
