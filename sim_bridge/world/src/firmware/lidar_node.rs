//! A virtual lidar node on DroneCAN: a scan of the world in, one Proximity message a sector out.
//!
//! Frames are cut and numbered here, from the specification, and not by `drover-codec`, so that the two prove each
//! other (and pydronecan proves both). A scan's sectors are sent one after the other over half the scan period: a
//! burst would hold up everybody else on the bus, and a full period would make the last sector as old as the next scan.

use drover_contract::{Beam, CanFrame, CanId, CanNode, Scan, Stamp, wrap};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::time::Duration;

const STATUS_PERIOD: Duration = Duration::from_secs(1);
const PRIORITY_SENSOR: u32 = 16;
const PRIORITY_STATUS: u32 = 20;
const OUTPUTS_MAX: usize = 1024;
const NODE_NAME: &[u8] = b"drover.sim.lidar";

/// One data type: its number and the state of the CRC after its signature (DSDL, "base CRC").
#[derive(Clone, Copy, Debug)]
struct DataType {
    id: u32,
    base_crc: u16,
}

const PROXIMITY: DataType = DataType { id: 21_910, base_crc: 0x96AC };
const NODE_STATUS: DataType = DataType { id: 341, base_crc: 0xBE5F };
const GET_NODE_INFO: DataType = DataType { id: 1, base_crc: 0xD9A7 };

/// What a virtual lidar node is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DronecanSimParams {
    /// Its node id, 1..=127.
    pub node: CanNode,
    /// Its number among the node's sensors.
    pub sensor_id: u8,
    /// Sectors of a full turn, the first straight ahead.
    pub sectors: u32,
    /// Scans a second: how long the sectors of one are spread.
    pub rate_hz: f64,
    /// Whether it says nothing about a sector without an obstacle, as AP_Periph does; else it says its greatest range.
    pub silent_is_clear: bool,
}

/// How its NodeStatus says the node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeHealth {
    /// All well.
    Ok,
    /// A minor failure.
    Warning,
    /// A major failure.
    Error,
    /// It cannot do its work.
    Critical,
}

/// A sector still to be sent.
#[derive(Clone, Copy, Debug)]
struct Pending {
    due: Stamp,
    payload: [u8; 8],
}

/// A virtual lidar node. Pure: scans and frames in, frames out.
#[derive(Clone, Debug)]
pub struct VirtualDronecanLidar {
    params: DronecanSimParams,
    started: Option<Stamp>,
    status_due: Stamp,
    health: NodeHealth,
    proximity_transfer: u8,
    status_transfer: u8,
    unique_id: [u8; 16],
    pending: VecDeque<Pending>,
    outputs: VecDeque<CanFrame>,
}

impl VirtualDronecanLidar {
    /// A node that starts with its first step. The seed makes its unique id.
    #[must_use]
    pub fn new(params: DronecanSimParams, seed: u64) -> Self {
        let mut rng = Pcg32::seed_from_u64(seed);
        Self {
            params,
            started: None,
            status_due: Stamp::ZERO,
            health: NodeHealth::Ok,
            proximity_transfer: 0,
            status_transfer: 0,
            unique_id: std::array::from_fn(|_| rng.random()),
            pending: VecDeque::new(),
            outputs: VecDeque::new(),
        }
    }

    /// Take a frame from the bus: a request for our GetNodeInfo is answered, everything else is let pass.
    pub fn handle_frame(&mut self, now: Stamp, frame: &CanFrame) {
        let CanId::Extended(raw) = frame.id() else { return };
        // Service 1, request, to us; the request is empty, so its one frame is the tail alone.
        let ours = raw & 0x00FF_FF80 == GET_NODE_INFO.id << 16 | 1 << 15 | u32::from(self.params.node.0) << 8 | 1 << 7;
        let (asker, &[tail]) = (raw & 0x7F, frame.data()) else { return };
        if !ours || asker == 0 || tail & 0xE0 != 0xC0 {
            return;
        }
        let id = raw & 0x1F00_0000 | GET_NODE_INFO.id << 16 | asker << 8 | 1 << 7 | self.source();
        let payload = self.node_info(now);
        self.send(id, GET_NODE_INFO, tail & 0x1F, &payload);
    }

