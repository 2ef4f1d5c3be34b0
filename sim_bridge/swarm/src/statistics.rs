//! What many runs say together.
//!
//! Quartiles are those of the sorted values with linear interpolation (Hyndman and Fan 1996, type 7). The 95 %
//! confidence interval is that of the mean: Student's t for numbers, Wilson's score (1927) for shares of truths. A
//! number that a run does not have (no wall, no peer) is left out; `n` says how many there are.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Two-sided 95 %.
const CONFIDENCE: f64 = 0.975;
/// The same of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// Which end of a number is bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worst {
    /// The smallest (a gap, a success).
    Smallest,
    /// The largest (a time, a loss).
    Largest,
}

/// One number of many runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Runs that have it.
    pub n: usize,
    /// Half of the runs are at or below it.
    pub median: f64,
    /// A quarter of the runs are at or below it.
    pub q1: f64,
    /// Three quarters of the runs are at or below it.
    pub q3: f64,
    /// The worst of all runs.
    pub worst: f64,
    /// The mean.
    pub mean: f64,
    /// 95 % confidence interval of the mean: lower end; none for a single run.
    pub ci95_low: Option<f64>,
    /// Upper end.
    pub ci95_high: Option<f64>,
}

impl Spread {
    /// Of numbers; `None` if there are none.
    #[must_use]
    pub fn of_numbers(values: impl IntoIterator<Item = f64>, worst: Worst) -> Option<Self> {
        let sorted = sorted(values)?;
        let (mean, half) = mean_and_half_width(&sorted);
        Some(Self {
            ci95_low: half.map(|half| mean - half),
            ci95_high: half.map(|half| mean + half),
            ..of(&sorted, worst)
        })
    }

    /// Of truths, as 1 and 0; `None` if there are none.
    #[must_use]
    pub fn of_truths(values: impl IntoIterator<Item = bool>, worst: Worst) -> Option<Self> {
        let sorted = sorted(values.into_iter().map(f64::from))?;
        let [low, high] = wilson(sorted.iter().sum(), sorted.len() as f64);
        Some(Self { ci95_low: Some(low), ci95_high: Some(high), ..of(&sorted, worst) })
    }
}

fn sorted(values: impl IntoIterator<Item = f64>) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then_some(values)
}

fn of(sorted: &[f64], worst: Worst) -> Spread {
    let quantile = |share: f64| {
        let at = share * (sorted.len() - 1) as f64;
        let (below, above) = (at.floor() as usize, at.ceil() as usize);
        sorted[below] + (sorted[above] - sorted[below]) * (at - at.floor())
    };
    Spread {
        n: sorted.len(),
        median: quantile(0.5),
        q1: quantile(0.25),
        q3: quantile(0.75),
        worst: quantile(if worst == Worst::Smallest { 0.0 } else { 1.0 }),
        mean: mean_and_half_width(sorted).0,
        ci95_low: None,
        ci95_high: None,
    }
}

fn mean_and_half_width(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
    // With fewer than two values there is no spread to speak of.
    let student = StudentsT::new(0.0, 1.0, n - 1.0).ok().filter(|_| values.len() > 1);
    (mean, student.map(|student| student.inverse_cdf(CONFIDENCE) * (variance / n).sqrt()))
}

fn wilson(successes: f64, n: f64) -> [f64; 2] {
    let share = successes / n;
    let centre = (share + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    [(centre - half).max(0.0), (centre + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-3 * b.abs().max(1.0)
    }

    #[test]
    fn numbers_are_summed_up_as_text_books_do() {
        // Student's own first sleep data (1908): mean 0.75, t(9) = 2.2622, s = 1.789.
        let sleep = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0];
        let spread = Spread::of_numbers(sleep, Worst::Smallest).unwrap();
        assert!(close(spread.mean, 0.75) && close(spread.median, 0.35) && close(spread.worst, -1.6), "{spread:?}");
        assert!(close(spread.q1, -0.175) && close(spread.q3, 1.7), "{spread:?}");
        assert!(close(spread.ci95_low.unwrap(), -0.5298) && close(spread.ci95_high.unwrap(), 2.0298), "{spread:?}");
    }

    #[test]
    fn one_run_has_no_interval_and_none_has_nothing() {
        let one = Spread::of_numbers([4.0], Worst::Largest).unwrap();
        assert_eq!((one.n, one.worst.to_bits(), one.ci95_low), (1, 4.0_f64.to_bits(), None));
        assert_eq!(Spread::of_numbers([], Worst::Largest), None);
    }

    #[test]
    fn truths_have_wilsons_interval() {
        // 8 of 10: the interval of the published tables is 0.4902 to 0.9433.
        let spread = Spread::of_truths((0..10).map(|n| n < 8), Worst::Smallest).unwrap();
        assert!(close(spread.ci95_low.unwrap(), 0.4902) && close(spread.ci95_high.unwrap(), 0.9433), "{spread:?}");
        let all = Spread::of_truths([true; 200], Worst::Smallest).unwrap();
        assert!(close(all.ci95_low.unwrap(), 0.9812) && close(all.worst, 1.0), "{all:?}");
    }
}
