//! `drover replay --check`: what robots' links received, fed to today's code.

use crate::exit::Exit;
use crate::meter;
use anyhow::{Context, anyhow};
use drover_config::robot_from_text;
use drover_contract::{Scan, Severity, Stamp};
use drover_core::Status;
use drover_io::{TapeEntry, TapeEvent};
use drover_record::foxglove::Decision;
use drover_record::{Begin, RecordingFile};
use drover_robot::{Witness, rerun};
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};

/// What a check found of one life of one robot.
#[derive(Debug, Serialize)]
struct Checked {
    robot: u32,
    epoch: u32,
    /// Turns of its loop, ticks of its node and messages sent that were compared.
    turns: usize,
    ticks: usize,
    sent: usize,
    /// The first decision that differs, and the first thing on its links that does; none: all are the same.
    decision: Option<Difference>,
    wire: Option<Difference>,
}

/// Where two runs part.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    /// Which tick, or which entry of the tape, from 0.
    index: usize,
    time_s: f64,
    field: String,
    recorded: String,
    now: String,
}

pub(super) fn check(recording: &RecordingFile, json: bool) -> Exit {
    match check_all(recording) {
        Ok(robots) if json => {
            // Only strings and numbers: this cannot fail to print.
            println!("{}", serde_json::to_string_pretty(&robots).unwrap_or_default());
            conclude(&robots)
        }
        Ok(robots) => {
            robots.iter().for_each(print);
            conclude(&robots)
        }
        Err(error) => {
            eprintln!("{error:#}");
            Exit::BadInput
        }
    }
}

fn conclude(robots: &[Checked]) -> Exit {
    let same = robots.iter().all(|robot| robot.decision.is_none() && robot.wire.is_none());
    if same { Exit::Reached } else { Exit::NotReached }
}

fn check_all(recording: &RecordingFile) -> anyhow::Result<Vec<Checked>> {
    anyhow::ensure!(
        !recording.begins.is_empty(),
        "the recording holds no robot's links: one of `drover up`, `drover run` or `drover sim --fidelity wire` does"
    );
    let (bar, mut moved) = meter::share("running again");
    let mut found = Vec::new();
    for (done, begin) in recording.begins.iter().enumerate() {
        found.push(check_one(recording, begin)?);
        moved((done + 1) as f64 / recording.begins.len() as f64);
    }
    bar.finish_and_clear();
    Ok(found)
}

fn check_one(recording: &RecordingFile, begin: &Begin) -> anyhow::Result<Checked> {
    let name = format!("robot {}'s file in the recording", begin.robot);
    let file = robot_from_text(&begin.file, &name).map_err(|problems| anyhow!("{problems}")).context(name)?;
    let tape = recording.tape(begin);
    let decided = Arc::new(Mutex::new(Vec::new()));
    let witness = Box::new(Notes(Arc::clone(&decided)));
    let again = rerun(file, (begin.epoch, Stamp::from_micros(begin.now_us)), &tape, witness)?;
    let decided = std::mem::take(&mut *decided.lock().unwrap_or_else(PoisonError::into_inner));
    let sent = |entry: &&TapeEntry| matches!(entry.event, TapeEvent::Sent(..));
    // A process that was killed, or a disk that was full, leaves ticks whose bytes came too late: nothing to run.
    let tape_end_us = tape.last().map_or(0, |entry| entry.stamp.as_micros());
    let mut recorded = recording.decisions(begin);
    recorded.retain(|tick| tick.stamp_us <= tape_end_us);
    Ok(Checked {
        robot: begin.robot,
        epoch: begin.epoch,
        turns: tape.iter().filter(|entry| entry.event == TapeEvent::Turn).count(),
        ticks: decided.len(),
        sent: tape.iter().filter(sent).count(),
        decision: first_decision(&recorded, &decided),
        wire: first_entry(&tape, &again),
    })
}

/// Writes decisions down.
struct Notes(Arc<Mutex<Vec<Decision>>>);

impl Witness for Notes {
    fn decided(&mut self, status: &Status) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Decision::from(status).coarse());
    }

    fn scanned(&mut self, _scan: &Scan) {}

    fn said(&mut self, _now: Stamp, _severity: Severity, _words: &str) {}
}

fn first_entry(recorded: &[TapeEntry], now: &[TapeEntry]) -> Option<Difference> {
    let count = recorded.len().max(now.len());
    let index = (0..count).find(|index| recorded.get(*index) != now.get(*index))?;
    let words =
        |entry: Option<&TapeEntry>| entry.map_or_else(|| "nothing".into(), |entry| format!("{:?}", entry.event));
    let (was, is) = (recorded.get(index), now.get(index));
    let field = match was.or(is).map(|entry| &entry.event) {
        Some(TapeEvent::Sent(port, _)) => format!("sent to {port:?}"),
        Some(TapeEvent::Received(port, _)) => format!("received from {port:?}"),
        Some(TapeEvent::Turn | TapeEvent::Clock) => "time".into(),
        Some(TapeEvent::ToldToEnd(_)) => "told to end".into(),
        None => return None,
    };
    let time_s = was.or(is).map_or(0.0, |entry| entry.stamp.as_secs_f64());
    Some(Difference { index, time_s, field, recorded: words(was), now: words(is) })
}

fn first_decision(recorded: &[Decision], now: &[Decision]) -> Option<Difference> {
    let at = |index: usize| recorded.get(index).or(now.get(index)).map_or(0.0, |tick| tick.stamp_us as f64 * 1e-6);
    for (index, (was, is)) in recorded.iter().zip(now).enumerate() {
        let (was, is) = (was.in_words(), is.in_words());
        let differs = was.into_iter().zip(is).find(|((_, was), (_, is))| was != is);
        if let Some(((field, recorded), (_, now))) = differs {
            return Some(Difference { index, time_s: at(index), field: field.into(), recorded, now });
        }
    }
    let index = recorded.len().min(now.len());
    let words = |ticks: &[Decision]| if ticks.len() > index { "a tick".into() } else { "no tick".into() };
    (recorded.len() != now.len()).then(|| Difference {
        index,
        time_s: at(index),
        field: "tick".into(),
        recorded: words(recorded),
        now: words(now),
    })
}

fn print(checked: &Checked) {
    let Checked { robot, epoch, turns, ticks, sent, decision, wire } = checked;
    println!("robot {robot} (life {epoch}): {turns} turns, {ticks} ticks, {sent} messages sent");
    let differences = [("decision", decision), ("wire", wire)];
    for (what, difference) in differences {
        match difference {
            None => println!("  {what}: the same"),
            Some(at) => println!(
                "  {what} first differs at tick or entry {}, {:.6} s, in {}: recorded {}, now {}",
                at.index, at.time_s, at.field, at.recorded, at.now
            ),
        }
    }
}