    /// Let time pass. `scan` is given once, when the world has cast it.
    pub fn step(&mut self, now: Stamp, scan: Option<&Scan>) {
        self.started.get_or_insert(now);
        if now >= self.status_due {
            self.status_due = now + STATUS_PERIOD;
            let id = PRIORITY_STATUS << 24 | NODE_STATUS.id << 8 | self.source();
            let payload = self.status(now);
            let transfer = next(&mut self.status_transfer);
            self.send(id, NODE_STATUS, transfer, &payload);
        }
        if let Some(scan) = scan {
            self.send_due(None); // what is left of the last scan has no time left
            self.plan(now, scan);
        }
        self.send_due(Some(now));
    }

    /// The next frame that it sends.
    pub fn poll_output(&mut self) -> Option<CanFrame> {
        self.outputs.pop_front()
    }

    /// Say this health from the next NodeStatus on.
    pub fn set_health(&mut self, health: NodeHealth) {
        self.health = health;
    }

    /// Give every sector of `scan` its turn within half a scan period from now.
    fn plan(&mut self, now: Stamp, scan: &Scan) {
        let count = self.params.sectors.max(1);
        let gap = Duration::from_secs_f64(0.5 / self.params.rate_hz.max(0.1) / f64::from(count));
        for (index, beam) in sector_beams(scan, count).into_iter().enumerate() {
            let due = now + gap * index as u32;
            if let Some(payload) = self.proximity(index, beam, scan.range_m_max) {
                self.pending.push_back(Pending { due, payload });
            }
        }
    }

    /// Send the sectors whose turn has come; all of them without a time.
    fn send_due(&mut self, now: Option<Stamp>) {
        let id = PRIORITY_SENSOR << 24 | PROXIMITY.id << 8 | self.source();
        while let Some(&pending) = self.pending.front() {
            if now.is_some_and(|now| pending.due > now) {
                break;
            }
            self.pending.pop_front();
            let transfer = next(&mut self.proximity_transfer);
            self.send(id, PROXIMITY, transfer, &pending.payload);
        }
    }

    /// Proximity: u8 sensor, u3 reading, u5 flags, f16 yaw, f16 pitch (degrees), f16 distance (metres). Yaw is
    /// clockwise seen from above. A number is not available without a reading: it is then 0.
    fn proximity(&self, index: usize, beam: Beam, range_m_max: f64) -> Option<[u8; 8]> {
        let (no_data, good) = (0, 2);
        let (reading, distance_m) = match beam {
            Beam::Hit(range_m) => (good, range_m),
            Beam::Clear if self.params.silent_is_clear => return None,
            Beam::Clear => (good, range_m_max),
            Beam::Unknown => (no_data, 0.0),
        };
        let bearing_rad = wrap(TAU * index as f64 / f64::from(self.params.sectors.max(1)));
        let [y0, y1] = half(-bearing_rad.to_degrees());
        let [d0, d1] = half(distance_m);
        Some([self.params.sensor_id, reading << 5, y0, y1, 0, 0, d0, d1])
    }

    /// NodeStatus: u32 uptime, u2 health, u3 mode (0 operational), u3 sub-mode, u16 vendor code.
    fn status(&self, now: Stamp) -> [u8; 7] {
        let uptime_s = self.started.map_or(0, |started| now.since(started).as_secs()) as u32;
        let [a, b, c, d] = uptime_s.to_le_bytes();
        let health = match self.health {
            NodeHealth::Ok => 0,
            NodeHealth::Warning => 1,
            NodeHealth::Error => 2,
            NodeHealth::Critical => 3,
        };
        [a, b, c, d, health << 6, 0, 0]
    }

