//! Two published controllers beside which our deployment runs: same scene, same radio, same targets, same measures.
//!
//! **In**: once a period, everybody's position in one snapshot (metres, world frame), and a [`Scene`]: walls as
//! capsules, one target for each robot (assigned already), ranges and gaps. **Out**: one end of a straight move for
//! each robot, no farther away than `step_m`. Whoever runs a peer moves everybody at once, along straight lines, at
//! constant speed; [`run()`] does that and measures in continuous time.
//!
//! | peer | source | what it gets that a real swarm would not have |
//! |---|---|---|
//! | [`Cbf`] | Wang, Ames, Egerstedt 2016, 2017; Luo, Yi, Sycara 2020 | the spanning tree of all, each period |
//! | [`Fiedler`] | Sabattini, Chopra, Secchi 2013 | the exact eigenvalue, and the motion of all within the period |
//!
//! Both see walls and robots within [`SIGHT_M`], as ours does, and both get detours out of deadlocks, which their
//! papers do not have in this strength. What was tuned, and on which scenes, stands in each file.

mod cbf;
mod detour;
mod fiedler;
mod links;
mod qp;
mod run;

pub(crate) use run::run;

use cbf::{Cbf, CbfParams};
use detour::DetourParams;
use drover_contract::Vec2;
use drover_core::avoid::Capsule;
use fiedler::{Fiedler, FiedlerParams};

/// Walls and robots farther away than this are not known, metres.
pub(crate) const SIGHT_M: f64 = 2.5;

/// Who is nearer to its target than this has arrived, metres.
pub(crate) const ARRIVED_M: f64 = 0.25;

/// The task, the same in every period; world frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    /// Pieces of walls.
    pub(crate) walls: &'a [Capsule],
    /// Where each robot is to go.
    pub(crate) targets_w: &'a [Vec2],
    /// Radio: two robots hear each other up to here, metres.
    pub(crate) range_m: f64,
    /// `v_max T`: nobody goes farther in one period, metres.
    pub(crate) step_m: f64,
    /// `T`, seconds.
    pub(crate) period_s: f64,
    /// Centres of robots are to keep this distance, metres.
    pub(crate) robot_gap_m: f64,
    /// Centres are to keep this distance from walls, metres.
    pub(crate) wall_gap_m: f64,
}

impl Scene<'_> {
    /// The wish both peers start from: straight to the target, at full speed until it can be reached in one period.
    fn wish(&self, robot: usize, at_w: Vec2) -> Vec2 {
        shortened(self.targets_w[robot] - at_w, self.step_m)
    }

    /// The pieces of walls that a robot at `at_w` sees.
    fn seen(&self, at_w: Vec2) -> impl Iterator<Item = &Capsule> {
        self.walls.iter().filter(move |wall| wall.at_least_m(at_w) < SIGHT_M && wall.distance_m(at_w) < SIGHT_M)
    }
}

/// A controller of synchronous point robots.
pub(crate) trait Peer {
    /// What the tables call it.
    fn name(&self) -> &'static str;

    /// One period: where everybody is, metres, to where everybody goes straight.
    fn round(&mut self, scene: &Scene<'_>, at_w: &[Vec2]) -> Vec<Vec2>;

    /// How often so far a robot had to stay because its problem had no solution.
    fn cannot_solve(&self) -> u64 {
        0
    }
}

/// Each peer as it does best, and the same without detours. Fresh: a peer remembers one run.
pub(crate) fn all() -> Vec<Box<dyn Peer>> {
    let detour = DetourParams::NONE;
    vec![
        Box::new(Cbf::default()),
        Box::new(Cbf::new(CbfParams { detour, ..CbfParams::default() })),
        Box::new(Fiedler::default()),
        Box::new(Fiedler::new(FiedlerParams { detour, ..FiedlerParams::default() })),
    ]
}

/// `step`, no longer than `length_m_max`.
fn shortened(step: Vec2, length_m_max: f64) -> Vec2 {
    let length_m = step.norm();
    if length_m <= length_m_max { step } else { step * (length_m_max / length_m) }
}

/// A quarter turn to the left.
fn left_of(direction: Vec2) -> Vec2 {
    Vec2::new(-direction.y, direction.x)
}

#[cfg(test)]
mod tests;
