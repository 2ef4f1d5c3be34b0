//! The result in words.

use super::cost::ExploreCostRow;
use super::{ExploreContender, ExploreCourse, ExploreKilled, ExploreResult, ExploreScene, ExploreTable, ExploreTeam};
use crate::contest::table::{mean, short, worst};
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
        writeln!(f, "bench explore: {}", self.conditions)?;
        if !self.scenes.is_empty() {
            writeln!(f, "\nseeds {first}..{end}")?;
            self.scenes.iter().try_for_each(|scene| write!(f, "\n{scene}"))?;
            f.write_str(NOTES)?;
        }
        killed(f, &self.killed)?;
        teams(f, &self.teams, "team sizes")?;
        teams(f, &self.large, "larger places, as dense")?;
        courses(f, &self.courses)?;
        concentrations(f, &self.courses)?;
        if self.cost.is_empty() {
            return Ok(());
        }
        writeln!(f, "\na decision and the way there, on one thread, microseconds:")?;
        writeln!(f, "{:<26} {:>6} {:>7} {:>10} {:>9} {:>9}", "row", "cells", "robots", "decisions", "p50", "p99")?;
        self.cost.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

fn killed(f: &mut fmt::Formatter<'_>, table: &ExploreTable<ExploreKilled>) -> fmt::Result {
    let ([first, end], Some(_)) = (table.seeds, table.lines.first()) else { return Ok(()) };
    writeln!(f, "\none robot is killed when half is known, seeds {first}..{end}; done: the rest can reach no more:")?;
    write!(f, "{:<16} {:<16} {:>9} {:>20} {:>20}", "scene", "row", "done", "to 96 %", "end")?;
    writeln!(f, " {:>9} {:>9}", "known", "least")?;
    let mut all = [0, 0];
    for ExploreKilled { scene, row, done, steps_96, steps_finish, coverage, runs } in &table.lines {
        all = [all[0] + done, all[1] + runs.len()];
        write!(f, "{scene:<16} {row:<16} {:>9}", format!("{done} of {}", runs.len()))?;
        write!(f, " {:>20}", interval(steps_96.as_ref(), 1.0, 0))?;
        write!(f, " {:>20}", interval(steps_finish.as_ref(), 1.0, 0))?;
        writeln!(f, " {:>9} {:>9}", short(mean(coverage), 4), short(worst(coverage), 4))?;
    }
    writeln!(f, "all together: {} of {}", all[0], all[1])
}

fn teams(f: &mut fmt::Formatter<'_>, table: &ExploreTable<ExploreTeam>, title: &str) -> fmt::Result {
    let ([first, end], Some(line)) = (table.seeds, table.lines.first()) else { return Ok(()) };
    writeln!(f, "\n{title}, seeds {first}..{end}: steps to 96 % / to the end, and half of the 95 % intervals:")?;
    write!(f, "{:<16} {:>9} {:>6}", "scene", "place", "robots")?;
    line.rows.iter().try_for_each(|row| write!(f, " {:>25}", row.row))?;
    writeln!(f)?;
    for ExploreTeam { scene, side_cells, robots, rows } in &table.lines {
        write!(f, "{scene:<16} {:>9} {robots:>6}", format!("{side_cells} cells"))?;
        for row in rows {
            let cell = format!("{} / {}", half(row.steps_96.as_ref()), half(row.steps_finish.as_ref()));
            let left = row.runs.len() - row.done;
            write!(f, " {:>25}", if left > 0 { format!("{cell} ({left} not)") } else { cell })?;
        }
        writeln!(f)?;
    }
    Ok(())
}

fn courses(f: &mut fmt::Formatter<'_>, table: &ExploreTable<ExploreCourse>) -> fmt::Result {
    let ([first, end], Some(_)) = (table.seeds, table.lines.first()) else { return Ok(()) };
    writeln!(f, "\nfigure 4, the paper's method to 96 %, windows of 15 steps, seeds {first}..{end}: growth and obex")?;
    let columns = ["correlation", "at 4 peaks over all", "over windows beside"].map(|title| format!("{title:>22}"));
    writeln!(f, "{:<16} {}", "scene", columns.join(" "))?;
    for line in &table.lines {
        let numbers = [&line.correlation, &line.peaks_over_all, &line.peaks_over_beside];
        let numbers = numbers.map(|spread| format!("{:>22}", interval(spread.as_ref(), 1.0, 2)));
        writeln!(f, "{:<16} {}", line.scene, numbers.join(" "))?;
    }
    Ok(())
}

fn concentrations(f: &mut fmt::Formatter<'_>, table: &ExploreTable<ExploreCourse>) -> fmt::Result {
    if table.lines.is_empty() {
        return Ok(());
    }
    writeln!(f, "\nfigure 5, mean concentration of the first robot's antibodies in those runs, after generations:")?;
    let shown = [1, 2, 5, 10, 20, 40];
    let titles = shown.map(|generation| format!("{generation:>6}"));
    writeln!(f, "{:<16} {:<28} {}", "scene", "network", titles.join(" "))?;
    for ExploreCourse { scene, concentrations, .. } in &table.lines {
        for row in concentrations {
            let numbers = shown.map(|generation| format!("{:>6}", short(row.mean.get(generation).copied(), 3)));
            writeln!(f, "{scene:<16} {:<28} {}", row.row, numbers.join(" "))?;
        }
    }
    Ok(())
}

/// Mean and half of the interval; `-` if there are none.
fn half(spread: Option<&Spread>) -> String {
    let Some(spread) = spread else { return "-".into() };
    let half = spread.ci95_high.map(|high| format!(" ±{:.0}", high - spread.mean));
    format!("{:.0}{}", spread.mean, half.unwrap_or_default())
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

/// Mean and interval; a single run has none.
fn interval(spread: Option<&Spread>, scale: f64, digits: usize) -> String {
    let Some(spread) = spread else { return "-".into() };
    let shown = |value: f64| format!("{:.digits$}", value * scale);
    let ends = spread.ci95_low.zip(spread.ci95_high);
    let ends = ends.map(|(low, high)| format!(" [{}, {}]", shown(low), shown(high)));
    format!("{}{}", shown(spread.mean), ends.unwrap_or_default())
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
