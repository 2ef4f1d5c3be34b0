//! `drover run ROBOT.toml`: one robot, on its own computer.

use crate::command::{asked_to_end, overrides, refuse};
use crate::exit::Exit;
use anyhow::Context;
use drover_config::{RobotFile, load_robot};
use drover_contract::{Clock, Stamp};
use drover_io::{BeaconSocket, OsClock};
use drover_record::foxglove::LinkHealth;
use drover_record::{Moment, Pace, Recorder, RecorderOptions, RobotMoment, RunState, Setting};
use drover_robot::{
    Assembly, Guard, Hardware, Line, Report, Shutdown, StopReason, Teller, View, assemble, drive, epoch_from_unix,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// How often the loop tells how it is doing.
const VIEW_PERIOD: Duration = Duration::from_millis(50);
/// How often the links' health is recorded.
const HEALTH_PERIOD: Duration = Duration::from_millis(500);
/// Views that may wait to be seen.
const VIEWS: usize = 32;
/// Slower than this a robot stands, by its own odometry: m/s and rad/s.
#[cfg(feature = "view")]
const STANDSTILL: f64 = 0.02;

/// Arguments of `drover run`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The robot's file (`drover up --processes` writes one for every robot of a swarm)
    file: PathBuf,
    /// Print one JSON document a line on stdout: views twenty times a second, at last a report
    #[arg(long)]
    json: bool,
    /// Stop the robot and end when standard input is closed: whoever started this has gone
    #[arg(long)]
    attached: bool,
    /// Set a configuration key, for example robot.links.autopilot=udpin:0.0.0.0:14550
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[cfg(feature = "view")]
    #[command(flatten)]
    view: crate::onlook::ViewArguments,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let set = match overrides(&arguments.set) {
        Ok(set) => set,
        Err(exit) => return exit,
    };
    let file = match load_robot(&arguments.file, &set) {
        Ok(file) => file,
        Err(problems) => return refuse(&problems),
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    let outcome = match runtime {
        Ok(runtime) => {
            let outcome = runtime.block_on(run(file, arguments));
            // Reading standard input blocks a thread that nobody may wait for.
            runtime.shutdown_background();
            outcome
        }
        Err(error) => Err(error.into()),
    };
    match outcome {
        Ok((report, interrupted)) => conclude(&report, interrupted),
        Err(error) => {
            eprintln!("{error:#}");
            Exit::CannotStart
        }
    }
}

async fn run(file: RobotFile, arguments: &Arguments) -> anyhow::Result<(Report, bool)> {
    let clock = OsClock::new();
    let plane = &file.beacon;
    let beacons = BeaconSocket::open(&plane.group, plane.port, &plane.interface)?;
    let hardware = Hardware::open(&file.robot.links)?;
    let setting = Setting::of_robot(&file, clock.unix_offset_us());
    let recorder = recorder(&file, &setting)?;
    let record_dir = file.record_dir.clone();
    let epoch = epoch_from_unix();
    let now = clock.now();
    let recording = recorder.as_ref().map(|recorder| recorder.robot(&file, epoch, now));
    let mut onlookers = Onlookers::start(arguments, &file, setting, recorder.clone()).await?;
    let robot = assemble(Assembly { file, hardware, beacons: Box::new(beacons), epoch, recording }, now)?;
    let guard = Guard::start()?;
    let heart = guard.add(robot.robot.file().robot.id, robot.hang_limit, robot.stop);
    let (end, end_seen) = watch::channel(None);
    let printer = Printer::start(arguments.json);
    let lines = printer.lines.clone();
    let (views, mut seen) = tokio::sync::mpsc::channel(VIEWS);
    // A full queue drops this view: a reader that sleeps must not hold up the loop.
    let tell = move |view: View| {
        let _ = views.try_send(view.clone());
        drop(lines.try_send(Line::View(Box::new(view))));
    };
    let teller = Teller { period: VIEW_PERIOD, tell };
    let mut driving = tokio::spawn(drive(robot.robot, clock, heart, end_seen, teller));
    tokio::spawn(async move {
        while let Some(view) = seen.recv().await {
            onlookers.see(&view, clock.now());
        }
    });
    let mut interrupted = false;
    let report = tokio::select! {
        report = &mut driving => report?,
        reason = reason_to_end(arguments.attached) => {
            interrupted = reason == StopReason::Operator;
            // Nobody listening means that the loop has ended by itself.
            let _ = end.send(Some(Shutdown(reason)));
            driving.await?
        }
    };
    if report.panic.is_some() {
        // The guard goes on sending this robot's stop for a moment, then the drive's own watchdog has it.
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    if let (Some(recorder), Ok(document)) = (&recorder, serde_json::to_value(&report)) {
        recorder.finish(&document);
    }
    if let (Some(folder), Some(map)) = (record_dir, &report.map)
        && let Err(error) = map.write(Path::new(&folder))
    {
        eprintln!("the map was not written to {folder}: {error}");
    }
    printer.finish(Line::Report(Box::new(report.clone())));
    Ok((report, interrupted))
}

/// Prints in a thread of its own: standard output may block, and the robot's loop must not.
struct Printer {
    lines: SyncSender<Line>,
    done: Receiver<()>,
}

impl Printer {
    /// Views that may wait for a slow reader.
    const QUEUE: usize = 32;
    /// The last line waits this long for a reader.
    const PATIENCE: Duration = Duration::from_secs(1);

    fn start(json: bool) -> Self {
        let (lines, to_print) = sync_channel::<Line>(Self::QUEUE);
        let (finished, done) = sync_channel(1);
        std::thread::spawn(move || {
            for line in to_print {
                print(&line, json);
                if matches!(line, Line::Report(_)) {
                    break;
                }
            }
            // Nobody waits for it if the program is gone already.
            let _ = finished.send(());
        });
        Self { lines, done }
    }

    /// Print the last line, unless nobody reads.
    fn finish(self, last: Line) {
        let deadline = Instant::now() + Self::PATIENCE;
        let mut line = last;
        while let Err(TrySendError::Full(back)) = self.lines.try_send(line) {
            if Instant::now() > deadline {
                return;
            }
            line = back;
            std::thread::sleep(Duration::from_millis(10));
        }
        // Either it is printed or the patience is over; the program ends in any case.
        let _ = self.done.recv_timeout(Self::PATIENCE);
    }
}

/// The recording of this run, if the file asks for one; the resolved configuration is laid beside it.
fn recorder(file: &RobotFile, setting: &Setting) -> anyhow::Result<Option<Recorder>> {
    let Some(folder) = file.record_dir.as_deref().map(Path::new) else { return Ok(None) };
    let advice = || format!("cannot record in {}: set record_dir to a folder you can write", folder.display());
    std::fs::create_dir_all(folder).with_context(advice)?;
    let id = file.robot.id;
    std::fs::write(folder.join(format!("robot-{id}.resolved.toml")), file.to_toml()).with_context(advice)?;
    let unix_offset_us = setting.started_unix_us;
    // A recording is never written over: what happened before a restart is what one wants to see.
    let path = folder.join(format!("robot-{id}-{}.mcap", unix_offset_us / 1_000));
    let options = RecorderOptions { path, pace: Pace::RealTime, unix_offset_us };
    Ok(Some(Recorder::create(options, setting)?))
}

/// Those who see what the robot tells: its recording, the live page, Foxglove.
struct Onlookers {
    recorder: Option<Recorder>,
    recording_failed: bool,
    health_due: Stamp,
    #[cfg(feature = "view")]
    page: Page,
}

impl Onlookers {
    #[cfg_attr(not(feature = "view"), allow(clippy::unused_async, unused_variables))]
    async fn start(
        arguments: &Arguments,
        file: &RobotFile,
        setting: Setting,
        recorder: Option<Recorder>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            recorder,
            recording_failed: false,
            health_due: Stamp::ZERO,
            #[cfg(feature = "view")]
            page: Page::start(arguments, file, setting).await?,
        })
    }

    fn see(&mut self, view: &View, now: Stamp) {
        let moment = Moment {
            time_s: now.as_secs_f64(),
            run: RunState { rate: 1.0, ..RunState::default() },
            robots: vec![RobotMoment::of_view(view, None)],
            ..Moment::default()
        };
        if let Some(recorder) = &self.recorder {
            recorder.moment(&moment);
            if now >= self.health_due {
                self.health_due = now + HEALTH_PERIOD;
                recorder.health(now, LinkHealth::of_view(view));
            }
            self.recording_failed |= recorder.state().failed.is_some();
        }
        #[cfg(feature = "view")]
        self.page.see(moment, self.recording_failed);
    }
}

