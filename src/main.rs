//! `drover`: the command line. Thin: it reads arguments, calls the crates and prints what they say.

mod command;
mod exit;
mod meter;
#[cfg(feature = "view")]
mod onlook;
#[cfg(feature = "sim")]
mod table;
#[cfg(feature = "sim")]
mod view;

use clap::{Parser, Subcommand};
use exit::Exit;
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;

/// Drives swarms of differential-drive robots.
#[derive(Parser)]
#[command(version, about, after_help = exit::HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bring up a whole swarm against the simulator, with a live view and a summary
    #[cfg(feature = "sim")]
    Up(command::up::Arguments),
    /// Run a swarm in virtual time, as fast as it goes: one run or a batch over seeds
    #[cfg(feature = "sim")]
    Sim(command::sim::Arguments),
    /// Show a recording in the live view, or check it against today's code
    #[cfg(feature = "view")]
    Replay(command::replay::Arguments),
    /// Draw pictures of a recorded run
    #[cfg(feature = "view")]
    Plot(command::plot::Arguments),
    /// Make one page of a recorded run: summary and pictures
    #[cfg(feature = "view")]
    Report(command::report::Arguments),
    /// Write what a recording holds in the formats of other tools: candump, tlog, CSV
    Export(command::export::Arguments),
    /// Drive one robot, on its own computer
    Run(command::run::Arguments),
    /// Say everything that is wrong in configuration files
    Check(command::check::Arguments),
    /// Stop running robots of a swarm, at once and for good
    Stop(command::stop::Arguments),
    /// Measure, and print what is measured
    #[cfg(feature = "sim")]
    Bench(command::bench::Arguments),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_env("DROVER_LOG").unwrap_or_else(|_| EnvFilter::new("warn"));
    // A thread of its own writes the log: a reader of stderr that sleeps must not hold up a robot's loop. What it
    // cannot keep up with is dropped; what is left is written when `_log` goes.
    let (stderr, _log) = tracing_appender::non_blocking(std::io::stderr());
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(stderr).init();
    let exit = match arguments.command {
        #[cfg(feature = "sim")]
        Command::Up(up) => command::up::execute(&up),
        #[cfg(feature = "sim")]
        Command::Sim(sim) => command::sim::execute(&sim),
        #[cfg(feature = "view")]
        Command::Replay(replay) => command::replay::execute(&replay),
        #[cfg(feature = "view")]
        Command::Plot(plot) => command::plot::execute(&plot),
        #[cfg(feature = "view")]
        Command::Report(report) => command::report::execute(&report),
        Command::Export(export) => command::export::execute(&export),
        Command::Run(run) => command::run::execute(&run),
        Command::Check(check) => command::check::execute(&check),
        Command::Stop(stop) => command::stop::execute(&stop),
        #[cfg(feature = "sim")]
        Command::Bench(bench) => command::bench::execute(&bench),
    };
    exit.into()
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}
