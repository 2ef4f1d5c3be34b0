//! The robot's side of a DroneCAN lidar node: Proximity (and range Measurement) in, whole scans out.
//!
//! A sensor node sends a message a sector. A round is over when every sector was heard, or a scan period after it
//! began; then one scan goes out. Some nodes (AP_Periph) say nothing about a sector without an obstacle. Silence of
//! Proximity is not "free": liveness comes from NodeStatus, and where silence may mean clear (`silent_is_clear`), it
//! does so only while NodeStatus is fresh and well, nothing was broken on the way, and the sector has been silent for
//! two periods (a sensor a little slower than said slips out of a round now and then).
//!
//! No NodeStatus, or a sick one: no scan at all; the supervisor then stops the robot by the age of its scan.

use super::message::{
    GET_NODE_INFO_ID, GET_NODE_INFO_SIGNATURE, Health, MEASUREMENT_ID, MEASUREMENT_SIGNATURE, Measurement,
    NODE_STATUS_ID, NODE_STATUS_SIGNATURE, NodeInfo, NodeMode, NodeStatus, PROXIMITY_ID, PROXIMITY_SIGNATURE,
    Proximity, ProximityReading, RangeReading,
};
use super::sectors::Sectors;
use super::transfer::split;
use super::{FrameId, Reassembler, ReassemblyCounters, Transfer};
use crate::can::queue::Queue;
use drover_contract::{Beam, CanFrame, CanNode, Event, Scan, Severity, Stamp, wrap};
use std::f64::consts::PI;
use std::time::Duration;

/// A node is away when its NodeStatus is older (DroneCAN specification, OFFLINE_TIMEOUT).
const STATUS_LOST: Duration = Duration::from_secs(3);
/// Silence of a sector means clear only while NodeStatus, sent every second, is younger than this.
const STATUS_FRESH: Duration = Duration::from_millis(1_500);
/// How often we say that we are there: so often must every node.
const STATUS_PERIOD: Duration = Duration::from_secs(1);
/// pydronecan's default priority.
const PRIORITY: u8 = 20;
/// Four streams of the lidar and requests of a few tools.
const SESSIONS_MAX: usize = 16;
const OUTPUTS_MAX: usize = 64;
const EVENTS_MAX: usize = 64;
/// A half float says a distance to one part in 2048: "at the greatest range" is meant so exactly.
const HALF_PRECISION: f64 = 1.0 / 2048.0;
const NODE_NAME: &str = "drover.robot";

/// What a host must know of its lidar node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DronecanLidarParams {
    /// The lidar's node id.
    pub node: CanNode,
    /// Our own node id on that bus, so that tools see us.
    pub own_node: CanNode,
    /// Sectors of a full turn.
    pub beams: u32,
    /// Nearer than this it cannot measure, metres.
    pub range_m_min: f64,
    /// Farther than this it cannot measure, metres.
    pub range_m_max: f64,
    /// Scans per second.
    pub rate_hz: f64,
    /// Whether it says nothing about a sector without an obstacle.
    pub silent_is_clear: bool,
}

/// What a host has counted since it started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DronecanCounters {
    /// Scans given out.
    pub scans: u64,
    /// Transfers that were complete and still made no sense.
    pub malformed: u64,
    /// Readings that say no direction: a Measurement without orientation, a yaw that is not a number.
    pub undirected: u64,
    /// Frames or events dropped because nobody took them.
    pub overflows: u64,
    /// What happened on the way from frames to transfers.
    pub reassembly: ReassemblyCounters,
}

/// How the lidar node is, by its NodeStatus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Node {
    Unheard,
    Well,
    Ailing,
    Unfit,
    Lost,
}

/// A lidar node, seen from its robot. Sans-IO: frames in, frames and events out, time as an argument.
#[derive(Clone, Debug)]
pub struct DronecanLidarHost {
    params: DronecanLidarParams,
    started: Stamp,
    period: Duration,
    reassembler: Reassembler,
    status: Option<(Stamp, NodeStatus)>,
    node: Node,
    sectors: Sectors,
    round: Option<Stamp>,
    broken_before: u64,
    status_due: Stamp,
    status_transfer_id: u8,
    outputs: Queue<CanFrame>,
    events: Queue<Event>,
    counters: DronecanCounters,
}

