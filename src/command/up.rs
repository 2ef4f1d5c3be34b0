//! `drover up SWARM.toml`: a whole swarm against the simulator.

use crate::command::{asked_to_end, overrides, refuse};
use crate::exit::Exit;
use crate::onlook::{View, ViewArguments};
use crate::view::{LiveView, print_summary};
use drover_config::{Override, Swarm, load_swarm};
use drover_swarm::{RESTARTED, STOPPED, Summary, UpOptions, up};
use std::path::PathBuf;

/// Arguments of `drover up`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The swarm's file
    file: PathBuf,
    /// Print the summary as one JSON document on stdout; everything else goes to stderr
    #[arg(long)]
    json: bool,
    /// End after this long, s, if not everything was reached before
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// Seed of everything random in the simulation
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Set any configuration key, for example behaviour.leader_speed_mps=0.5 or robot[2].start.x_m=1.5
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Every robot is a `drover run` process of its own, as in the field
    #[arg(long)]
    processes: bool,
    /// Record nothing
    #[arg(long)]
    no_record: bool,
    /// Serve no live page
    #[arg(long, conflicts_with = "view")]
    no_view: bool,
    #[command(flatten)]
    view: ViewArguments,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let swarm = match read(arguments) {
        Ok(swarm) => swarm,
        Err(exit) => return exit,
    };
    match run(&swarm, arguments) {
        Ok(summary) => {
            if arguments.json {
                // Only strings and finite numbers: this cannot fail to print.
                println!("{}", serde_json::to_string_pretty(&summary).unwrap_or_default());
            } else {
                print_summary(&summary);
            }
            conclude(&summary)
        }
        Err(error) => {
            eprintln!("{error:#}\nnothing was started");
            Exit::CannotStart
        }
    }
}

fn read(arguments: &Arguments) -> Result<Swarm, Exit> {
    let mut set = overrides(&arguments.set)?;
    // The two flags are short for keys, so that a bad value is refused in the same words.
    let flags = [
        arguments.duration.map(|duration_s| format!("duration_s={duration_s:?}")),
        arguments.seed.map(|seed| format!("seed={seed}")),
    ];
    let flags: Vec<String> = flags.into_iter().flatten().collect();
    let flags: Vec<Override> = overrides(&flags)?;
    set.extend(flags);
    load_swarm(&arguments.file, &set).map_err(|problems| refuse(&problems))
}

fn run(swarm: &Swarm, arguments: &Arguments) -> anyhow::Result<Summary> {
    let processes = if arguments.processes { Some(std::env::current_exe()?) } else { None };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    runtime.block_on(async {
        let mut view = View::start(&arguments.view, !arguments.no_view).await?;
        view.announce();
        loop {
            let mut live = LiveView::new(swarm);
            let options = UpOptions {
                processes: processes.clone(),
                record: !arguments.no_record,
                on_view: |time_s, tallies: &[_]| live.show(time_s, tallies),
                onlooker: Some(&mut view),
            };
            let summary = up(swarm, options, asked_to_end()).await;
            live.end();
            let summary = summary?;
            if summary.ended != RESTARTED {
                return Ok(summary);
            }
            eprintln!("begun anew from the live view");
        }
    })
}

fn conclude(summary: &Summary) -> Exit {
    let contact = [summary.min_gap_robot_m, summary.min_gap_wall_m].into_iter().flatten().any(|gap_m| gap_m <= 0.0);
    if contact || summary.aged_commands > 0 || !summary.stopped {
        Exit::Unsafe
    } else if summary.ended == "interrupted" || summary.ended == STOPPED {
        Exit::Interrupted
    } else if summary.reached {
        Exit::Reached
    } else {
        Exit::NotReached
    }
}
