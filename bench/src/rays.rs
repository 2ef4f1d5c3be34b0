//! `drover bench rays`: casting a lidar's scans, ours against parry's own ray cast, in one process.
//!
//! Ours is [`Lidar::ranges`], a whole scan at a time; parry's is one ray after the other through its tree, with the
//! directions of the beams ready. Both take poses in f64 and give ranges in f64, of the same places, in rounds that
//! take turns: what disturbs the machine disturbs both. Every ray of every scan is then compared.

use crate::machine::Conditions;
use crate::ray_scenes::Scene;
use drover_config::Mount;
use drover_contract::math::sin_cos;
use drover_contract::{Pose, Vec2};
use drover_world::{Lidar, LidarParams};
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

const BEAMS: u32 = 360;
/// How far the lidar sees, metres.
const RANGE_M: f64 = 10.0;
/// Ranges that differ by more do not agree, metres.
const AGREE_M: f64 = 1e-3;
/// A beam that grazes an edge agrees with a ray turned by at most this, radians, to either side.
const HAIR_RAD: f64 = 1e-5;
/// Rays turned by that, and by three quarters of the angle again and again, are tried: near a disc's rim the range goes
/// by the square root of the angle.
const HAIRS: i32 = 32;

/// How much is measured.
#[derive(Clone, Copy)]
struct Extent {
    /// Scans of a round; rays of all of them are compared.
    scans: usize,
    /// Rounds of each side.
    rounds: usize,
    /// How often ours casts a round's scans: it would be over too soon to be timed.
    passes: usize,
}

/// One kind of place.
#[derive(Clone, Debug, Serialize)]
pub struct RaysRow {
    /// What is in it, and what parry casts on if that differs.
    pub place: String,
    /// Pieces of wall.
    pub segments: usize,
    /// Ours, millions of rays a second, median of the rounds.
    pub ours_mrays_per_s: f64,
    /// Parry's, likewise.
    pub parry_mrays_per_s: f64,
    /// How many times faster ours is: median of the rounds' ratios.
    pub ratio: f64,
    /// The smallest ratio of a round.
    pub ratio_min: f64,
    /// Rays that were compared.
    pub compared: usize,
    /// Of these, those that differ by more than 1 mm but agree with parry's ray turned by up to 1e-5 radians: they
    /// graze an edge.
    pub grazing: usize,
    /// Those that differ and do not agree with it either.
    pub unexplained: usize,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct RaysResult {
    /// Under which conditions.
    pub conditions: Conditions,
    /// Beams of a scan.
    pub beams: u32,
    /// How far a scan reaches, metres.
    pub range_m: f64,
    /// Scans a round.
    pub scans: usize,
    /// Rounds.
    pub rounds: usize,
    /// A row a kind of place.
    pub rows: Vec<RaysRow>,
}

/// Cast scans in places of all kinds. `quick`: so few that the figures claim nothing.
#[must_use]
pub fn rays(quick: bool) -> RaysResult {
    let conditions = Conditions::now();
    let full = Extent { scans: 1_000, rounds: 11, passes: 10 };
    let extent = if quick { Extent { scans: 20, rounds: 3, passes: 2 } } else { full };
    // With four walls around, 12 obstacles of four corners are 52 segments.
    let mut scenes: Vec<Scene> = [12, 124, 1_249].map(|count| Scene::obstacles(count, extent.scans)).into();
    scenes.push(Scene::swarm(124, 100));
    scenes.extend([false, true].map(|as_cells| Scene::map(500, extent.scans, as_cells)));
    let rows: Vec<RaysRow> = scenes.iter().map(|scene| Match::new(scene).row(extent)).collect();
    RaysResult { conditions, beams: BEAMS, range_m: RANGE_M, scans: extent.scans, rounds: extent.rounds, rows }
}

/// The two sides in one place.
struct Match<'a> {
    scene: &'a Scene,
    lidar: Lidar,
    /// Directions of the beams, sensor frame.
    directions: Vec<Vec2>,
    ours_m: Vec<f64>,
    parry_m: Vec<f64>,
}

impl<'a> Match<'a> {
    fn new(scene: &'a Scene) -> Self {
        let params = LidarParams {
            beams: BEAMS,
            fov_rad: TAU,
            mount: Mount::default(),
            range_m_min: 0.0,
            range_m_max: RANGE_M,
            range_noise_m: 0.0,
            range_step_m: 0.0,
            beam_dropout: 0.0,
            sweep: false,
        };
        let (first_rad, step_rad) = params.angles_rad();
        let direction = |beam: u32| {
            let (sin, cos) = sin_cos(first_rad + step_rad * f64::from(beam));
            Vec2::new(cos, sin)
        };
        let directions = (0..BEAMS).map(direction).collect();
        Self { scene, lidar: Lidar::new(params, 1, 1), directions, ours_m: Vec::new(), parry_m: Vec::new() }
    }

