//! `drover run ROBOT.toml`: one robot, on its own computer.

use crate::command::{asked_to_end, overrides, refuse};
use crate::exit::Exit;
use anyhow::Context;
use drover_config::{RobotFile, load_robot};
use drover_io::{BeaconSocket, OsClock, Recorder};
use drover_robot::{
    Assembly, Guard, Hardware, Line, Report, Shutdown, StopReason, View, assemble, drive, epoch_from_unix,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Arguments of `drover run`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The robot's file (`drover up --processes` writes one for every robot of a swarm)
    file: PathBuf,
    /// Print one JSON document a line on stdout: views ten times a second, at last a report
    #[arg(long)]
    json: bool,
    /// Stop the robot and end when standard input is closed: whoever started this has gone
    #[arg(long)]
    attached: bool,
    /// Set a configuration key, for example robot.links.autopilot=udpin:0.0.0.0:14550
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
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
    let record = file.record_dir.clone();
    let record = record.as_deref().map(Path::new);
    write_resolved(&file, record)?;
    let recorder = match record {
        Some(folder) => Some(Recorder::in_folder(folder, clock.unix_offset_us())?),
        None => None,
    };
    let assembly =
        Assembly { file, hardware, beacons: Box::new(beacons), epoch: epoch_from_unix(), recorder: recorder.as_ref() };
    let robot = assemble(assembly, &clock)?;
    let guard = Guard::start()?;
    let heart = guard.add(robot.robot.file().robot.id, robot.hang_limit, robot.stop);
    let (end, end_seen) = watch::channel(None);
    let printer = Printer::start(arguments.json);
    let lines = printer.lines.clone();
    // A full queue drops this view: a reader that sleeps must not hold up the loop.
    let tell = move |view: View| drop(lines.try_send(Line::View(Box::new(view))));
    let mut driving = tokio::spawn(drive(robot.robot, clock, heart, end_seen, tell));
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

fn write_resolved(file: &RobotFile, record: Option<&Path>) -> anyhow::Result<()> {
    let Some(folder) = record else { return Ok(()) };
    let advice = || format!("cannot record in {}: set record_dir to a folder you can write", folder.display());
    std::fs::create_dir_all(folder).with_context(advice)?;
    let name = format!("robot-{}.resolved.toml", file.robot.id);
    std::fs::write(folder.join(name), file.to_toml()).with_context(advice)
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
