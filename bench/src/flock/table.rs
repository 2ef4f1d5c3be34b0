//! The result in words, for a terminal of 160 columns.

use super::cost::FlockCostRow;
use super::runs::FlockRefusal;
use super::{FlockContender, FlockResult, FlockScene};
use crate::contest::table::{mean, median, share, short, worst};
use std::fmt;

/// A table is as wide as this.
const COLUMNS: usize = 160;
/// What the columns mean.
const NOTES: &str = "
success: share of runs in which nobody is lost, with its 95 % interval (Wilson); Python: the same of a Python prototype,
other scenes and starts (opening 300 mm and depth 200 mm alike, starts and the leader's way not); lost: robots a run;
order, cohesion: at the end, means; gaps: the least of all runs, m, between bodies and of bodies and walls; touch: runs
in which somebody touches something; gathered: median of successes, path: driven over shortest way, mean of successes;
stuck, gives way: the longest of all runs; entries: how often robots begin to follow a wall, mean of runs.
The same seeds, so places and starts, for all rows.
";

impl fmt::Display for FlockResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, end] = self.seeds;
        writeln!(f, "bench flock: seeds {first}..{end}; {}", self.conditions)?;
        self.scenes.iter().try_for_each(|scene| write!(f, "\n{scene}"))?;
        f.write_str(NOTES)?;
        if self.cost.is_empty() {
            return Ok(());
        }
        writeln!(f, "\ncost of a decision on one thread, what ships in the open, everybody hears everybody:")?;
        let title = "neighbours within 2 L   us/robot-tick   x real time   with the world";
        writeln!(f, "{:>9}   {title}", "followers")?;
        self.cost.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

impl fmt::Display for FlockScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, robots, duration_s, rows } = self;
        let runs = rows.first().map_or(0, |row| row.runs.len() + row.refused.len());
        writeln!(f, "{scene}: {robots} robots, {runs} runs a row, at most {duration_s:.0} s")?;
        write!(f, "{:<34} {:<17} {:>6} {:>5} {:>5}", "row", "success", "Python", "lost", "order")?;
        write!(f, " {:>10} {:>7} {:>7} {:>5}", "cohesion m", "robot m", "wall m", "touch")?;
        write!(f, " {:>10} {:>5} {:>7}", "gathered s", "path", "stuck s")?;
        writeln!(f, " {:>11} {:>7}", "gives way s", "entries")?;
        rows.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

impl fmt::Display for FlockContender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let (true, Some(refusal)) = (self.runs.is_empty(), self.refused.first()) {
            return f.write_str(&shortened(format!("{:<34} refused: {}", self.row, refusal.reason)));
        }
        let all = &self.summary;
        write!(f, "{:<34} {:<17}", self.row, share(all.success.as_ref()))?;
        write!(f, " {:>6} {:>5}", short(self.prototype, 2), short(mean(&all.lost), 2))?;
        write!(f, " {:>5} {:>10}", short(mean(&all.order), 2), short(mean(&all.cohesion_m), 3))?;
        write!(f, " {:>7} {:>7}", short(worst(&all.min_gap_robot_m), 4), short(worst(&all.min_gap_wall_m), 4))?;
        write!(f, " {:>5} {:>10}", short(mean(&all.touched), 2), short(median(&all.gathered_s), 1))?;
        write!(f, " {:>5} {:>7}", short(mean(&all.path_ratio), 2), short(worst(&all.stuck_s), 1))?;
        write!(f, " {:>11} {:>7}", short(worst(&all.gave_way_s), 1), short(mean(&all.wall_entries), 1))?;
        let Some(FlockRefusal { seed, reason }) = self.refused.first() else { return Ok(()) };
        let (some, of) = (self.refused.len(), self.refused.len() + self.runs.len());
        let words = format!("    refused with {some} of {of} seeds, as with {seed}: {reason}");
        write!(f, "\n{}", shortened(words))
    }
}

/// As much of a line as fits; the document of `--json` has all of it.
fn shortened(line: String) -> String {
    if line.chars().count() <= COLUMNS { line } else { line.chars().take(COLUMNS - 3).chain("...".chars()).collect() }
}

impl fmt::Display for FlockCostRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { followers, neighbours, tick_us, real_time, real_time_world } = self;
        write!(f, "{followers:>9}   {neighbours:>21.1}   {tick_us:>13.2}   {real_time:>11.1}   {real_time_world:>14.1}")
    }
}
