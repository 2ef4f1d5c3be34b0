//! An axis: from where to where, and which values are named.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// A linear or logarithmic axis with named values.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    from: f64,
    to: f64,
    log: bool,
    ticks: Vec<(f64, String)>,
}

/// Least and greatest of what is finite.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold(None, |extent: Option<[f64; 2]>, value| {
        let [least, most] = extent.unwrap_or([value, value]);
        Some([least.min(value), most.max(value)])
    })
}

impl Axis {
    /// A linear axis over exactly this range, with about `count` named values.
    pub(crate) fn tight([from, to]: [f64; 2], count: usize) -> Self {
        let [from, to] = opened([from, to]);
        let step = step((to - from) / count.max(1) as f64);
        let first = (from / step - 1e-9).ceil();
        let last = (to / step + 1e-9).floor();
        let ticks = (0..=(last - first).clamp(0.0, 100.0) as usize).map(|tick| (first + tick as f64) * step);
        Self { from, to, log: false, ticks: ticks.map(|tick| (tick, words(tick, step))).collect() }
    }

    /// A linear axis over at least this range, ending at named values.
    pub(crate) fn wide(range: [f64; 2], count: usize) -> Self {
        let [from, to] = opened(range);
        let step = step((to - from) / count.max(1) as f64);
        Self::tight([(from / step + 1e-9).floor() * step, (to / step - 1e-9).ceil() * step], count)
    }

    /// A linear axis over at least this range that names whole numbers alone.
    pub(crate) fn whole(range: [f64; 2], count: usize) -> Self {
        let mut axis = Self::wide(range, count);
        axis.ticks.retain(|(value, _)| (value - value.round()).abs() < 1e-9);
        for (value, words) in &mut axis.ticks {
            *words = format!("{value:.0}");
        }
        axis
    }

    /// A logarithmic axis over at least this range; both ends above 0.
    pub(crate) fn log([from, to]: [f64; 2]) -> Self {
        let decades = (to / from).log10();
        let multiples: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let apart = (decades / 8.0).ceil().max(1.0) as i32;
        let exponents = (from.log10().floor() as i32..=to.log10().ceil() as i32).step_by(apart.unsigned_abs() as usize);
        let named: Vec<f64> =
            exponents.flat_map(|exponent| multiples.iter().map(move |by| by * 10_f64.powi(exponent))).collect();
        let below = named.iter().copied().rfind(|value| *value <= from * (1.0 + 1e-9));
        let above = named.iter().copied().find(|value| *value >= to * (1.0 - 1e-9));
        let (from, mut to) = (below.unwrap_or(from), above.unwrap_or(to));
        if to <= from {
            to = from * 10.0;
        }
        let ticks = named.into_iter().filter(|value| *value >= from * 0.999 && *value <= to * 1.001);
        Self { from, to, log: true, ticks: ticks.map(|tick| (tick, words(tick, tick))).collect() }
    }

    /// Rows with names, the first at the top; at most `count` of the names are written.
    pub(crate) fn rows(names: &[String], count: usize) -> Self {
        let apart = names.len().div_ceil(count.max(1)).max(1);
        let ticks = names.iter().enumerate().step_by(apart).map(|(row, name)| (-(row as f64), name.clone()));
        Self { from: 0.5 - names.len().max(1) as f64, to: 0.5, log: false, ticks: ticks.collect() }
    }

    /// Where a value lies between the ends, 0..=1 if it is between them.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let place = |value: f64| if self.log { value.log10() } else { value };
        (place(value) - place(self.from)) / (place(self.to) - place(self.from))
    }
}

/// A range that has a length, also around a single value.
fn opened([from, to]: [f64; 2]) -> [f64; 2] {
    let least = 1e-9 * from.abs().max(to.abs());
    if to - from > least {
        return [from, to];
    }
    let half = if from.abs() > 0.0 { from.abs() * 0.1 } else { 0.5 };
    [from - half, to + half]
}

/// The least of 1, 2, 5 times a power of ten that is not less.
fn step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let by = [1.0, 2.0, 5.0, 10.0].into_iter().find(|by| by * power >= least * (1.0 - 1e-9));
    by.unwrap_or(10.0) * power
}

/// A value in as many digits as its distance to the next one needs.
fn words(value: f64, step: f64) -> String {
    let value = if value.abs() < step.abs() * 1e-6 { 0.0 } else { value };
    if value.abs() >= 1e7 || (step.abs() < 1e-4 && value.abs() > 0.0) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let digits = (-step.abs().log10() - 1e-9).ceil().clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        // A value far outside must not become one of plotters' overflows.
        let share = self.share(*value).clamp(-10.0, 10.0);
        limit.0 + (f64::from(limit.1 - limit.0) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(value, _)| *value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let named =
            self.ticks.iter().min_by(|(one, _), (other, _)| (one - value).abs().total_cmp(&(other - value).abs()));
        named.map(|(_, words)| words.clone()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, words)| words.as_str()).collect()
    }

    #[test]
    fn round_values_are_named_and_nothing_is_named_minus_zero() {
        assert_eq!(named(&Axis::tight([-1.0, 1.0], 4)), ["-1.0", "-0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(named(&Axis::wide([0.1, 93.0], 5)), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(named(&Axis::log([0.3, 40.0])), ["0.2", "0.5", "1", "2", "5", "10", "20", "50"]);
        assert_eq!(named(&Axis::log([1.0, 1e6])), ["1", "10", "100", "1000", "10000", "100000", "1000000"]);
    }

    #[test]
    fn a_single_value_has_room_around_it() {
        for value in [0.0, 5.0, -1e12, 1e-12] {
            for axis in [Axis::tight([value, value], 5), Axis::wide([value, value], 5)] {
                let share = axis.share(value);
                assert!((0.0..=1.0).contains(&share) && !axis.ticks.is_empty(), "{value}: {axis:?}");
            }
        }
        assert!(Axis::log([7.0, 7.0]).share(7.0).is_finite());
    }
}
