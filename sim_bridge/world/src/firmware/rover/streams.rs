//! Who listens to the autopilot, and how often each hears what: rates are set per link.

use crate::firmware::PeerKey;
use drover_codec::mavlink::AUTOPILOT_COMPONENT;
use drover_codec::mavlink::device::{AckResult, Speaker};
use drover_contract::{MavId, Stamp};
use rand::Rng;
use rand_pcg::Pcg32;
use std::collections::BTreeMap;
use std::time::Duration;

/// A peer that has been silent for so long is forgotten.
const PEER_SILENCE_MAX: Duration = Duration::from_secs(10);
const PEERS_MAX: usize = 8;
const DEFAULT_SPACING: Duration = Duration::from_secs(1);
/// Asked for more than 40 Hz, an autopilot whose loop runs at 50 Hz refuses.
const SPACING_MIN: Duration = Duration::from_millis(25);

/// What is sent again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stream {
    Heartbeat,
    BridgeHeartbeat,
    SysStatus,
    Attitude,
    Position,
    Sectors,
    Battery,
}

impl Stream {
    pub(super) const ALL: [Self; 7] = [
        Self::Heartbeat,
        Self::BridgeHeartbeat,
        Self::SysStatus,
        Self::Attitude,
        Self::Position,
        Self::Sectors,
        Self::Battery,
    ];

    pub(super) const fn of_message(message: u32) -> Option<Self> {
        match message {
            0 => Some(Self::Heartbeat),
            1 => Some(Self::SysStatus),
            30 => Some(Self::Attitude),
            32 => Some(Self::Position),
            132 => Some(Self::Sectors),
            147 => Some(Self::Battery),
            _ => None,
        }
    }

    /// The streams that one number of the old REQUEST_DATA_STREAM stands for (MAV_DATA_STREAM).
    pub(super) const fn of_group(group: u8) -> &'static [Self] {
        match group {
            0 => &[Self::SysStatus, Self::Attitude, Self::Position, Self::Sectors, Self::Battery],
            2 => &[Self::SysStatus],
            6 => &[Self::Position],
            10 => &[Self::Attitude],
            12 => &[Self::Sectors, Self::Battery],
            _ => &[],
        }
    }
}

/// When a stream is due, and how often; `None`: off.
#[derive(Clone, Copy, Debug)]
struct Timing {
    spacing: Option<Duration>,
    due: Stamp,
}

/// One link to a ground station or an onboard computer.
#[derive(Debug)]
pub(super) struct Peer {
    heard: Stamp,
    timings: [Timing; Stream::ALL.len()],
    pub(super) autopilot: Speaker,
    pub(super) bridge: Speaker,
}

impl Peer {
    fn new(now: Stamp, system: u8, bridge_component: u8, chance: &mut Pcg32) -> Self {
        let speaker = |component| Speaker::new(MavId { system, component });
        // Not all at the same moment, as on a real autopilot.
        let timings = Stream::ALL.map(|_| Timing {
            spacing: Some(DEFAULT_SPACING),
            due: now + DEFAULT_SPACING.mul_f64(chance.random_range(0.0..0.5)),
        });
        Self { heard: now, timings, autopilot: speaker(AUTOPILOT_COMPONENT), bridge: speaker(bridge_component) }
    }

    /// Whether `stream` is due; then it is set to its next moment.
    pub(super) fn take_due(&mut self, now: Stamp, stream: Stream) -> bool {
        let timing = &mut self.timings[stream as usize];
        let Some(spacing) = timing.spacing.filter(|_| timing.due <= now) else { return false };
        // A late step sends one message, not all that were missed.
        timing.due = if timing.due + spacing > now { timing.due + spacing } else { now + spacing };
        true
    }

    /// SET_MESSAGE_INTERVAL: 0 is the default, -1 is off, faster than 40 Hz is denied.
    pub(super) fn set_interval(&mut self, now: Stamp, stream: Stream, interval_us: i64) -> AckResult {
        let spacing = match interval_us {
            -1 => None,
            0 => Some(DEFAULT_SPACING),
            us => match u64::try_from(us).map(Duration::from_micros) {
                Ok(spacing) if spacing >= SPACING_MIN => Some(spacing),
                Ok(_) | Err(_) => return AckResult::Denied,
            },
        };
        self.timings[stream as usize] = Timing { spacing, due: now };
        AckResult::Accepted
    }
}

/// All links, in the order of their keys.
#[derive(Debug)]
pub(super) struct Peers {
    peers: BTreeMap<PeerKey, Peer>,
    system: u8,
    bridge_component: u8,
    chance: Pcg32,
}

impl Peers {
    pub(super) fn new(system: u8, bridge_component: u8, chance: Pcg32) -> Self {
        Self { peers: BTreeMap::new(), system, bridge_component, chance }
    }

    /// `key` has spoken. A full table makes room by forgetting who has been silent longest.
    pub(super) fn hear(&mut self, now: Stamp, key: PeerKey) -> &mut Peer {
        if !self.peers.contains_key(&key) && self.peers.len() >= PEERS_MAX {
            let quietest = self.peers.iter().min_by_key(|(_, peer)| peer.heard).map(|(key, _)| *key);
            quietest.map(|key| self.peers.remove(&key));
        }
        let Self { peers, system, bridge_component, chance } = self;
        let peer = peers.entry(key).or_insert_with(|| Peer::new(now, *system, *bridge_component, chance));
        peer.heard = now;
        peer
    }

    pub(super) fn forget_silent(&mut self, now: Stamp) {
        self.peers.retain(|_, peer| now.since(peer.heard) <= PEER_SILENCE_MAX);
    }

    pub(super) fn forget_all(&mut self) {
        self.peers.clear();
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (PeerKey, &mut Peer)> {
        self.peers.iter_mut().map(|(key, peer)| (*key, peer))
    }

    pub(super) fn get_mut(&mut self, key: PeerKey) -> Option<&mut Peer> {
        self.peers.get_mut(&key)
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.peers.len()
    }
}
