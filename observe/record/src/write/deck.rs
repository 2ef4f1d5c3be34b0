//! What is recorded, as messages on channels of an MCAP file.

use super::sealed::{Gathered, Sealed, Store};
use crate::coarse::{coarse_moment, coarse_scan};
use crate::foxglove as fox;
use crate::foxglove::{Beacon, Decision, LinkHealth, State};
use crate::moment::{Moment, RunState, ScanMoment, short_points};
use crate::setting::Setting;
use crate::wire::{Shared, pack};
use drover_codec::beacon::{self, Message as BeaconMessage};
use drover_contract::{Severity, Stamp};
use drover_io::{TapeEntry, TapeEvent, TapePort};
use foxglove::Encode;
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Trades a little time for a good deal of room: measured on the shipped swarm.
const ZSTD_LEVEL: u32 = 6;
/// The file is committed this often, by the recording's own time: what a crash can cost, at most.
const COMMIT_NS: u64 = 600_000_000;
/// Chunks are closed by commits; one never gets larger than this.
const CHUNK_BYTES: u64 = 8 << 20;
/// How often what is seen is written, s.
const STATE_S: f64 = 0.1;
const LINKS_S: f64 = 0.5;
/// A robot's own beacons are written as messages this often; all of them are in its wire bytes.
const BEACON_US: u64 = 500_000;
/// Moments come at even distances, give or take.
const SLACK_S: f64 = 1e-3;

/// The beginning of one life of a robot's loop: with the tape, everything that it takes to run it again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begin {
    /// The robot's id.
    pub robot: u32,
    /// Which life.
    pub epoch: u32,
    /// When it began, microseconds on the robot's clock.
    pub now_us: u64,
    /// From that clock's zero back to the Unix epoch, microseconds.
    pub unix_offset_us: u64,
    /// The robot's resolved file, TOML.
    pub file: String,
}

/// How the run goes, beside what each robot tells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunRecord {
    pub(crate) time_s: f64,
    pub(crate) run: RunState,
    pub(crate) min_gap_robot_m: Option<f64>,
    pub(crate) min_gap_wall_m: Option<f64>,
    /// Not in recordings of places without movers, nor in those made before movers were told.
    #[serde(default, skip_serializing_if = "Vec::is_empty", serialize_with = "short_points")]
    pub(crate) movers_m: Vec<[f64; 2]>,
}

/// One thing to record.
pub(super) enum Item {
    Setting(Box<Setting>),
    Begin(Box<Begin>),
    Tape { robot: u32, entries: Vec<TapeEntry> },
    Decision { robot: u32, decision: Box<Decision> },
    Scan { robot: u32, scan: Box<ScanMoment> },
    Said { stamp: Stamp, severity: Severity, robot: u32, words: String },
    Moment { moment: Box<Moment>, scans: bool },
    Health { stamp: Stamp, health: Box<LinkHealth> },
    Summary(serde_json::Value),
}

/// What a message is made of, on its way into the file.
struct Kind {
    name: String,
    encoding: &'static str,
    schema: Vec<u8>,
    messages: &'static str,
}

struct Channel {
    id: u16,
    sequence: u32,
}

/// The file and its channels.
pub(super) struct Deck {
    writer: Writer<Gathered>,
    sealed: Sealed,
    channels: BTreeMap<String, Channel>,
    setting: Setting,
    unix_offset_us: u64,
    newest_ns: u64,
    committed_ns: u64,
    state_due_s: f64,
    links_due_s: f64,
    beacon_due_us: BTreeMap<u32, u64>,
    scan_s: BTreeMap<u32, f64>,
    shared: Shared,
}