    fn row(mut self, extent: Extent) -> RaysRow {
        let poses_ws: Vec<Pose> = self.scene.poses_ws.iter().copied().cycle().take(extent.scans).collect();
        let [mut ours, mut parrys, mut ratios] = [Vec::new(), Vec::new(), Vec::new()];
        for round in 0..=extent.rounds {
            let ours_mrays_per_s = rate(&poses_ws, extent.passes, |index, pose_ws| self.cast_ours(index, pose_ws));
            let parry_mrays_per_s = rate(&poses_ws, 1, |index, pose_ws| self.cast_parrys(index, pose_ws));
            // The first round warms up.
            if round > 0 {
                ours.push(ours_mrays_per_s);
                parrys.push(parry_mrays_per_s);
                ratios.push(ours_mrays_per_s / parry_mrays_per_s);
            }
        }
        let (mut grazing, mut unexplained) = (0, 0);
        for (index, pose_ws) in poses_ws.iter().enumerate() {
            let (hairs, wrong) = self.compare(index, *pose_ws);
            grazing += hairs;
            unexplained += wrong;
        }
        RaysRow {
            place: self.scene.name.clone(),
            segments: self.scene.walls.segments().len(),
            ours_mrays_per_s: median(&mut ours),
            parry_mrays_per_s: median(&mut parrys),
            ratio: median(&mut ratios),
            ratio_min: ratios[0],
            compared: poses_ws.len() * self.directions.len(),
            grazing,
            unexplained,
        }
    }

    fn cast_ours(&mut self, index: usize, pose_ws: Pose) {
        self.ours_m.clear();
        self.ours_m.extend(self.lidar.ranges(pose_ws, &self.scene.seen_by(index)));
        black_box(&self.ours_m);
    }

    fn cast_parrys(&mut self, index: usize, pose_ws: Pose) {
        let (seen, origin_w, heading) = (self.scene.seen_by(index), pose_ws.position(), pose_ws.heading());
        self.parry_m.clear();
        self.parry_m.extend(self.directions.iter().map(|d| seen.parry_m(origin_w, turned(*d, heading), RANGE_M)));
        black_box(&self.parry_m);
    }

    /// How many beams of a scan graze an edge, and how many are not explained.
    fn compare(&mut self, index: usize, pose_ws: Pose) -> (usize, usize) {
        self.cast_ours(index, pose_ws);
        self.cast_parrys(index, pose_ws);
        let (seen, origin_w, heading) = (self.scene.seen_by(index), pose_ws.position(), pose_ws.heading());
        let agree = |ours_m: f64, parry_m: f64| (ours_m.min(RANGE_M) - parry_m.min(RANGE_M)).abs() <= AGREE_M;
        let (mut grazing, mut unexplained) = (0, 0);
        for ((ours_m, parry_m), direction) in self.ours_m.iter().zip(&self.parry_m).zip(&self.directions) {
            if agree(*ours_m, *parry_m) {
                continue;
            }
            let hairs = (0..HAIRS).map(|step| HAIR_RAD * 0.75_f64.powi(step));
            let explained = hairs.flat_map(|hair_rad| [hair_rad, -hair_rad]).any(|hair_rad| {
                let (sin, cos) = sin_cos(hair_rad);
                let direction_w = turned(turned(*direction, heading), Vec2::new(cos, sin));
                agree(*ours_m, seen.parry_m(origin_w, direction_w, RANGE_M))
            });
            grazing += usize::from(explained);
            unexplained += usize::from(!explained);
        }
        (grazing, unexplained)
    }
}

/// Millions of rays a second of `cast`, which casts one scan.
fn rate(poses_ws: &[Pose], passes: usize, mut cast: impl FnMut(usize, Pose)) -> f64 {
    let start = Instant::now();
    for _ in 0..passes {
        poses_ws.iter().enumerate().for_each(|(index, pose_ws)| cast(index, *pose_ws));
    }
    let rays = f64::from(BEAMS) * (passes * poses_ws.len()) as f64;
    rays / start.elapsed().as_secs_f64() / 1e6
}

/// `direction` turned by the angle of `heading`, both of length 1.
fn turned(direction: Vec2, heading: Vec2) -> Vec2 {
    let (d, h) = (direction, heading);
    Vec2::new(h.x * d.x - h.y * d.y, h.x * d.y + h.y * d.x)
}

/// Sorts, too.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

impl fmt::Display for RaysResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { beams, range_m, scans, rounds, .. } = self;
        writeln!(f, "rays: {beams}-beam scans of {range_m} m, ours against parry's, f64 in and out, one thread")?;
        writeln!(f, "{}; {rounds} rounds of {scans} scans each, in turns, medians", self.conditions)?;
        writeln!(f, "Mrays/s; compared: rays; grazing: agree with a ray turned by up to 1e-5 rad; wrong: do not")?;
        write!(f, "{:<28}  segments   ours  parry  ratio  (min)  compared  grazing  wrong", "place")?;
        self.rows.iter().try_for_each(|row| {
            write!(
                f,
                "\n{:<28}  {:>8}  {:>5.0}  {:>5.1}  {:>5.1}  {:>5.1}  {:>8}  {:>7}  {:>5}",
                row.place,
                row.segments,
                row.ours_mrays_per_s,
                row.parry_mrays_per_s,
                row.ratio,
                row.ratio_min,
                row.compared,
                row.grazing,
                row.unexplained
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_agrees_with_parrys_or_grazes_an_edge() {
        let result = rays(true);
        let segments: Vec<usize> = result.rows.iter().map(|row| row.segments).collect();
        assert_eq!(segments[..4], [52, 500, 5_000, 500]);
        for row in result.rows {
            assert_eq!(row.unexplained, 0, "{}", row.place);
            assert!(row.grazing * 1_000 < row.compared, "{} of {}: {}", row.grazing, row.compared, row.place);
        }
    }
}
