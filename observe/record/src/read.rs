//! Reads a recording back, from start to end: one that was ended in good order, and what is left of any other.

use crate::foxglove::{Decision, State, Wire, scan_moment};
use crate::moment::{Heard, Moment, RobotMoment, ScanMoment};
use crate::setting::Setting;
use crate::wire::{Shared, unpack};
use crate::write::{Begin, RANGE_MAX, RunRecord};
use drover_contract::Stamp;
use drover_io::{TapeEntry, WireFiles};
use foxglove::messages::LaserScan;
use mcap::Message;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use prost::Message as _;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use thiserror::Error;

/// A recording that cannot be read.
#[derive(Debug, Error)]
#[error("{file}: {why}; {advice}")]
pub struct ReadError {
    file: String,
    why: String,
    advice: &'static str,
}

/// A recording, read.
pub struct RecordingFile {
    /// What did not change while the run went on.
    pub setting: Setting,
    /// The run's summary, if it came to its end.
    pub summary: Option<serde_json::Value>,
    /// The beginnings of robots' lives, in order.
    pub begins: Vec<Begin>,
    /// From the run's beginning to the last of what is recorded, s.
    pub duration_s: f64,
    /// Whether the file was ended in good order.
    pub complete: bool,
    messages: BTreeMap<String, u64>,
    runs: Vec<RunRecord>,
    states: Vec<(u32, State)>,
    heard: Vec<(u64, BTreeMap<u32, Vec<Heard>>)>,
    scans: BTreeMap<u32, Vec<ScanMoment>>,
    decisions: BTreeMap<u32, Vec<Decision>>,
    /// Robot, and a batch of its tape at Unix times.
    wires: Vec<(u32, Vec<TapeEntry>)>,
    shared: Shared,
}

#[derive(Deserialize)]
struct HeardRecord {
    robots: Vec<(u32, Vec<Heard>)>,
}