/// The live page of one robot.
#[cfg(feature = "view")]
struct Page {
    view: crate::onlook::View,
    swarm: String,
    plane: drover_config::BeaconPlane,
    robot: u32,
    asked_s: Option<f64>,
    stood_s: Option<f64>,
}

#[cfg(feature = "view")]
impl Page {
    async fn start(arguments: &Arguments, file: &RobotFile, setting: Setting) -> anyhow::Result<Self> {
        use drover_record::{Controls, Onlooker};
        let mut view = crate::onlook::View::start(&arguments.view, false).await?;
        view.announce();
        view.begin(setting, Controls { stop: true, ..Controls::default() });
        Ok(Self {
            view,
            swarm: file.swarm.clone(),
            plane: file.beacon.clone(),
            robot: file.robot.id,
            asked_s: None,
            stood_s: None,
        })
    }

    fn see(&mut self, mut moment: Moment, recording_failed: bool) {
        use drover_record::{Control, Onlooker, Phase, StopState};
        while let Some(control) = self.view.next_control() {
            if control == Control::Stop {
                self.asked_s.get_or_insert(moment.time_s);
                // The same way as `drover stop`: the loop hears it as it hears everybody's.
                let robot = Some(drover_contract::RobotId(self.robot));
                let (swarm, plane) = (self.swarm.clone(), self.plane.clone());
                // It is repeated for a second, in which the page must go on showing what becomes of it.
                tokio::spawn(async move {
                    if let Err(error) = drover_robot::send_stop(&swarm, &plane, robot).await {
                        tracing::error!("{error}");
                    }
                });
            }
        }
        if recording_failed {
            moment.run.words = "the recording has ended: see the log".into();
        }
        if let (Some(asked_s), Some(robot)) = (self.asked_s, moment.robots.first()) {
            let latched = robot.state == "stopped";
            let standing = robot.twist_b.iter().all(|speed| speed.abs() < STANDSTILL);
            if latched && standing {
                self.stood_s.get_or_insert(moment.time_s);
            }
            let stopped = self.stood_s.is_some();
            moment.run.phase = if stopped { Phase::Stopped } else { Phase::Stopping };
            moment.run.stop = Some(StopState {
                asked_s,
                latched: latched.into(),
                standing: standing.into(),
                all_standing_s: self.stood_s,
            });
        }
        self.view.show(moment);
    }
}