impl DronecanLidarHost {
    /// A host that has heard nothing yet. A rate outside 0.1..=1000 Hz is taken into that range.
    #[must_use]
    pub fn new(params: DronecanLidarParams, now: Stamp) -> Self {
        let rate_hz = if params.rate_hz.is_finite() { params.rate_hz.clamp(0.1, 1_000.0) } else { 0.1 };
        Self {
            params,
            started: now,
            period: Duration::from_secs_f64(1.0 / rate_hz),
            reassembler: Reassembler::new(SESSIONS_MAX),
            status: None,
            node: Node::Unheard,
            sectors: Sectors::new(params.beams),
            round: None,
            broken_before: 0,
            status_due: now,
            status_transfer_id: 0,
            outputs: Queue::new(OUTPUTS_MAX),
            events: Queue::new(EVENTS_MAX),
            counters: DronecanCounters::default(),
        }
    }

    /// Take a frame from the bus.
    pub fn handle_frame(&mut self, now: Stamp, frame: &CanFrame) {
        let (lidar, own) = (self.params.node, self.params.own_node);
        let Some(transfer) = self.reassembler.accept(now, frame, |id| wanted(id, lidar, own)) else { return };
        self.judge_node(now);
        self.close_round_if_due(now);
        match transfer.id {
            FrameId::Message { type_id: NODE_STATUS_ID, .. } => self.handle_status(now, &transfer.payload),
            FrameId::Message { type_id: PROXIMITY_ID, .. } => match Proximity::parse(&transfer.payload) {
                Some(proximity) => self.handle_proximity(now, &proximity),
                None => self.counters.malformed += 1,
            },
            FrameId::Message { type_id: MEASUREMENT_ID, .. } => match Measurement::parse(&transfer.payload) {
                Some(measurement) => self.handle_measurement(now, &measurement),
                None => self.counters.malformed += 1,
            },
            FrameId::Service { source, .. } => self.answer_node_info(now, source, &transfer),
            FrameId::Message { .. } | FrameId::Anonymous { .. } => {}
        }
    }

    /// Let time pass: close a round that is over, notice a lost node, say that we are there.
    pub fn handle_timeout(&mut self, now: Stamp) {
        self.judge_node(now);
        self.close_round_if_due(now);
        if now >= self.status_due {
            self.status_due = now + STATUS_PERIOD;
            let id = FrameId::Message { priority: PRIORITY, type_id: NODE_STATUS_ID, source: self.params.own_node };
            let payload = self.own_status(now).emit();
            self.send(split(id, NODE_STATUS_SIGNATURE, self.status_transfer_id, &payload));
            self.status_transfer_id = (self.status_transfer_id + 1) % 32;
        }
    }

    /// The next frame to send.
    pub fn poll_output(&mut self) -> Option<CanFrame> {
        self.outputs.pop()
    }