impl RecordingFile {
    /// Read the recording at `path`.
    ///
    /// # Errors
    /// [`ReadError`] if there is no such file, or nothing in it that this program has recorded.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let file = path.display().to_string();
        let refuse = |why: String, advice| ReadError { file: file.clone(), why, advice };
        let bytes = std::fs::read(path)
            .map_err(|error| refuse(error.to_string(), "give the run.mcap of a recording's folder"))?;
        Self::of_bytes(&bytes)
            .ok_or_else(|| refuse("not a recording of drover".into(), "give the run.mcap of a recording's folder"))
    }

    /// Read a recording from memory; `None` if it holds no setting.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Option<Self> {
        let mut read = Self {
            setting: Setting::default(),
            summary: None,
            begins: Vec::new(),
            duration_s: 0.0,
            complete: false,
            messages: BTreeMap::new(),
            runs: Vec::new(),
            states: Vec::new(),
            heard: Vec::new(),
            scans: BTreeMap::new(),
            decisions: BTreeMap::new(),
            wires: Vec::new(),
            shared: Shared::default(),
        };
        let mut setting = None;
        let mut whole = true;
        // Without the limit a damaged length is believed, and asks for all the memory there is.
        let options = LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(RECORD_BYTES);
        for message in MessageReader::new_with_options(bytes, options) {
            // The first error is the end of what is whole.
            let Ok(message) = message else {
                whole = false;
                break;
            };
            *read.messages.entry(message.channel.topic.clone()).or_default() += 1;
            if message.channel.topic == "/drover/setting" && setting.is_none() {
                setting = serde_json::from_slice::<Setting>(&message.data).ok();
                if let Some(setting) = &setting {
                    read.setting = setting.clone();
                }
            } else {
                read.take(&message);
            }
        }
        setting?;
        let footer = mcap::read::footer(bytes).ok();
        read.complete = whole && footer.is_some_and(|footer| footer.summary_start > 0);
        read.duration_s = read.runs.iter().map(|run| run.time_s).fold(0.0, f64::max);
        Some(read)
    }

    /// Take a message in. One that cannot be read was written by another version: it is passed over.
    fn take(&mut self, message: &Message<'_>) {
        let topic = message.channel.topic.as_str();
        let data = &message.data[..];
        let (robot, name) = match topic.strip_prefix("/robot-").and_then(|rest| rest.split_once('/')) {
            Some((id, name)) => (id.parse().unwrap_or_default(), name),
            None => (0, topic),
        };
        match name {
            "/drover/summary" => self.summary = serde_json::from_slice(data).ok(),
            "/run" => self.runs.extend(serde_json::from_slice::<RunRecord>(data)),
            "/heard" => {
                if let Ok(record) = serde_json::from_slice::<HeardRecord>(data) {
                    self.heard.push((message.log_time, record.robots.into_iter().collect()));
                }
            }
            "begin" => self.begins.extend(serde_json::from_slice::<Begin>(data)),
            "state" => self.states.extend(State::decode(data).map(|state| (robot, state))),
            "decision" => {
                if let Ok(decision) = Decision::decode(data) {
                    self.decisions.entry(robot).or_default().push(decision);
                }
            }
            "wire" => {
                if let Ok(wire) = Wire::decode(data) {
                    let entries = unpack(message.log_time / 1_000, &wire, &mut self.shared);
                    self.wires.push((wire.robot, entries));
                }
            }
            "scan" => {
                let range_m_max = message.channel.metadata.get(RANGE_MAX).and_then(|text| text.parse().ok());
                if let Ok(scan) = <LaserScan as prost::Message>::decode(data) {
                    let started_us = self.setting.started_unix_us;
                    let scan = scan_moment(&scan, started_us, range_m_max.unwrap_or_default());
                    self.scans.entry(robot).or_default().push(scan);
                }
            }
            _ => {}
        }
    }

    /// How many messages each topic has.
    #[must_use]
    pub const fn messages_by_topic(&self) -> &BTreeMap<String, u64> {
        &self.messages
    }

    /// The run, about ten times a second; with the scan that each robot had then, if they are wanted.
    #[must_use]
    pub fn moments(&self, with_scans: bool) -> Vec<Moment> {
        let mut moments: Vec<Moment> = self.runs.iter().map(moment_of).collect();
        moments.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        // A run that ends at the time of the moment before is told of twice: what was said last counts.
        moments.dedup_by(|later, earlier| {
            let same = later.time_s - earlier.time_s <= SAME_S;
            if same {
                std::mem::swap(later, earlier);
            }
            same
        });
        let times: Vec<f64> = moments.iter().map(|moment| moment.time_s).collect();
        let order: BTreeMap<u32, usize> =
            self.setting.robots.iter().enumerate().map(|(index, robot)| (robot.id, index)).collect();
        for moment in &mut moments {
            moment.robots = self.setting.robots.iter().map(|robot| RobotMoment::unheard(robot.id, None)).collect();
        }
        for (robot, state) in &self.states {
            let at = times.partition_point(|time_s| *time_s < state.time_s - SAME_S);
            let place = moments.get_mut(at).zip(order.get(robot));
            if let Some((moment, index)) = place
                && (moment.time_s - state.time_s).abs() <= SAME_S
            {
                moment.robots[*index] = state.robot();
            }
        }
        self.add_heard(&mut moments);
        if with_scans {
            self.add_scans(&mut moments);
        }
        moments
    }

    fn add_heard(&self, moments: &mut [Moment]) {
        let started_ns = self.setting.started_unix_us.saturating_mul(1_000);
        for moment in moments {
            let at_ns = started_ns.saturating_add(((moment.time_s + SAME_S) * 1e9) as u64);
            let after = self.heard.partition_point(|(log_time, _)| *log_time <= at_ns);
            let Some((_, heard)) = after.checked_sub(1).and_then(|at| self.heard.get(at)) else { continue };
            for robot in &mut moment.robots {
                robot.heard = heard.get(&robot.id).cloned().unwrap_or_default();
            }
        }
    }

    fn add_scans(&self, moments: &mut [Moment]) {
        for moment in moments {
            for robot in &mut moment.robots {
                let Some(scans) = self.scans.get(&robot.id) else { continue };
                let after = scans.partition_point(|scan| scan.time_s <= moment.time_s + SAME_S);
                robot.scan = after.checked_sub(1).and_then(|at| scans.get(at)).cloned();
            }
        }
    }

    /// The ticks in which a supervisor changed what was asked for: when (s), which robot, and why.
    #[must_use]
    pub fn interventions(&self) -> Vec<(f64, u32, String)> {
        let offset_us = self.begins.first().map_or(self.setting.started_unix_us, |begin| begin.unix_offset_us);
        let start_us = self.setting.started_unix_us;
        let time_s = |stamp_us: u64| (stamp_us.saturating_add(offset_us) as f64 - start_us as f64) * 1e-6;
        let of_robot = |(robot, ticks): (&u32, &Vec<Decision>)| {
            let robot = *robot;
            let changed = ticks.iter().filter_map(|tick| Some((tick.stamp_us, tick.changed.clone()?)));
            changed.map(move |(stamp_us, why)| (time_s(stamp_us), robot, why)).collect::<Vec<_>>()
        };
        let mut all: Vec<_> = self.decisions.iter().flat_map(of_robot).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    /// The decisions of the life that `begin` began, in order.
    #[must_use]
    pub fn decisions(&self, begin: &Begin) -> Vec<Decision> {
        let end_us = self.end_us(begin);
        let ticks = self.decisions.get(&begin.robot).into_iter().flatten();
        ticks.filter(|tick| (begin.now_us..end_us).contains(&tick.stamp_us)).cloned().collect()
    }

    /// What the loop of that life was given and sent, in order, with its exact times.
    #[must_use]
    pub fn tape(&self, begin: &Begin) -> Vec<TapeEntry> {
        let end_us = self.end_us(begin);
        let of_robot = self.wires.iter().filter(|(robot, _)| *robot == begin.robot);
        let entries = of_robot.flat_map(|(_, entries)| entries).map(|entry| on_clock(entry, begin.unix_offset_us));
        entries.filter(|entry| (begin.now_us..end_us).contains(&entry.stamp.as_micros())).collect()
    }

    /// When the next life of the same robot begins.
    fn end_us(&self, begin: &Begin) -> u64 {
        let later = self.begins.iter().filter(|other| other.robot == begin.robot && other.epoch > begin.epoch);
        later.map(|other| other.now_us).min().unwrap_or(u64::MAX)
    }

    /// What crossed the robots' links, in the formats of other tools; `moved` is told the share that is done.
    #[must_use]
    pub fn wire_files(&self, mut moved: impl FnMut(f64)) -> WireFiles {
        let mut files = WireFiles::new(0);
        for (done, (robot, entries)) in self.wires.iter().enumerate() {
            entries.iter().for_each(|entry| files.add(*robot, entry));
            moved(done as f64 / self.wires.len() as f64);
        }
        files
    }
}

/// A record, or a chunk unpacked, is never longer: chunks are closed at a small part of this.
const RECORD_BYTES: usize = 256 << 20;
/// Times that are nearer to each other are the same moment's, s.
const SAME_S: f64 = 2e-3;

fn moment_of(run: &RunRecord) -> Moment {
    Moment {
        time_s: run.time_s,
        run: run.run.clone(),
        robots: Vec::new(),
        movers_m: run.movers_m.clone(),
        min_gap_robot_m: run.min_gap_robot_m,
        min_gap_wall_m: run.min_gap_wall_m,
    }
}

/// An entry at a Unix time, by the robot's own clock.
fn on_clock(entry: &TapeEntry, unix_offset_us: u64) -> TapeEntry {
    let stamp = Stamp::from_micros(entry.stamp.as_micros().saturating_sub(unix_offset_us));
    TapeEntry { stamp, event: entry.event.clone() }
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
