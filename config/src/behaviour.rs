//! What a swarm is to do.

use crate::deploy::{Assignment, Deploy};
use crate::explore::Explore;
use crate::flock::Flock;
use crate::world::World;
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
    /// Exploration of a place that nobody knows (Wu 2008).
    Explore(Explore),
}

impl Behaviour {
    /// The same for one robot's own file: who goes where is decided, and is not to be decided again; what is to be
    /// mapped is said, for the robot has no world.
    pub(crate) fn of_robot(&self, world: &World) -> Self {
        let mut behaviour = self.clone();
        match &mut behaviour {
            Self::Deploy(deploy) => deploy.assignment = Assignment::Given,
            Self::Explore(explore) => explore.area_m = explore.area_m.or_else(|| world.bounds_m()),
            Self::Flock(_) | Self::Diffuse(_) => {}
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