impl Deck {
    pub(super) fn new(store: Box<dyn Store>, setting: Setting, unix_offset_us: u64) -> Result<Self, McapError> {
        let gathered = Gathered::default();
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true)
            .library(concat!("drover ", env!("CARGO_PKG_VERSION")));
        Ok(Self {
            writer: options.create(gathered.clone())?,
            sealed: Sealed::new(store, gathered),
            channels: BTreeMap::new(),
            setting,
            unix_offset_us,
            newest_ns: 0,
            committed_ns: 0,
            state_due_s: 0.0,
            links_due_s: 0.0,
            beacon_due_us: BTreeMap::new(),
            scan_s: BTreeMap::new(),
            shared: Shared::default(),
        })
    }

    /// Bytes of data in the file.
    pub(super) const fn len(&self) -> u64 {
        self.sealed.len()
    }

    /// Write one item; the file is committed when it is time to.
    pub(super) fn put(&mut self, item: Item) -> Result<(), McapError> {
        match item {
            Item::Setting(setting) => self.put_setting(&setting)?,
            Item::Begin(begin) => {
                let at_us = begin.now_us.saturating_add(begin.unix_offset_us);
                self.json(&fox::topic(begin.robot, "begin"), "drover.Begin", at_us, &*begin)?;
                return self.commit();
            }
            Item::Tape { robot, entries } => self.put_tape(robot, entries)?,
            Item::Decision { robot, decision } => {
                let at_us = self.unix(decision.stamp_us);
                self.message(&fox::topic(robot, "decision"), at_us, &*decision)?;
            }
            Item::Scan { robot, scan } => self.put_scan(robot, &scan)?,
            Item::Said { stamp, severity, robot, words } => {
                let at_us = self.unix(stamp.as_micros());
                self.message("/log", at_us, &fox::log(at_us, severity, robot, &words))?;
            }
            Item::Moment { moment, scans } => self.put_moment(&moment, scans)?,
            Item::Health { stamp, health } => {
                let at_us = self.unix(stamp.as_micros());
                self.message(&fox::topic(health.robot, "health"), at_us, &*health)?;
            }
            Item::Summary(summary) => {
                let at_us = self.newest_ns / 1_000;
                self.json("/drover/summary", "drover.Summary", at_us, &summary)?;
            }
        }
        if self.newest_ns >= self.committed_ns.saturating_add(COMMIT_NS) { self.commit() } else { Ok(()) }
    }

    /// Everything up to now is in the file.
    pub(super) fn commit(&mut self) -> Result<(), McapError> {
        self.committed_ns = self.newest_ns;
        self.writer.flush()?;
        Ok(self.sealed.commit()?)
    }

    /// Write the index; nothing can be written after.
    pub(super) fn finish(&mut self) -> Result<(), McapError> {
        self.writer.finish()?;
        Ok(self.sealed.finish()?)
    }

    const fn unix(&self, stamp_us: u64) -> u64 {
        stamp_us.saturating_add(self.unix_offset_us)
    }

    /// The Unix time of a moment, microseconds.
    fn moment_us(&self, time_s: f64) -> u64 {
        self.unix((time_s * 1e6).round() as u64)
    }

    fn put_setting(&mut self, setting: &Setting) -> Result<(), McapError> {
        let at_us = setting.started_unix_us;
        self.json("/drover/setting", "drover.Setting", at_us, setting)?;
        // After a jump in time a viewer shows the newest message of each topic: all that stands still is in one.
        let mut scene = fox::scene_place(at_us, setting);
        scene.entities.extend(fox::scene_robots(at_us, setting).entities);
        self.message("/scene", at_us, &scene)?;
        if let Some(map) = &setting.place.map {
            self.message("/map", at_us, &fox::grid(at_us, map))?;
        }
        self.commit()
    }

    fn put_tape(&mut self, robot: u32, entries: Vec<TapeEntry>) -> Result<(), McapError> {
        let Some(first) = entries.first() else { return Ok(()) };
        let base_us = first.stamp.as_micros();
        self.put_beacon(robot, &entries)?;
        let wire = pack(robot, &entries, &mut self.shared);
        self.message(&fox::topic(robot, "wire"), self.unix(base_us), &wire)
    }

    fn put_beacon(&mut self, robot: u32, entries: &[TapeEntry]) -> Result<(), McapError> {
        let due_us = self.beacon_due_us.get(&robot).copied().unwrap_or_default();
        let sent = entries.iter().filter(|entry| entry.stamp.as_micros() >= due_us);
        let newest = sent.rev().find_map(|entry| match &entry.event {
            TapeEvent::Sent(TapePort::Beacons, bytes) => Some((entry.stamp, bytes)),
            _ => None,
        });
        let Some((stamp, bytes)) = newest else { return Ok(()) };
        let Ok(BeaconMessage::Beacon { beacon, .. }) = beacon::decode(bytes) else { return Ok(()) };
        self.beacon_due_us.insert(robot, stamp.as_micros() + BEACON_US);
        let at_us = self.unix(stamp.as_micros());
        self.message(&fox::topic(robot, "beacon"), at_us, &Beacon::from(&beacon))
    }

    fn put_scan(&mut self, robot: u32, scan: &ScanMoment) -> Result<(), McapError> {
        let robots = &self.setting.robots;
        let Some(setting) = robots.iter().find(|setting| setting.id == robot).cloned() else { return Ok(()) };
        let at_us = self.moment_us(scan.time_s);
        let message = fox::laser_scan(at_us, &setting, &coarse_scan(scan));
        let extra = BTreeMap::from([(RANGE_MAX.to_owned(), format!("{}", scan.range_m_max))]);
        self.message_with(&fox::topic(robot, "scan"), at_us, &message, &extra)
    }

    fn put_moment(&mut self, moment: &Moment, scans: bool) -> Result<(), McapError> {
        let at_us = self.moment_us(moment.time_s);
        if scans {
            for robot in &moment.robots {
                let Some(scan) = &robot.scan else { continue };
                let before_s = self.scan_s.insert(robot.id, scan.time_s);
                if before_s.is_none_or(|before_s| scan.time_s > before_s) {
                    self.put_scan(robot.id, scan)?;
                }
            }
        }
        let ended = moment.run.phase == crate::moment::Phase::Ended;
        if ended || moment.time_s >= self.state_due_s {
            self.state_due_s = moment.time_s + STATE_S - SLACK_S;
            let seen = coarse_moment(moment);
            self.message("/tf", at_us, &fox::transforms(at_us, &seen))?;
            for robot in &seen.robots {
                self.message(&fox::topic(robot.id, "state"), at_us, &State::new(moment.time_s, robot))?;
            }
            let record = RunRecord {
                time_s: moment.time_s,
                run: moment.run.clone(),
                min_gap_robot_m: moment.min_gap_robot_m,
                min_gap_wall_m: moment.min_gap_wall_m,
                movers_m: moment.movers_m.clone(),
            };
            self.json("/run", "drover.Run", at_us, &record)?;
        }
        if moment.time_s >= self.links_due_s {
            self.links_due_s = moment.time_s + LINKS_S - SLACK_S;
            let scene = fox::scene_links(at_us, &self.setting, moment);
            self.message("/links", at_us, &scene)?;
            let heard: Vec<_> = moment.robots.iter().map(|robot| (robot.id, &robot.heard)).collect();
            self.json("/heard", "drover.Heard", at_us, &serde_json::json!({ "robots": heard }))?;
        }
        Ok(())
    }

    fn json<T: Serialize>(&mut self, topic: &str, name: &str, at_us: u64, value: &T) -> Result<(), McapError> {
        let bytes = serde_json::to_vec(value).map_err(std::io::Error::from)?;
        let kind =
            || Kind { name: name.to_owned(), encoding: "jsonschema", schema: json_schema(name), messages: "json" };
        self.write((topic, &BTreeMap::new()), at_us, &bytes, kind)
    }

    fn message<T: Encode>(&mut self, topic: &str, at_us: u64, message: &T) -> Result<(), McapError> {
        self.message_with(topic, at_us, message, &BTreeMap::new())
    }

    fn message_with<T: Encode>(
        &mut self,
        topic: &str,
        at_us: u64,
        message: &T,
        extra: &BTreeMap<String, String>,
    ) -> Result<(), McapError> {
        let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        // A message that cannot be encoded has no bytes: Vec grows as it must.
        if message.encode(&mut bytes).is_err() {
            return Ok(());
        }
        let kind = || {
            let schema = T::get_schema();
            Kind {
                name: schema.as_ref().map(|schema| schema.name.clone()).unwrap_or_default(),
                encoding: "protobuf",
                schema: schema.map(|schema| schema.data.into_owned()).unwrap_or_default(),
                messages: "protobuf",
            }
        };
        self.write((topic, extra), at_us, &bytes, kind)
    }

    fn write(
        &mut self,
        (topic, extra): (&str, &BTreeMap<String, String>),
        at_us: u64,
        bytes: &[u8],
        kind: impl FnOnce() -> Kind,
    ) -> Result<(), McapError> {
        if !self.channels.contains_key(topic) {
            let kind = kind();
            let schema = self.writer.add_schema(&kind.name, kind.encoding, &kind.schema)?;
            let id = self.writer.add_channel(schema, topic, kind.messages, extra)?;
            self.channels.insert(topic.to_owned(), Channel { id, sequence: 0 });
        }
        let Some(channel) = self.channels.get_mut(topic) else { return Ok(()) };
        let log_time = at_us.saturating_mul(1_000);
        self.newest_ns = self.newest_ns.max(log_time);
        let header =
            MessageHeader { channel_id: channel.id, sequence: channel.sequence, log_time, publish_time: log_time };
        channel.sequence = channel.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, bytes)
    }
}

