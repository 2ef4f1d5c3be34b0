//! The paper's figure 4: what is known, how fast that grows, and how many targets another robot had seen first, while
//! four robots explore; and whether those come together, as the paper reads it. The populations of figure 5 are those
//! of the same runs.

use super::concentration::{ExploreConcentration, concentrations};
use super::rows::{INEA, row_named};
use super::runs::{Case, STEPS_MAX};
use crate::contest::Plan;
use drover_config::{Explore, ExploreMethod};
use drover_swarm::{Spread, Worst};
use serde::Serialize;

/// Steps of a window: the paper's ST.
const WINDOW_STEPS: u32 = 15;
/// Growth is looked at until so much is known: the paper's run ends there.
const EXPLORED: f64 = 0.96;
/// The paper looks at so many peaks.
const PEAKS: usize = 4;

/// Steps that are looked at together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExploreWindow {
    /// Steps since the start, at its end.
    pub steps: u32,
    /// The share of what can be reached that is known then.
    pub coverage: f64,
    /// By how much that has grown.
    pub growth: f64,
    /// The share of the targets chosen in it that another robot had seen first; 0 if none was chosen.
    pub obex: f64,
}

/// The paper's method on a scene.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreCourse {
    /// The scene's file, without its ending.
    pub scene: String,
    /// The run of the first seed, until 96 % is known.
    pub windows: Vec<ExploreWindow>,
    /// Correlation (Pearson) of growth and obex over the windows of a run, of all seeds.
    pub correlation: Option<Spread>,
    /// Mean growth in the four windows of the greatest obex over that of all windows of the run, of all seeds.
    pub peaks_over_all: Option<Spread>,
    /// The same over that of the windows before and after those, since growth falls off with time.
    pub peaks_over_beside: Option<Spread>,
    /// Networks on the first robot's antibodies at the end of each window of all seeds.
    pub concentrations: Vec<ExploreConcentration>,
}

/// What is noted of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    windows: Vec<ExploreWindow>,
    populations: Vec<Vec<[f64; 2]>>,
}

pub(super) fn cases(plan: &Plan) -> Vec<Case<'_>> {
    plan.scenes.iter().filter_map(|scene| Some(Case::of(scene, row_named(INEA)?))).collect()
}

/// One run, window by window.
pub(super) fn run(case: &Case<'_>, seed: u64) -> anyhow::Result<Course> {
    let mut trial = case.begin(seed)?;
    let network = Explore::usual(ExploreMethod::Inea);
    let mut course = Course::default();
    let (mut known, mut targets) = (trial.coverage(), trial.targets());
    while trial.rounds() < STEPS_MAX && known < EXPLORED {
        let end = trial.rounds() + WINDOW_STEPS;
        let mut left = true;
        while left && trial.rounds() < end {
            left = trial.round();
        }
        let [chosen, foreign] = [0, 1].map(|at| trial.targets()[at] - targets[at]);
        let coverage = trial.coverage();
        let obex = foreign as f64 / chosen.max(1) as f64;
        course.windows.push(ExploreWindow { steps: trial.rounds(), coverage, growth: coverage - known, obex });
        (known, targets) = (coverage, trial.targets());
        if !left {
            break;
        }
        course.populations.push(trial.population(&network, 0));
    }
    Ok(course)
}

pub(super) fn line(case: &Case<'_>, runs: Vec<Course>) -> ExploreCourse {
    let numbers = |of: fn(&[ExploreWindow]) -> Option<f64>| {
        Spread::of_numbers(runs.iter().filter_map(|run| of(&run.windows)), Worst::Smallest)
    };
    ExploreCourse {
        scene: case.scene.name(),
        correlation: numbers(correlation),
        peaks_over_all: numbers(peaks_over_all),
        peaks_over_beside: numbers(peaks_over_beside),
        concentrations: concentrations(runs.iter().flat_map(|run| &run.populations)),
        windows: runs.into_iter().next().unwrap_or_default().windows,
    }
}

fn correlation(run: &[ExploreWindow]) -> Option<f64> {
    let growth = mean(run.iter().map(|one| one.growth))?;
    let obex = mean(run.iter().map(|one| one.obex))?;
    let sum = |of: &dyn Fn(&ExploreWindow) -> f64| run.iter().map(of).sum::<f64>();
    let both = sum(&|one| (one.growth - growth) * (one.obex - obex));
    let each = sum(&|one| (one.growth - growth).powi(2)) * sum(&|one| (one.obex - obex).powi(2));
    (each > 0.0).then(|| both / each.sqrt())
}

/// The windows of the greatest obex, the first of equals; none where no target was another's.
fn peaks(run: &[ExploreWindow]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..run.len()).filter(|at| run[*at].obex > 0.0).collect();
    order.sort_by(|a, b| run[*b].obex.total_cmp(&run[*a].obex));
    order.truncate(PEAKS);
    order
}

fn peaks_over_all(run: &[ExploreWindow]) -> Option<f64> {
    let at_peaks = mean(peaks(run).into_iter().map(|at| run[at].growth))?;
    Some(at_peaks / mean(run.iter().map(|one| one.growth))?)
}

fn peaks_over_beside(run: &[ExploreWindow]) -> Option<f64> {
    let at_peaks = mean(peaks(run).into_iter().map(|at| run[at].growth))?;
    let beside = peaks(run).into_iter().flat_map(|at| [at.checked_sub(1), Some(at + 1)]).flatten();
    let beside = mean(beside.filter_map(|at| run.get(at)).map(|one| one.growth))?;
    (beside > 0.0).then(|| at_peaks / beside)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(windows: &[(f64, f64)]) -> Vec<ExploreWindow> {
        let window =
            |(growth, obex): &(f64, f64)| ExploreWindow { steps: 0, coverage: 0.0, growth: *growth, obex: *obex };
        windows.iter().map(window).collect()
    }

    #[test]
    fn peaks_are_held_against_the_run_and_against_what_is_beside_them() {
        let run = run(&[(4.0, 0.0), (2.0, 0.5), (0.0, 0.0), (2.0, 0.0)]);
        assert_eq!(peaks(&run), [1]);
        assert!((peaks_over_all(&run).unwrap() - 1.0).abs() < 1e-12);
        assert!((peaks_over_beside(&run).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn growth_that_goes_with_obex_correlates_and_without_others_targets_there_is_nothing_to_say() {
        assert!((correlation(&run(&[(1.0, 0.1), (2.0, 0.2), (3.0, 0.3)])).unwrap() - 1.0).abs() < 1e-12);
        assert!((correlation(&run(&[(3.0, 0.1), (1.0, 0.3)])).unwrap() + 1.0).abs() < 1e-12);
        let alone = run(&[(1.0, 0.0), (2.0, 0.0)]);
        assert_eq!((correlation(&alone), peaks_over_all(&alone), peaks_over_beside(&alone)), (None, None, None));
    }
}
