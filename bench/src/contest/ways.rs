//! Where the robots went: a paper's figures as they come out here.

use super::Scene;
use drover_config::Swarm;
use drover_contract::Pose;
use drover_swarm::{Fidelity, Trial, run_trial, trial_of};

/// The ways of one run.
#[derive(Clone, Debug)]
pub struct Ways {
    /// Stem of a file's name for it.
    pub name: String,
    /// The swarm as it ran; its name says the row as well.
    pub swarm: Swarm,
    /// Moments of it: when, s, and where everybody was, world frame, in the swarm's order.
    pub moments: Vec<(f64, Vec<Pose>)>,
    /// What of it a picture shows, from the south-west to the north-east corner, metres; none: all of it.
    pub view_m: Option<[[f64; 2]; 2]>,
}

impl Ways {
    /// Whether a picture shows this point.
    #[must_use]
    pub fn shows(&self, point_m: [f64; 2]) -> bool {
        let within = |[low, high]: [[f64; 2]; 2]| (0..2).all(|axis| (low[axis]..=high[axis]).contains(&point_m[axis]));
        self.view_m.is_none_or(within)
    }

    /// What a picture shows of `route_m`: it ends where it leaves the view.
    #[must_use]
    pub fn shown_of(&self, route_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let shown: Vec<[f64; 2]> = route_m.iter().copied().take_while(|point_m| self.shows(*point_m)).collect();
        let leg = shown.last().zip(route_m.get(shown.len())).zip(self.view_m);
        let edge_m = leg.map(|((from_m, to_m), view_m)| edge_m(*from_m, *to_m, view_m));
        shown.into_iter().chain(edge_m).collect()
    }
}

/// Where a leg that begins within `view_m` leaves it.
fn edge_m(from_m: [f64; 2], to_m: [f64; 2], [low, high]: [[f64; 2]; 2]) -> [f64; 2] {
    let way_m = [0, 1].map(|axis| to_m[axis] - from_m[axis]);
    let share = |axis: usize| {
        let edge = if way_m[axis] > 0.0 { high[axis] } else { low[axis] };
        if way_m[axis] == 0.0 { 1.0 } else { (edge - from_m[axis]) / way_m[axis] }
    };
    let share = share(0).min(share(1)).min(1.0);
    [0, 1].map(|axis| from_m[axis] + share * way_m[axis])
}

/// A figure of a paper: which run of what shows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figure<'a> {
    /// Its number in the paper.
    pub(crate) number: u32,
    /// What the table calls the row.
    pub(crate) row: &'a str,
    /// That row's overrides.
    pub(crate) set: &'a [&'a str],
    /// The run.
    pub(crate) seed: u64,
    /// Between two moments, s.
    pub(crate) every_s: f64,
}

/// Run `figure` on `scene`, and note where everybody goes.
pub(crate) fn record_ways(scene: &Scene, figure: &Figure<'_>) -> anyhow::Result<Ways> {
    let Figure { number, row, set, seed, every_s } = *figure;
    let mut swarm = scene.load(set, seed)?;
    let mut trial = trial_of(&swarm, Fidelity::Direct, None)?;
    let robots = swarm.robots.len();
    let seen = |trial: &dyn Trial| {
        let poses = (0..robots).map(|robot| trial.arena().state(robot).pose_wb);
        (trial.now().as_secs_f64(), poses.collect::<Vec<Pose>>())
    };
    let mut moments = vec![seen(trial.as_ref())];
    run_trial(&swarm, trial.as_mut(), &mut |trial: &dyn Trial| {
        let last_s = moments.last().map_or(0.0, |(time_s, _)| *time_s);
        if trial.now().as_secs_f64() - last_s >= every_s - 1e-9 {
            moments.push(seen(trial));
        }
        true
    });
    moments.push(seen(trial.as_ref()));
    swarm.name = format!("{}, {row}", swarm.name);
    let words: Vec<&str> = row.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    Ok(Ways { name: format!("figure{number}_{}_{}", scene.name(), words.join("_")), swarm, moments, view_m: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_route_ends_where_it_leaves_the_view() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms/flock_u.toml");
        let swarm = crate::contest::load(&file, []).unwrap();
        let view_m = Some([[0.0, -1.0], [2.0, 1.0]]);
        let ways = Ways { name: String::new(), swarm, moments: Vec::new(), view_m };
        let route_m = [[0.0, 0.0], [1.0, 0.0], [3.0, 1.0], [1.0, 0.0]];
        assert_eq!(ways.shown_of(&route_m), [[0.0, 0.0], [1.0, 0.0], [2.0, 0.5]]);
        assert_eq!(ways.shown_of(&route_m[..2]), route_m[..2]);
        assert!(ways.shown_of(&route_m[2..3]).is_empty() && !ways.shows([1.0, 1.1]));
        assert_eq!(Ways { view_m: None, ..ways }.shown_of(&route_m), route_m);
    }
}
