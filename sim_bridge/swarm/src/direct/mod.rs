//! A swarm on values: the same world, the same laws and supervisors as everywhere, and no bytes between them.
//!
//! What the wire adds (codecs, handshakes, quantisation) is left out; when things happen is kept. In each step of the
//! world the bodies move, then every robot senses, decides and commands, then beacons travel, as in
//! [`crate::VirtualSwarm`]. Robots sense and decide side by side on all cores: each reads the place as it is and writes
//! only what is its own, so the number of threads changes nothing (invariant 9).

mod agent;
mod inbox;

use crate::trial::Trial;
use agent::{Agent, Around};
use drover_config::{RobotFile, Swarm};
use drover_contract::{RobotId, Stamp, Twist};
use drover_core::map::SharedMap;
use drover_core::{Roster, Status, Workspace};
use drover_robot::View;
use drover_world::{Arena, BodySpec, Radio, RadioTally};
use inbox::{Inbox, Number, Words};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Duration;

/// Robots that one thread takes at once: fewer are not worth another thread's waking.
const ROBOTS_PER_JOB: usize = 128;

/// A swarm on values.
pub struct DirectSwarm {
    now: Stamp,
    step: Duration,
    arena: Arena,
    agents: Vec<Agent>,
    radio: Radio<Number>,
    inbox: Inbox,
    /// What each robot asks of its body, and says in this step: lists of their own, to be gone through without touching
    /// the robots.
    demands: Vec<Twist>,
    beacons: Vec<Option<Words>>,
}

impl DirectSwarm {
    /// A swarm at rest at time zero.
    #[must_use]
    pub fn new(swarm: &Swarm) -> Self {
        Self::of(swarm, |file| file)
    }

    /// The same with each robot's file as `change` leaves it, for example with a leader of its own.
    #[must_use]
    pub fn of(swarm: &Swarm, change: impl Fn(RobotFile) -> RobotFile) -> Self {
        let radius_m = |robot| swarm.kind_of(robot).body.radius_m;
        let roster = Roster::new(swarm.robots.iter().map(|robot| (RobotId(robot.id), radius_m(robot))));
        let roster = Arc::new(roster);
        let files = swarm.robots.iter().map(|robot| change(swarm.file_without_peers(robot)));
        let step = Duration::from_millis(u64::from(swarm.step_ms.max(1)));
        let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
        Self {
            now: Stamp::ZERO,
            step,
            arena: Arena::new(&swarm.world, &BodySpec::all_of(swarm), swarm.seed),
            agents: files.map(|file| Agent::new(&file, &roster, swarm.seed)).collect(),
            radio: Radio::new(&swarm.radio, &ids, swarm.seed),
            inbox: Inbox::new(&swarm.radio, step),
            demands: vec![Twist::ZERO; swarm.robots.len()],
            beacons: vec![const { None }; swarm.robots.len()],
        }
    }

    /// Robot `robot`'s drive obeys from `at` on: what a handshake on a wire would have taken.
    ///
    /// # Panics
    /// If there is no such robot.
    pub fn set_ready_at(&mut self, robot: usize, at: Stamp) {
        self.agents[robot].set_ready_at(at);
    }

    /// What a robot's node makes of it all.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn status_of(&self, robot: usize) -> &Status {
        self.agents[robot].status()
    }

    fn turn_all(&mut self) {
        let Self { arena, agents, inbox, demands, beacons, now, .. } = self;
        let (eyes, lidars) = arena.eyes();
        let robots =
            agents.par_iter_mut().zip(lidars.par_iter_mut()).zip(demands.par_iter_mut().zip(beacons.par_iter_mut()));
        let robots = robots.enumerate().with_min_len(ROBOTS_PER_JOB);
        robots.for_each_init(Workspace::default, |workspace, (robot, ((agent, lidar), (demand, beacon)))| {
            let state = eyes.state(robot);
            let mut around = Around { place: eyes.place(), robot, lidar, state, heard: inbox.of(robot) };
            *beacon = agent.turn(*now, &mut around, workspace);
            *demand = agent.demand();
        });
    }

    fn carry_beacons(&mut self) {
        let Self { arena, beacons, radio, inbox, now, .. } = self;
        for (robot, beacon) in beacons.iter_mut().enumerate() {
            if let Some(beacon) = beacon.take() {
                radio.broadcast(*now, robot, arena.place(), inbox.say(beacon));
            }
        }
        inbox.clear(*now);
        radio.deliver(*now, |to, _, number| inbox.put(to, *number));
        inbox.sort(beacons.len());
    }
}

impl Trial for DirectSwarm {
    fn now(&self) -> Stamp {
        self.now
    }

    fn step(&mut self) {
        self.now = self.now + self.step;
        self.arena.step(self.step.as_secs_f64(), &self.demands);
        self.turn_all();
        self.carry_beacons();
    }

    fn arena(&self) -> &Arena {
        &self.arena
    }

    fn status(&self, robot: usize) -> Option<&Status> {
        self.agents.get(robot).map(Agent::status)
    }

    fn view(&self, robot: usize) -> Option<View> {
        self.agents.get(robot).map(|agent| agent.view(self.now))
    }

    fn map(&self, robot: usize) -> Option<&SharedMap> {
        self.agents.get(robot).and_then(Agent::map)
    }

    fn radio(&self) -> RadioTally {
        self.radio.tally()
    }

    fn aged_commands(&self) -> u64 {
        0 // a command reaches its drive within the step in which it was made
    }

    fn bytes(&self) -> usize {
        let agents: usize = self.agents.iter().map(|agent| size_of::<Agent>() + agent.bytes()).sum();
        agents + self.arena.bytes().0 + self.radio.bytes() + self.inbox.bytes()
    }
}
