//! What a person sees of a swarm: a live table while it runs, a summary at the end. Both are text; programs read
//! `--json`.

use drover_config::Swarm;
use drover_robot::View;
use drover_swarm::{RobotSummary, Summary, Tally};
use std::io::{IsTerminal, Write};

/// A terminal is redrawn this often, seconds of the run; anything else gets a block of lines now and then.
const REDRAW_S: f64 = 0.2;
const BLOCK_S: f64 = 5.0;

/// The live table.
pub(crate) struct LiveView {
    ids: Vec<u32>,
    duration_s: f64,
    terminal: bool,
    drawn_lines: usize,
    next_s: f64,
}

impl LiveView {
    /// A table for `swarm`, nothing drawn yet.
    pub(crate) fn new(swarm: &Swarm) -> Self {
        let ids = swarm.robots.iter().map(|robot| robot.id).collect();
        let terminal = std::io::stderr().is_terminal();
        Self { ids, duration_s: swarm.duration_s, terminal, drawn_lines: 0, next_s: 0.0 }
    }

    /// Show the state of things, `time_s` into the run, if it is time to.
    pub(crate) fn show(&mut self, time_s: f64, tallies: &[Tally]) {
        if time_s < self.next_s {
            return;
        }
        self.next_s = time_s + if self.terminal { REDRAW_S } else { BLOCK_S };
        let mut lines = vec![self.progress_line(time_s, tallies), View::HEADER.to_owned()];
        lines.extend(self.ids.iter().zip(tallies).map(|(id, tally)| match &tally.view {
            Some(view) => view.to_string(),
            None => format!("{id:>6}  not heard yet"),
        }));
        self.draw(&lines);
    }

    /// Leave the last table standing.
    pub(crate) fn end(&mut self) {
        self.drawn_lines = 0;
    }

    fn progress_line(&self, time_s: f64, tallies: &[Tally]) -> String {
        const WIDTH: usize = 30;
        let views = tallies.iter().filter_map(|tally| tally.view.as_ref());
        let done: f64 = views.clone().map(|view| view.progress).sum::<f64>() / self.ids.len().max(1) as f64;
        let reached = views.filter(|view| view.reached).count();
        let filled = (done.clamp(0.0, 1.0) * WIDTH as f64).round() as usize;
        let bar = format!("{}{}", "#".repeat(filled), ".".repeat(WIDTH - filled));
        let robots = self.ids.len();
        format!(
            "[{bar}] {:3.0} %   {reached} of {robots} there   {time_s:.1} s of at most {:.0} s",
            done * 100.0,
            self.duration_s
        )
    }

    fn draw(&mut self, lines: &[String]) {
        let mut err = std::io::stderr().lock();
        let mut text = String::new();
        if self.terminal && self.drawn_lines > 0 {
            // Up to the first line of the table drawn before; each line is cleared to its end as it is redrawn.
            text.push_str(&format!("\x1b[{}A", self.drawn_lines));
        }
        let clear = if self.terminal { "\x1b[K" } else { "" };
        // A line that wraps would stand in two rows, and the next table would begin too low.
        let width = terminal_size::terminal_size_of(&err).map_or(usize::MAX, |(width, _)| usize::from(width.0));
        for line in lines {
            let fits: String = line.chars().take(width).collect();
            text.push_str(&format!("{fits}{clear}\n"));
        }
        // A terminal that went away is no reason to stop robots in a hurry.
        let _ = err.write_all(text.as_bytes());
        self.drawn_lines = lines.len();
    }
}

/// Print what happened.
pub(crate) fn print_summary(summary: &Summary) {
    let gap = |gap_m: Option<f64>| gap_m.map_or_else(|| "-".into(), |gap_m| format!("{gap_m:.2} m"));
    let verdict = if summary.reached { "reached" } else { "NOT reached" };
    println!("\n{}: {verdict} after {:.1} s: {}", summary.swarm, summary.time_s, summary.ended);
    println!(
        "smallest gap: robot to robot {}, robot to wall {}",
        gap(summary.min_gap_robot_m),
        gap(summary.min_gap_wall_m)
    );
    println!(
        "commands changed by supervisors: {}; aged commands: {}; every robot seen to stand at the end: {}",
        summary.commands_changed,
        summary.aged_commands,
        if summary.stopped { "yes" } else { "NO" }
    );
    println!("CAN: {} ({}); seed {}", summary.can, summary.can_detail, summary.seed);
    summary.robots.iter().for_each(print_robot);
    match &summary.recording {
        Some(folder) => println!("recording: {folder}"),
        None => println!("recording: none"),
    }
}

fn print_robot(robot: &RobotSummary) {
    let when = match (robot.reached, robot.reached_s) {
        (true, Some(reached_s)) => format!("reached after {reached_s:.1} s"),
        (true, None) => "reached".into(),
        (false, _) => format!("NOT reached, {:.2} m away", robot.end_distance_m.unwrap_or_default()),
    };
    let changed: u64 = robot.commands_changed.values().sum();
    println!(
        "  robot {} ({}): {when}; {} ({}); drove {:.1} m; supervisor changed {changed} of {} commands",
        robot.id, robot.kind, robot.state, robot.reason, robot.path_m, robot.ticks
    );
    for (reason, count) in &robot.commands_changed {
        println!("      {count} x {reason}");
    }
}