    /// GetNodeInfo's answer: status, software 1.0 (15 bytes), hardware 1.0 (2 + 16 + certificate's length), name.
    fn node_info(&self, now: Stamp) -> Vec<u8> {
        let mut payload = self.status(now).to_vec();
        payload.extend_from_slice(&[1, 0]);
        payload.extend_from_slice(&[0; 13]);
        payload.extend_from_slice(&[1, 0]);
        payload.extend_from_slice(&self.unique_id);
        payload.push(0);
        payload.extend_from_slice(NODE_NAME);
        payload
    }

    fn source(&self) -> u32 {
        u32::from(self.params.node.0 & 0x7F)
    }

    /// Cut a payload into frames: one of up to 7 bytes, or several with the CRC in front; each with its tail byte.
    fn send(&mut self, id: u32, data_type: DataType, transfer: u8, payload: &[u8]) {
        let mut bytes = Vec::with_capacity(payload.len() + 2);
        if payload.len() > 7 {
            bytes.extend_from_slice(&crc(data_type.base_crc, payload).to_le_bytes());
        }
        bytes.extend_from_slice(payload);
        let last = bytes.len().saturating_sub(1) / 7;
        for number in 0..=last {
            let mut data = bytes.iter().copied().skip(number * 7).take(7).collect::<Vec<u8>>();
            let mut tail = transfer & 0x1F;
            if number == 0 {
                tail |= 0x80; // start of transfer
            }
            if number == last {
                tail |= 0x40; // end of transfer
            }
            if number % 2 == 1 {
                tail |= 0x20; // toggle
            }
            data.push(tail);
            self.queue(id, &data);
        }
    }

    fn queue(&mut self, id: u32, data: &[u8]) {
        if let Ok(frame) = CanFrame::new(CanId::Extended(id), data) {
            if self.outputs.len() >= OUTPUTS_MAX {
                self.outputs.pop_front();
            }
            self.outputs.push_back(frame);
        }
    }
}

/// What each sector shows of a scan's beams: the nearest hit; else clear if any beam is; else nothing known.
fn sector_beams(scan: &Scan, count: u32) -> Vec<Beam> {
    let mut sectors = vec![Beam::Unknown; count as usize];
    for (index, beam) in scan.beams.iter().enumerate() {
        let turns = scan.angle_rad(index) / TAU;
        let sector = (turns.rem_euclid(1.0) * f64::from(count)).round() as usize % count as usize;
        sectors[sector] = match (sectors[sector], *beam) {
            (Beam::Hit(a), Beam::Hit(b)) => Beam::Hit(a.min(b)),
            (Beam::Hit(range_m), _) | (_, Beam::Hit(range_m)) => Beam::Hit(range_m),
            (Beam::Clear, _) | (_, Beam::Clear) => Beam::Clear,
            (Beam::Unknown, Beam::Unknown) => Beam::Unknown,
        };
    }
    sectors
}

/// This transfer's number; the next one's follows, modulo 32.
fn next(counter: &mut u8) -> u8 {
    let this = *counter;
    *counter = (this + 1) & 0x1F;
    this
}

/// CRC-16-CCITT-FALSE over `bytes`, from the state `crc`; one bit at a time.
fn crc(mut crc: u16, bytes: &[u8]) -> u16 {
    for bit in bytes.iter().flat_map(|byte| (0..8).rev().map(move |shift| u16::from(byte >> shift & 1))) {
        let feedback = crc >> 15 ^ bit;
        crc = (crc << 1) ^ (feedback * 0x1021);
    }
    crc
}

/// A number as IEEE 754 binary16, little-endian: the nearest one, halfway cases away from zero. What is smaller than
/// the smallest normal half (0.00006) becomes 0, what is greater than the greatest becomes it: neither is a range.
fn half(value: f64) -> [u8; 2] {
    let sign = u16::from(value < 0.0) << 15;
    let size = value.abs().min(65_504.0) as f32;
    if size < 6.104e-5 {
        return sign.to_le_bytes();
    }
    let rounded = size.to_bits() + 0x1000; // half of the last of the ten bits that stay
    let rebased = (rounded >> 13) - ((127 - 15) << 10);
    (sign | rebased as u16).to_le_bytes()
}

#[cfg(test)]
mod tests;
