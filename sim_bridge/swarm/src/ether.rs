//! Beacons between robots of one process: the same bytes as on the wire, through the modelled radio.

use drover_config::Swarm;
use drover_contract::{Link, Stamp};
use drover_io::MemoryLink;
use drover_world::{Radio, RadioTally, Scene};
use std::sync::Arc;

/// Longest message on the beacon plane.
const MESSAGE_BYTES: usize = 512;
/// Messages taken from one robot in one turn at most.
const MESSAGES_PER_TURN: usize = 16;

/// The space between the robots: takes what each sends and gives it to those who hear it.
pub(crate) struct Ether {
    radio: Radio<Arc<[u8]>>,
    ends: Vec<MemoryLink>,
    sent_bytes: u64,
}

impl Ether {
    /// A quiet ether with the swarm's radio; `ends[i]` is the far end of robot i's beacon link.
    pub(crate) fn new(swarm: &Swarm, ends: Vec<MemoryLink>) -> Self {
        let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
        Self { radio: Radio::new(&swarm.radio, &ids, swarm.seed), ends, sent_bytes: 0 }
    }

    /// Robot `index` has a new beacon link; what the old one held is lost.
    pub(crate) fn replace(&mut self, index: usize, end: MemoryLink) {
        self.ends[index] = end;
    }

    /// Every robot hears `message`, whatever the radio does.
    pub(crate) fn say_to_all(&mut self, message: &[u8]) {
        for end in &mut self.ends {
            // A robot that has gone hears nothing.
            let _ = end.send(message);
        }
    }

    /// What happened so far.
    pub(crate) fn tally(&self) -> RadioTally {
        self.radio.tally()
    }

    /// What the robots said, bytes.
    pub(crate) const fn sent_bytes(&self) -> u64 {
        self.sent_bytes
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.radio.bytes()
    }

    /// Carry what was sent, with the bodies where `scene` has them.
    pub(crate) fn turn<S: Scene + ?Sized>(&mut self, now: Stamp, scene: &S) {
        let mut buf = [0; MESSAGE_BYTES];
        for from in 0..self.ends.len() {
            for _ in 0..MESSAGES_PER_TURN {
                let Ok(Some(len)) = self.ends[from].try_recv(&mut buf) else { break };
                self.sent_bytes += len as u64;
                self.radio.broadcast(now, from, scene, buf[..len].into());
            }
        }
        let ends = &mut self.ends;
        self.radio.deliver(now, |to, _, bytes| {
            // A robot that has gone hears nothing; that is its business and not the ether's.
            let _ = ends[to].send(bytes);
        });
    }
}
