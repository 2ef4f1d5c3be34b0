//! Keys whose defaults depend on a mode: what ships, or a paper's method as printed ("literal").

use crate::reader::Table;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// How a default of two values is shown: one if they are equal.
fn shown(safe: &impl Display, paper: &impl Display) -> String {
    let (safe, paper) = (safe.to_string(), paper.to_string());
    if safe == paper { safe } else { format!("{safe} (literal: {paper})") }
}

/// One of `words`. Not given: the first, or if `literal` the one at `paper`.
pub(crate) fn among<T: Copy, const N: usize>(
    table: &mut Table<'_>,
    literal: bool,
    key: &'static str,
    words: [(&'static str, T); N],
    paper: usize,
) -> Option<T> {
    let names = words.map(|(word, _)| word);
    let shown = shown(&format!("{:?}", names[0]), &format!("{:?}", names[paper]));
    let default = if literal { paper } else { 0 };
    let index = table.derived_choice(key, &names, (default, &shown))?;
    words.get(index).map(|(_, value)| *value)
}

/// A number. Not given: the first of the two, or if `literal` the other one.
pub(crate) fn number(
    table: &mut Table<'_>,
    literal: bool,
    key: &'static str,
    range: RangeInclusive<f64>,
    (safe, paper): (f64, f64),
) -> Option<f64> {
    let number = table.derived_number(key, range, &shown(&safe, &paper))?;
    Some(number.unwrap_or(if literal { paper } else { safe }))
}

/// true or false. Not given: the first of the two, or if `literal` the other one.
pub(crate) fn truth(
    table: &mut Table<'_>,
    literal: bool,
    key: &'static str,
    (safe, paper): (bool, bool),
) -> Option<bool> {
    table.derived_bool(key, if literal { paper } else { safe }, &shown(&safe, &paper))
}
