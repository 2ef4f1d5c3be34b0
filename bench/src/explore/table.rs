//! The result in words.

use super::cost::ExploreCostRow;
use super::{ExploreContender, ExploreResult, ExploreScene};
use crate::contest::table::{mean, short};
use drover_swarm::Spread;
use std::fmt;

/// What the columns mean.
const NOTES: &str = "
Means of all runs that came so far. to 96 %: steps until so much of the free cells that can be reached is known, with
the 95 % interval (Student); prototype: the same, measured elsewhere on worlds of other generators; v first: paired
with the first row by seed; end: nothing can be reached that is unknown; finished: share of the runs that came to that
end; overlap: views by a second robot; obex: targets that another robot had seen first. The same seeds, so places and
starts, for all.
";

impl fmt::Display for ExploreResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, end] = self.seeds;
        writeln!(f, "bench explore: seeds {first}..{end}; {}", self.conditions)?;
        self.scenes.iter().try_for_each(|scene| write!(f, "\n{scene}"))?;
        f.write_str(NOTES)?;
        if self.cost.is_empty() {
            return Ok(());
        }
        writeln!(f, "\na decision and the way there, on one thread, microseconds:")?;
        writeln!(f, "{:<26} {:>6} {:>7} {:>10} {:>9} {:>9}", "row", "cells", "robots", "decisions", "p50", "p99")?;
        self.cost.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

impl fmt::Display for ExploreScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, robots, rows } = self;
        let runs = rows.first().map_or(0, |row| row.runs.len());
        writeln!(f, "{scene}: {robots} robots, {runs} runs a row")?;
        write!(f, "{:<26} {:>5} {:>18} {:>9} {:>5} {:>5}", "row", "90 %", "to 96 %", "prototype", "99 %", "end")?;
        writeln!(f, " {:>22} {:>8} {:>7} {:>5}", "v first", "finished", "overlap", "obex")?;
        rows.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

/// Mean and interval.
fn interval(spread: Option<&Spread>, scale: f64, digits: usize) -> String {
    let ends = spread.and_then(|spread| Some((spread.mean, spread.ci95_low?, spread.ci95_high?)));
    let shown = |value: f64| format!("{:.digits$}", value * scale);
    ends.map_or_else(|| "-".into(), |(mean, low, high)| format!("{} [{}, {}]", shown(mean), shown(low), shown(high)))
}

impl fmt::Display for ExploreContender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whole = |spread: &Option<Spread>| short(mean(spread), 0);
        let prototype = self.prototype.map_or_else(|| "-".into(), |steps| steps.to_string());
        write!(f, "{:<26} {:>5} {:>18}", self.row, whole(&self.steps_90), interval(self.steps_96.as_ref(), 1.0, 0))?;
        write!(f, " {prototype:>9} {:>5} {:>5}", whole(&self.steps_99), whole(&self.steps_finish))?;
        write!(f, " {:>20} %", interval(self.against_first.as_ref(), 100.0, 1))?;
        write!(f, " {:>8} {:>7}", short(mean(&self.finished), 2), short(mean(&self.overlap), 2))?;
        write!(f, " {:>5}", short(mean(&self.obex), 2))
    }
}

impl fmt::Display for ExploreCostRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { row, side_cells, robots, decisions, plan_us_p50, plan_us_p99 } = self;
        write!(f, "{row:<26} {side_cells:>6} {robots:>7} {decisions:>10} {plan_us_p50:>9.1} {plan_us_p99:>9.1}")
    }
}
