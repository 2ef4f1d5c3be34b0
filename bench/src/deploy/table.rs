//! The result in words, for a terminal of 160 columns.

use super::cost::DeployCostRow;
use super::{DeployResult, DeployRow, DeployScene};
use crate::contest::table::{mean, median, quartiles, share, short, worst};
use std::fmt;

/// What the columns mean.
const NOTES: &str = "
Shares with their 95 % interval (Wilson). connected: one network at every moment; arrive: runs in which everybody does;
there: share of robots that do; time s: median and quartiles of all runs, one that does not arrive with all its time;
bound s: the longest straight way at full speed; gaps: the least of all runs, m, between points and of points and walls;
tunnel: runs in which somebody crosses a wall; guard: decisions that the last layer changed; lambda2: the least of all.
The same seeds, so places and starts, for all rows. Peers get the targets as the shipped configuration assigns them.
";

impl fmt::Display for DeployResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, end] = self.seeds;
        writeln!(f, "bench deploy: seeds {first}..{end}; {}", self.conditions)?;
        self.scenes.iter().try_for_each(|scene| write!(f, "\n{scene}"))?;
        f.write_str(NOTES)?;
        if self.cost.is_empty() {
            return Ok(());
        }
        writeln!(f, "\ncost of a round on one thread, squares in the open as in experiment 2, from start to arrival:")?;
        let title = "neighbours   us/robot-round   x real time   with the world   arrived after";
        writeln!(f, "{:>7}   {title}", "robots")?;
        self.cost.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

impl fmt::Display for DeployScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, robots, duration_s, rows } = self;
        let runs = rows.first().map_or(0, |row| row.runs.len());
        writeln!(f, "{scene}: {robots} robots, {runs} runs a row, at most {duration_s:.0} s")?;
        write!(f, "{:<29} {:<17} {:<17} {:>5} {:<17}", "row", "connected", "arrive", "there", "   time s")?;
        write!(f, " {:>7} {:>7} {:>6} {:>6}", "bound s", "robot m", "wall m", "tunnel")?;
        writeln!(f, " {:>6} {:>6} {:>7}", "path m", "guard", "lambda2")?;
        rows.iter().try_for_each(|row| writeln!(f, "{row}"))
    }
}

impl fmt::Display for DeployRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = &self.summary;
        let (connected, arrived) = (share(all.connected_always.as_ref()), share(all.all_arrived.as_ref()));
        let time = quartiles(all.time_s.as_ref());
        let there = short(mean(&all.arrived_fraction), 2);
        write!(f, "{:<29} {connected:<17} {arrived:<17} {there:>5} {time:<17}", self.row)?;
        write!(f, " {:>7} {:>7}", short(median(&all.bound_s), 0), short(worst(&all.min_gap_robot_m), 3))?;
        write!(f, " {:>6} {:>6}", short(worst(&all.min_gap_wall_m), 3), short(mean(&all.tunnelled), 2))?;
        write!(f, " {:>6} {:>6}", short(mean(&all.path_m_mean), 1), short(mean(&all.guard_changed_fraction), 3))?;
        write!(f, " {:>7}", short(worst(&all.lambda2_min), 4))
    }
}

impl fmt::Display for DeployCostRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robots, neighbours, round_us, real_time, real_time_world, arrived_s } = self;
        write!(f, "{robots:>7}   {neighbours:>10.1}   {round_us:>14.2}   {real_time:>11.0}   {real_time_world:>14.1}")?;
        write!(f, "   {:>11} s", short(*arrived_s, 0))
    }
}