/// A scan's channel says in its metadata how far the sensor can measure: the message cannot.
pub(crate) const RANGE_MAX: &str = "range_m_max";

/// What stands in the messages of a JSON channel: names and types of their top level.
fn json_schema(name: &str) -> Vec<u8> {
    let number = serde_json::json!({ "type": ["number", "null"] });
    let text = serde_json::json!({ "type": "string" });
    let object = serde_json::json!({ "type": "object" });
    let list = serde_json::json!({ "type": "array" });
    let properties = match name {
        "drover.Run" => serde_json::json!({
            "time_s": number, "run": object, "min_gap_robot_m": number, "min_gap_wall_m": number, "movers_m": list
        }),
        "drover.Begin" => serde_json::json!({
            "robot": number, "epoch": number, "now_us": number, "unix_offset_us": number, "file": text
        }),
        "drover.Heard" => serde_json::json!({ "robots": list }),
        "drover.Setting" => serde_json::json!({
            "swarm": text, "behaviour": text, "seed": number, "source": text, "started_unix_us": number,
            "duration_s": number, "robots": list, "place": object, "route_m": list
        }),
        _ => serde_json::json!({}),
    };
    let schema = serde_json::json!({ "title": name, "type": "object", "properties": properties });
    schema.to_string().into_bytes()
}
