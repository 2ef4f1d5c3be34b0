//! Numbers of many runs in the cells of a table; `-` where there are none.

use drover_swarm::Spread;

/// A share with its interval.
pub(crate) fn share(spread: Option<&Spread>) -> String {
    let interval = |spread: &Spread| Some((spread.mean, spread.ci95_low?, spread.ci95_high?));
    match spread.and_then(interval) {
        Some((mean, low, high)) => format!("{mean:.2} [{low:.2}, {high:.2}]"),
        None => "-".into(),
    }
}

/// Median and quartiles in whole numbers.
pub(crate) fn quartiles(spread: Option<&Spread>) -> String {
    match spread {
        Some(Spread { median, q1, q3, .. }) => format!("{median:>5.0} ({q1:.0}..{q3:.0})"),
        None => "-".into(),
    }
}

/// A number with so many digits after the point.
pub(crate) fn short(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}

/// The mean of all runs.
pub(crate) fn mean(spread: &Option<Spread>) -> Option<f64> {
    spread.as_ref().map(|spread| spread.mean)
}

/// The median of all runs.
pub(crate) fn median(spread: &Option<Spread>) -> Option<f64> {
    spread.as_ref().map(|spread| spread.median)
}

/// The worst of all runs.
pub(crate) fn worst(spread: &Option<Spread>) -> Option<f64> {
    spread.as_ref().map(|spread| spread.worst)
}
