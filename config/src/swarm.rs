//! A whole swarm in one file.

use crate::{BeaconPlane, Behaviour, Kind, Peer, Radio, Robot, RobotFile, World};
use serde::Serialize;
use std::collections::BTreeMap;

/// A swarm: a world, robot kinds, robots, and what they are to do. One file in `config/swarms/` each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Swarm {
    /// Its name.
    pub name: String,
    /// Seed of everything random in the simulation.
    pub seed: u64,
    /// A run ends after this long, s, unless everything is reached before.
    pub duration_s: f64,
    /// Step of the simulated bodies, ms, 1..=50.
    pub step_ms: u32,
    /// Folder under which each run makes its own folder of recordings.
    pub record_dir: String,
    /// Port of the first virtual autopilot; robot `id` gets `mavlink_port_base + id`.
    pub mavlink_port_base: u16,
    /// The place.
    pub world: World,
    /// Robot kinds by name.
    pub kinds: BTreeMap<String, Kind>,
    /// The robots, in the file's order.
    pub robots: Vec<Robot>,
    /// What they are to do.
    pub behaviour: Behaviour,
    /// How they hear and tell each other, between processes and computers.
    pub beacon: BeaconPlane,
    /// The same within one process.
    pub radio: Radio,
}

impl Swarm {
    /// The kind of `robot`; checked when the file was read.
    ///
    /// # Panics
    /// Never for a robot of this swarm.
    #[must_use]
    pub fn kind_of(&self, robot: &Robot) -> &Kind {
        &self.kinds[&robot.kind]
    }

    /// The file of one robot: what `drover run` needs and nothing else.
    #[must_use]
    pub fn robot_file(&self, id: u32) -> Option<RobotFile> {
        let robot = self.robots.iter().find(|robot| robot.id == id)?;
        let peers = self.robots.iter().filter(|peer| peer.id != id);
        let peers = peers.map(|peer| Peer { id: peer.id, radius_m: self.kind_of(peer).body.radius_m }).collect();
        Some(RobotFile { peers, ..self.file_without_peers(robot) })
    }

    /// The file of one robot of this swarm without its peers: for who keeps one list of them for all robots.
    #[must_use]
    pub fn file_without_peers(&self, robot: &Robot) -> RobotFile {
        RobotFile {
            swarm: self.name.clone(),
            robot: robot.clone(),
            kind: self.kind_of(robot).clone(),
            behaviour: self.behaviour.of_robot(&self.world),
            beacon: self.beacon.clone(),
            peers: Vec::new(),
            record_dir: None,
        }
    }
}
