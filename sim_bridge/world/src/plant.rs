//! Everything on the far side of all links: bodies in an arena, and the firmware that moves them.
//!
//! The robots' side knows the plant by messages on ports only (invariant 10). Time moves in whole steps: in each, the
//! bodies move by what their firmware asked for, then lidars that are due cast a scan, then the firmware gets to see
//! its body and speaks.

use crate::arena::{Arena, BodySpec};
use crate::fault::Fault;
use crate::firmware::PeerKey;
use crate::station::Station;
use drover_config::{Robot, Swarm};
use drover_contract::{CanFrame, Pose, Stamp, Twist};
use std::collections::VecDeque;
use std::time::Duration;

/// Messages that wait to be taken at most; when there are more, the oldest is dropped.
const OUTPUTS_MAX: usize = 65_536;

/// What travels on a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Packet {
    /// On a MAVLink link.
    Datagram(Vec<u8>),
    /// On a CAN bus.
    Frame(CanFrame),
}

/// Which of a robot's links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Port {
    /// The MAVLink link to the autopilot and to what stands beside it.
    Autopilot,
    /// The CAN bus of the chassis.
    DriveBus,
    /// The CAN bus of the lidar.
    LidarBus,
}

/// A message from firmware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Index of the robot in the swarm's list.
    pub robot: usize,
    /// On which of its links.
    pub port: Port,
    /// To whom; on a bus to everybody.
    pub to: PeerKey,
    /// The message.
    pub packet: Packet,
}

/// How it really is with a robot: what tests and summaries measure, and no robot knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The body in the world.
    pub pose_wb: Pose,
    /// Its true velocity in its own frame.
    pub twist_b: Twist,
    /// How far its centre has travelled, metres.
    pub path_m: f64,
    /// Smallest gap so far to another body, metres, 0 from a touch on; `None` if it is alone.
    pub gap_robot_m_min: Option<f64>,
    /// Smallest gap so far to a wall or mover, metres, 0 from a touch on; `None` in a world without any.
    pub gap_wall_m_min: Option<f64>,
    /// Whether it touches something now.
    pub in_contact: bool,
    /// What its firmware asks of it now.
    pub demand: Twist,
}

/// The far side of a swarm.
pub struct Plant {
    arena: Arena,
    stations: Vec<Station>,
    /// The world has been stepped up to this moment.
    time: Stamp,
    step: Duration,
    demands: Vec<Twist>,
    outputs: VecDeque<Output>,
    outputs_dropped: u64,
}

impl Plant {
    /// A swarm's bodies at rest on their start poses, and all firmware switched on at `now`.
    #[must_use]
    pub fn new(swarm: &Swarm, now: Stamp) -> Self {
        let bodies: Vec<BodySpec> = BodySpec::all_of(swarm);
        let station = |robot: &Robot| Station::new(swarm.kind_of(robot), robot.id, swarm.seed, now);
        Self {
            arena: Arena::new(&swarm.world, &bodies, swarm.seed),
            stations: swarm.robots.iter().map(station).collect(),
            time: now,
            step: Duration::from_millis(u64::from(swarm.step_ms.max(1))),
            demands: Vec::with_capacity(bodies.len()),
            outputs: VecDeque::new(),
            outputs_dropped: 0,
        }
    }

    /// How many robots there are.
    #[must_use]
    pub fn robot_count(&self) -> usize {
        self.stations.len()
    }

    /// How far the world has come.
    #[must_use]
    pub fn time(&self) -> Stamp {
        self.time
    }

    /// A message from a robot, or from whoever else is on that link, reaches its firmware.
    ///
    /// A robot that does not exist and a message that does not belong on that port are let pass: nothing on a wire
    /// ends the simulation.
    pub fn handle_input(&mut self, now: Stamp, robot: usize, port: Port, from: PeerKey, packet: &Packet) {
        if let Some(station) = self.stations.get_mut(robot) {
            station.handle_input(now, port, from, packet);
        }
    }

    /// Go on to `now` in whole steps; what is left of it waits for the next call.
    pub fn step(&mut self, now: Stamp) {
        while self.time + self.step <= now {
            self.time = self.time + self.step;
            self.step_once();
        }
    }

    /// The next message from firmware: robots in order, each robot's in the order of sending.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When the world must be stepped next.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        Some((self.time + self.step, "world step"))
    }

    /// Break or mend something of a robot; nothing happens if there is no such robot.
    pub fn inject(&mut self, now: Stamp, robot: usize, fault: Fault) {
        if let Some(station) = self.stations.get_mut(robot) {
            station.inject(now, fault);
        }
    }

    /// All bodies and what is around them.
    #[must_use]
    pub fn arena(&self) -> &Arena {
        &self.arena
    }

    /// How it really is with a robot.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn truth(&self, robot: usize) -> Truth {
        let state = self.arena.state(robot);
        Truth {
            pose_wb: state.pose_wb,
            twist_b: state.twist_b,
            path_m: self.arena.path_m(robot),
            gap_robot_m_min: self.arena.gap_robot_m_min(robot),
            gap_wall_m_min: self.arena.gap_wall_m_min(robot),
            in_contact: state.in_contact,
            demand: self.stations[robot].demand(),
        }
    }

    /// Smallest gap so far between any two bodies, metres, 0 from a touch on; `None` with fewer than two.
    #[must_use]
    pub fn min_gap_robot_m(&self) -> Option<f64> {
        self.arena.min_gap_robot_m()
    }

    /// Smallest gap so far between any body and any wall or mover, metres, 0 from a touch on; `None` in a world without
    /// any.
    #[must_use]
    pub fn min_gap_wall_m(&self) -> Option<f64> {
        self.arena.min_gap_wall_m()
    }

    /// Messages lost because nobody took them.
    #[must_use]
    pub fn outputs_dropped(&self) -> u64 {
        self.outputs_dropped
    }

    fn step_once(&mut self) {
        self.demands.clear();
        self.demands.extend(self.stations.iter().map(Station::demand));
        self.arena.step(self.step.as_secs_f64(), &self.demands);
        for robot in 0..self.stations.len() {
            let station = &mut self.stations[robot];
            let scan = station.take_scan_turn(self.time).then(|| self.arena.cast(self.time, robot));
            station.step(self.time, &self.arena.state(robot), scan.as_ref());
            while let Some((port, to, packet)) = station.poll_output() {
                if self.outputs.len() >= OUTPUTS_MAX {
                    self.outputs.pop_front();
                    self.outputs_dropped += 1;
                }
                self.outputs.push_back(Output { robot, port, to, packet });
            }
        }
    }
}

#[cfg(test)]
#[path = "plant_tests.rs"]
mod tests;
