//! What is measured of a moment: gaps, how well the swarm hangs together, how much it moves as one, what it has seen.
//!
//! Pure functions of a [`Setting`] and a [`Moment`]. Bodies are discs of `radius_m` about [`RobotMoment::place`]; gaps
//! are measured from surface to surface, in metres. A robot whose place nobody knows takes no part.

mod coverage;
mod index;
mod links;

pub use coverage::{COVERAGE_CELL_M, Coverage};
pub use index::{FAR_M, PlaceIndex};
pub use links::{Connectivity, connectivity, hearing};

use crate::{Moment, RobotMoment, Setting};
use std::collections::BTreeMap;

/// A robot slower than this does not count as moving, m/s: its direction would be noise.
pub const MOVING_MPS: f64 = 0.02;

/// Smallest gaps, surface to surface, metres; below 0 two things overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// To another body; `None`: there is no other body whose place is known.
    pub robot_m: Option<f64>,
    /// To a wall, an obstacle or a mover; `None`: there is none within [`FAR_M`].
    pub wall_m: Option<f64>,
}

impl Gaps {
    fn take_in(&mut self, other: Gaps) {
        self.robot_m = smaller(self.robot_m, other.robot_m);
        self.wall_m = smaller(self.wall_m, other.wall_m);
    }
}

fn smaller(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}

/// The smallest gap of each robot, in the moment's order. `index` is the index of `setting.place`.
///
/// Every pair of bodies is looked at: 100 robots are 5,000 pairs, which costs less than finding neighbours would.
#[must_use]
pub fn gaps_per_robot(setting: &Setting, index: &PlaceIndex, moment: &Moment) -> Vec<Gaps> {
    let radii: BTreeMap<u32, f64> = setting.robots.iter().map(|robot| (robot.id, robot.radius_m)).collect();
    let discs: Vec<Option<[f64; 3]>> = moment.robots.iter().map(|robot| disc(&radii, robot)).collect();
    let radii_m = setting.place.movers.iter().map(|mover| mover.radius_m);
    let movers: Vec<[f64; 3]> = moment.movers_m.iter().zip(radii_m).map(|([x, y], r)| [*x, *y, r]).collect();
    let wall_m = |disc: &Option<[f64; 3]>| smaller(wall_gap(index, *disc), mover_gap(&movers, *disc));
    let mut gaps: Vec<Gaps> = discs.iter().map(|disc| Gaps { robot_m: None, wall_m: wall_m(disc) }).collect();
    for one in 0..discs.len() {
        let Some([x, y, r]) = discs[one] else { continue };
        for other in one + 1..discs.len() {
            let Some([other_x, other_y, other_r]) = discs[other] else { continue };
            let gap = Some((x - other_x).hypot(y - other_y) - r - other_r);
            gaps[one].robot_m = smaller(gaps[one].robot_m, gap);
            gaps[other].robot_m = smaller(gaps[other].robot_m, gap);
        }
    }
    gaps
}

/// The smallest gaps of the whole swarm now. `index` is the index of `setting.place`.
#[must_use]
pub fn gaps(setting: &Setting, index: &PlaceIndex, moment: &Moment) -> Gaps {
    let mut all = Gaps::default();
    gaps_per_robot(setting, index, moment).into_iter().for_each(|gaps| all.take_in(gaps));
    all
}

fn disc(radii: &BTreeMap<u32, f64>, robot: &RobotMoment) -> Option<[f64; 3]> {
    let place = robot.place()?;
    let disc = [place.x_m, place.y_m, radii.get(&robot.id).copied().unwrap_or(0.0)];
    disc.iter().all(|value| value.is_finite()).then_some(disc)
}

fn wall_gap(index: &PlaceIndex, disc: Option<[f64; 3]>) -> Option<f64> {
    let [x, y, radius_m] = disc?;
    index.wall_distance([x, y]).map(|distance_m| distance_m - radius_m)
}

fn mover_gap(movers: &[[f64; 3]], disc: Option<[f64; 3]>) -> Option<f64> {
    let [x, y, radius_m] = disc?;
    let gaps_m = movers.iter().map(|[at_x, at_y, r]| (x - at_x).hypot(y - at_y) - r - radius_m);
    gaps_m.filter(|gap_m| gap_m.is_finite() && gap_m + radius_m <= FAR_M).min_by(f64::total_cmp)
}

/// Signed speed of a robot along its heading, m/s: by the simulator's truth, in the field by its own odometry.
#[must_use]
pub fn speed_mps(robot: &RobotMoment) -> f64 {
    robot.truth.as_ref().map_or(robot.twist_b[0], |truth| truth.twist_b[0])
}

/// How much the robots that move move in one direction: `|1/N sum v_i/|v_i||` over robots faster than [`MOVING_MPS`],
/// 0 (all ways) to 1 (one way). `None` while nobody moves.
///
/// The order parameter of Vicsek et al., Phys. Rev. Lett. 75, 1226 (1995).
#[must_use]
pub fn velocity_order(moment: &Moment) -> Option<f64> {
    let mut sum = [0.0, 0.0];
    let mut moving = 0_u32;
    for robot in &moment.robots {
        let (Some(place), speed_mps) = (robot.place(), speed_mps(robot)) else { continue };
        let direction = [place.yaw_rad.cos() * speed_mps.signum(), place.yaw_rad.sin() * speed_mps.signum()];
        if speed_mps.abs() > MOVING_MPS && speed_mps.is_finite() && direction[0].is_finite() {
            sum = [sum[0] + direction[0], sum[1] + direction[1]];
            moving += 1;
        }
    }
    (moving > 0).then(|| sum[0].hypot(sum[1]) / f64::from(moving))
}

#[cfg(test)]
#[path = "measure_tests.rs"]
mod tests;
