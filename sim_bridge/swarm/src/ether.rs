//! Beacons between robots of one process: the same bytes as on the wire, through the modelled radio.

use drover_contract::{Link, Stamp, Vec2};
use drover_io::MemoryLink;
use drover_world::Radio;

/// Longest message on the beacon plane.
const MESSAGE_BYTES: usize = 512;
/// Messages taken from one robot in one turn at most.
const MESSAGES_PER_TURN: usize = 16;

/// The space between the robots: takes what each sends and gives it to those who hear it.
pub(crate) struct Ether {
    radio: Radio,
    ends: Vec<MemoryLink>,
}

impl Ether {
    /// An ether over `radio`; `ends[i]` is the far end of robot i's beacon link.
    pub(crate) fn new(radio: Radio, ends: Vec<MemoryLink>) -> Self {
        Self { radio, ends }
    }

    /// Robot `index` has a new beacon link; what the old one held is lost.
    pub(crate) fn replace(&mut self, index: usize, end: MemoryLink) {
        self.ends[index] = end;
    }

    /// Carry what was sent, with the bodies at `positions_w` (true positions, one a robot).
    pub(crate) fn turn(&mut self, now: Stamp, positions_w: &[Vec2]) {
        let mut buf = [0; MESSAGE_BYTES];
        for from in 0..self.ends.len() {
            for _ in 0..MESSAGES_PER_TURN {
                let Ok(Some(len)) = self.ends[from].try_recv(&mut buf) else { break };
                self.radio.broadcast(now, from, positions_w, &buf[..len]);
            }
        }
        while let Some((to, bytes)) = self.radio.poll(now) {
            // A robot that has gone hears nothing; that is its business and not the ether's.
            let _ = self.ends[to].send(&bytes);
        }
    }
}