async fn reason_to_end(attached: bool) -> StopReason {
    tokio::select! {
        () = asked_to_end() => StopReason::Operator,
        () = lifeline_cut(), if attached => StopReason::Shutdown,
    }
}

/// Ready when standard input is at its end.
async fn lifeline_cut() {
    let read = tokio::task::spawn_blocking(|| std::io::copy(&mut std::io::stdin(), &mut std::io::sink()));
    // However reading ended, nobody holds the other end any more.
    let _ = read.await;
}

fn print(line: &Line, json: bool) {
    let text = match line {
        // Only strings and finite numbers: this cannot fail to serialise.
        line if json => serde_json::to_string(line).unwrap_or_default(),
        Line::View(view) => {
            // People read the table on stderr, beside the log.
            eprintln!("{view}");
            return;
        }
        Line::Report(_) => return,
    };
    // A reader that went away is noticed by standard input, if at all: it is no reason to stop a robot.
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn conclude(report: &Report, interrupted: bool) -> Exit {
    eprintln!("{report}");
    match (report.panic.is_some() || !report.seen_stopped, interrupted, report.reached) {
        (true, _, _) => Exit::Unsafe,
        (false, true, _) => Exit::Interrupted,
        (false, false, true) => Exit::Reached,
        (false, false, false) => Exit::NotReached,
    }
}
