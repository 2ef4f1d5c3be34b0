//! The set itself: what a robot may do in one step, whatever it wants.

use super::Capsule;
use drover_contract::Vec2;

/// Rounding must not lock a robot that stands on a bound, metres.
const ROUNDING_M: f64 = 1e-9;

/// How much room is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeSetParams {
    /// `d_s`: centres of robots keep this distance, metres.
    pub robot_gap_m: f64,
    /// `d_o`: centres keep this distance from walls, metres.
    pub wall_gap_m: f64,
    /// `v_max T`: nobody goes farther in one step, metres.
    pub step_m_max: f64,
}

/// C: the end must lie in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// World frame, metres.
    pub centre_w: Vec2,
    /// Metres.
    pub radius_m: f64,
}

impl Disc {
    /// Half of the way to a neighbour is the centre: both ends of a link use the same disc of diameter `range_m`.
    #[must_use]
    pub fn between(own_w: Vec2, peer_w: Vec2, range_m: f64) -> Self {
        Self { centre_w: (own_w + peer_w) / 2.0, radius_m: range_m / 2.0 }
    }
}

/// R: the end may lie no farther than `advance_m` along `normal_w` from where the robot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// Towards the other, a unit vector, world frame.
    pub normal_w: Vec2,
    /// Metres, >= 0.
    pub advance_m: f64,
}

/// Where a robot may go in one step. Its lists are kept from step to step for their memory.
#[derive(Clone, Debug)]
pub struct SafeSet {
    params: SafeSetParams,
    at_w: Vec2,
    discs: Vec<Disc>,
    planes: Vec<HalfPlane>,
    /// Each with the distance to keep from it.
    walls: Vec<(Capsule, f64)>,
}

impl SafeSet {
    /// The set of a robot at `at_w` with nobody and nothing around it.
    #[must_use]
    pub fn new(params: SafeSetParams, at_w: Vec2) -> Self {
        Self { params, at_w, discs: Vec::new(), planes: Vec::new(), walls: Vec::new() }
    }

    /// C, R and O of a robot at `at_w`: the discs of its links, the robots and the walls around it.
    #[must_use]
    pub fn around(
        params: SafeSetParams,
        at_w: Vec2,
        discs: impl Iterator<Item = Disc>,
        peers_w: impl Iterator<Item = Vec2>,
        walls: &[Capsule],
    ) -> Self {
        let mut set = Self::new(params, at_w);
        discs.for_each(|disc| set.stay_in(disc));
        peers_w.for_each(|peer_w| set.leave_half_to(peer_w));
        walls.iter().for_each(|wall| set.keep_from(*wall));
        set
    }

    /// Forget everything: the robot is at `at_w` now.
    pub fn reset(&mut self, at_w: Vec2) {
        self.at_w = at_w;
        self.discs.clear();
        self.planes.clear();
        self.walls.clear();
    }

    /// C: stay in `disc`. Who is outside already may not go farther from its centre.
    pub fn stay_in(&mut self, disc: Disc) {
        let radius_m = disc.radius_m.max((self.at_w - disc.centre_w).norm());
        self.discs.push(Disc { radius_m, ..disc });
    }

    /// R: leave another robot its half. Who is far enough that neither can reach the other is no bound. Two at the very
    /// same place have no half: both stay.
    pub fn leave_half_to(&mut self, peer_w: Vec2) {
        let to_peer = peer_w - self.at_w;
        let apart_m = to_peer.norm();
        if apart_m >= self.params.robot_gap_m + 2.0 * self.params.step_m_max {
            return;
        }
        let advance_m = (apart_m - self.params.robot_gap_m.min(apart_m)) / 2.0;
        match to_peer.try_normalize(1e-12) {
            Some(normal_w) => self.planes.push(HalfPlane { normal_w, advance_m }),
            None => self.discs.push(Disc { centre_w: self.at_w, radius_m: 0.0 }),
        }
    }

    /// O: keep clear of `wall`, by as much as it is away where it is nearer than allowed already.
    pub fn keep_from(&mut self, wall: Capsule) {
        let reach_m = self.params.wall_gap_m + self.params.step_m_max;
        if wall.at_least_m(self.at_w) < reach_m {
            let here_m = wall.distance_m(self.at_w);
            if here_m < reach_m {
                self.walls.push((wall, self.params.wall_gap_m.min(here_m)));
            }
        }
    }

    /// Where the robot is.
    #[must_use]
    pub fn at_w(&self) -> Vec2 {
        self.at_w
    }

    /// The discs of C.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// The half-planes of R.
    #[must_use]
    pub fn planes(&self) -> &[HalfPlane] {
        &self.planes
    }

    /// The walls of O, each with the distance to keep from it, metres.
    #[must_use]
    pub fn walls(&self) -> &[(Capsule, f64)] {
        &self.walls
    }

    /// Whether the robot may go straight to `to_w`.
    #[must_use]
    pub fn allows(&self, to_w: Vec2) -> bool {
        let step = to_w - self.at_w;
        step.norm() <= self.params.step_m_max + ROUNDING_M
            && self.planes.iter().all(|plane| step.dot(&plane.normal_w) <= plane.advance_m + ROUNDING_M)
            && self.discs.iter().all(|disc| (to_w - disc.centre_w).norm() <= disc.radius_m + ROUNDING_M)
            && self.walls.iter().all(|(wall, keep_m)| wall.clearance_m(self.at_w, to_w) >= keep_m - ROUNDING_M)
    }
}