    /// The next thing learned.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// When [`Self::handle_timeout`] must be called at the latest, and what for.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        let own = Some((self.status_due, "dronecan own status"));
        let round = self.round.map(|begun| (begun + self.period, "dronecan scan period"));
        let lost = match (self.status, self.node) {
            (Some((seen, _)), Node::Well | Node::Ailing | Node::Unfit) => {
                Some((seen + STATUS_LOST + Duration::from_micros(1), "dronecan node status"))
            }
            (Some(_), Node::Lost | Node::Unheard) | (None, _) => None,
        };
        [own, round, lost].into_iter().flatten().min()
    }

    /// What was counted.
    #[must_use]
    pub fn counters(&self) -> DronecanCounters {
        let overflows = self.outputs.dropped() + self.events.dropped();
        DronecanCounters { overflows, reassembly: self.reassembler.counters(), ..self.counters }
    }

    fn handle_status(&mut self, now: Stamp, payload: &[u8]) {
        match NodeStatus::parse(payload) {
            Some(status) => {
                self.status = Some((now, status));
                self.judge_node(now);
            }
            None => self.counters.malformed += 1,
        }
    }

    fn handle_proximity(&mut self, now: Stamp, proximity: &Proximity) {
        let beam = match (proximity.reading, proximity.distance_m) {
            (ProximityReading::Good, Some(distance_m)) => self.beam(distance_m),
            (ProximityReading::Good, None) => Beam::Unknown,
            (ProximityReading::NoData | ProximityReading::NotConnected | ProximityReading::Reserved(_), _) => {
                Beam::Unknown
            }
        };
        match proximity.yaw_deg {
            Some(yaw_deg) => self.read_sector(now, -yaw_deg.to_radians(), beam), // clockwise on the wire
            None => self.counters.undirected += 1,
        }
    }

    fn handle_measurement(&mut self, now: Stamp, measurement: &Measurement) {
        if !measurement.orientation_defined {
            self.counters.undirected += 1;
            return;
        }
        let beam = match (measurement.reading, measurement.range_m) {
            (RangeReading::Valid, Some(range_m)) => self.beam(range_m),
            (RangeReading::TooClose, _) => Beam::Hit(self.params.range_m_min),
            (RangeReading::TooFar, _) => Beam::Clear,
            (RangeReading::Valid, None) | (RangeReading::Undefined | RangeReading::Reserved(_), _) => Beam::Unknown,
        };
        let [_, _, yaw] = measurement.roll_pitch_yaw;
        self.read_sector(now, -f64::from(yaw) * PI / 12.0, beam);
    }

    fn beam(&self, range_m: f64) -> Beam {
        match range_m {
            range_m if range_m < 0.0 => Beam::Unknown,
            range_m if range_m < self.params.range_m_max * (1.0 - HALF_PRECISION) => Beam::Hit(range_m),
            _ => Beam::Clear,
        }
    }

    /// Put a reading where it belongs. A sector that comes again late in a round begins the next one.
    fn read_sector(&mut self, now: Stamp, bearing_rad: f64, beam: Beam) {
        let index = self.sectors.index(wrap(bearing_rad));
        let late = self.round.is_some_and(|begun| now.since(begun) >= self.period / 2);
        if late && self.sectors.has(index) && !self.params.silent_is_clear {
            self.close_round(now);
        }
        self.round.get_or_insert(now);
        self.sectors.set(index, now, beam);
        if self.sectors.complete() {
            self.close_round(now);
        }
    }

    fn close_round_if_due(&mut self, now: Stamp) {
        if self.round.is_some_and(|begun| now.since(begun) >= self.period) {
            self.close_round(now);
        }
    }

    /// Give out the round's scan, if the node is fit and there is anything to say.
    fn close_round(&mut self, now: Stamp) {
        let begun = self.round.unwrap_or(now);
        let broken = self.reassembler.counters().broken();
        let whole = std::mem::replace(&mut self.broken_before, broken) == broken;
        let fit = matches!(self.node, Node::Well | Node::Ailing);
        let fresh = self.status.is_some_and(|(seen, _)| now.since(seen) <= STATUS_FRESH);
        let silence_counts = self.params.silent_is_clear && self.node == Node::Well && fresh;
        let heard = self.sectors.any();
        let silent = if silence_counts && whole { Beam::Clear } else { Beam::Unknown };
        let hold = if self.params.silent_is_clear { self.period * 2 } else { Duration::ZERO };
        let beams = self.sectors.take(now, hold, silent);
        self.round = (self.params.silent_is_clear && fit).then_some(now);
        if !fit || !(heard || silence_counts) {
            return;
        }
        self.counters.scans += 1;
        self.events.push(Event::Scan(Scan {
            // As old as its oldest sector: whoever carries it forward by the body's motion must not do too little.
            stamp: begun,
            angle_first_rad: 0.0,
            angle_step_rad: self.sectors.step_rad(),
            range_m_min: self.params.range_m_min,
            range_m_max: self.params.range_m_max,
            beams,
        }));
    }

    /// Look at the node's status and its age; tell what is new.
    fn judge_node(&mut self, now: Stamp) {
        let node = match self.status {
            None => Node::Unheard,
            Some((seen, _)) if now.since(seen) > STATUS_LOST => Node::Lost,
            Some((_, status)) => match (status.mode, status.health) {
                (NodeMode::Operational, Health::Ok) => Node::Well,
                (NodeMode::Operational, Health::Warning | Health::Error) => Node::Ailing,
                (NodeMode::Operational, Health::Critical) => Node::Unfit,
                (NodeMode::Initialization | NodeMode::Maintenance | NodeMode::SoftwareUpdate, _) => Node::Unfit,
                (NodeMode::Offline | NodeMode::Reserved(_), _) => Node::Unfit,
            },
        };
        if std::mem::replace(&mut self.node, node) == node {
            return;
        }
        let fit = matches!(node, Node::Well | Node::Ailing);
        if !fit {
            self.sectors.clear();
        }
        match (fit && self.params.silent_is_clear, fit) {
            (true, _) => _ = self.round.get_or_insert(now),
            (false, true) => {}
            (false, false) => self.round = None,
        }
        self.tell_node(node);
    }

    fn tell_node(&mut self, node: Node) {
        let id = self.params.node.0;
        let says = self.status.map_or_else(String::new, |(_, status)| {
            format!("health {:?}, mode {:?}", status.health, status.mode).to_lowercase()
        });
        let (severity, text) = match node {
            Node::Unheard => return,
            Node::Well => (Severity::Info, format!("lidar node {id}: {says}")),
            Node::Ailing => (Severity::Warning, format!("lidar node {id}: {says}: its silence is not taken as clear")),
            Node::Unfit => (Severity::Error, format!("lidar node {id}: {says}: no scans are taken from it")),
            Node::Lost => {
                (Severity::Error, format!("lidar node {id}: no NodeStatus for 3 s: no scans are taken from it"))
            }
        };
        self.events.push(Event::Text(severity, text));
    }

    fn answer_node_info(&mut self, now: Stamp, asker: CanNode, request: &Transfer) {
        let own = self.params.own_node;
        let id = FrameId::Service {
            priority: PRIORITY,
            type_id: GET_NODE_INFO_ID,
            request: false,
            destination: asker,
            source: own,
        };
        let mut unique_id = *b"drover robot   \0";
        unique_id[15] = own.0;
        let (status, name) = (self.own_status(now), NODE_NAME.to_owned());
        let info = NodeInfo { status, software: [0, 1], hardware: [0, 0], unique_id, name };
        self.send(split(id, GET_NODE_INFO_SIGNATURE, request.transfer_id, &info.emit()));
    }

    fn own_status(&self, now: Stamp) -> NodeStatus {
        let uptime_s = u32::try_from(now.since(self.started).as_secs()).unwrap_or(u32::MAX);
        NodeStatus { uptime_s, ..NodeStatus::default() }
    }

    fn send(&mut self, frames: Vec<CanFrame>) {
        for frame in frames {
            self.outputs.push(frame);
        }
    }
}

/// What is followed: the lidar's three messages, and questions to us. By its signature.
fn wanted(id: &FrameId, lidar: CanNode, own: CanNode) -> Option<u64> {
    match *id {
        FrameId::Message { source, type_id, .. } if source == lidar => match type_id {
            NODE_STATUS_ID => Some(NODE_STATUS_SIGNATURE),
            PROXIMITY_ID => Some(PROXIMITY_SIGNATURE),
            MEASUREMENT_ID => Some(MEASUREMENT_SIGNATURE),
            _ => None,
        },
        FrameId::Service { type_id: GET_NODE_INFO_ID, request: true, destination, .. } if destination == own => {
            Some(GET_NODE_INFO_SIGNATURE)
        }
        FrameId::Message { .. } | FrameId::Service { .. } | FrameId::Anonymous { .. } => None,
    }
}
