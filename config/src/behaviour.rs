//! What a swarm is to do.

use crate::deploy::{Assignment, Deploy};
use serde::Serialize;

/// The behaviour of the whole swarm.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Behaviour {
    /// Sequential flocking behind a leader (Cheng 2011).
    Flock(Flock),
    /// Diffusion: straight on, and a turn away from whatever is near. Nobody needs anybody; there is no end to reach.
    Diffuse(Diffuse),
    /// Deployment to a layout, connected at every moment (Fan 2010).
    Deploy(Deploy),
}

impl Behaviour {
    /// The same for one robot's own file: who goes where is decided, and is not to be decided again.
    pub(crate) fn assigned(&self) -> Self {
        let mut behaviour = self.clone();
        if let Self::Deploy(deploy) = &mut behaviour {
            deploy.assignment = Assignment::Given;
        }
        behaviour
    }
}

/// Parameters of diffusion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Diffuse {
    /// Speed straight on, m/s.
    pub speed_mps: f64,
    /// Turn on the spot, rad/s.
    pub turn_radps: f64,
    /// Something nearer than this ahead is turned away from, metres from the body's centre.
    pub clearance_m: f64,
    /// Ahead is within this angle of the heading, radians, to either side.
    pub ahead_rad: f64,
}

/// Parameters of sequential flocking. Symbols are the paper's; defaults are its values, scaled from 100 mm to metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flock {
    /// The robot that the others follow.
    pub leader: u32,
    /// The leader's way, metres, world frame, at least one point.
    pub waypoints_m: Vec<[f64; 2]>,
    /// The leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// The leader has reached a point at this distance, metres.
    pub waypoint_radius_m: f64,
    /// A follower has reached the leader's end at this distance from the last point, metres.
    pub arrive_radius_m: f64,
    /// L: distance between neighbours at which they neither attract nor repel, metres.
    pub spacing_m: f64,
    /// A: strength of the pair potential (eq. 3), m^2/s^2.
    pub gain: f64,
    /// S: an obstacle nearer than this repels, metres from the reference point.
    pub obstacle_range_m: f64,
    /// d: the reference point lies this far ahead of the wheels' axis (eq. 6), metres.
    pub head_offset_m: f64,
    /// Gain on the velocity difference to the leader (eq. 2), 1/s. The paper's is 1.
    pub damping_per_s: f64,
    /// m: mass in eq. 6, kg.
    pub mass_kg: f64,
    /// I: moment of inertia in eq. 6, kg m^2.
    pub inertia_kgm2: f64,
}
