//! `drover bench NAME`: measure, and print what is measured.

use crate::exit::Exit;
use anyhow::Context;
use drover_bench::{Conditions, LatencyResult, RecordResult, SimResult, bringup, convoy, latency, rays, record, sim};
use drover_config::{Links, Swarm, load_swarm};
use drover_picture::{Chart, Series};
use serde::Serialize;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Arguments of `drover bench`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// What to measure
    #[arg(value_enum)]
    name: Name,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
    /// A short run that shows the bench works; its figures claim nothing
    #[arg(long)]
    quick: bool,
    /// The swarm whose kinds and behaviour are used: config/swarms/first.toml, or ten.toml for record, unless given
    #[arg(long)]
    swarm: Option<PathBuf>,
    /// The MAVLink kind of that swarm to measure with
    #[arg(long, default_value = "rover_mavlink")]
    kind: String,
    /// Robots at most
    #[arg(long, default_value_t = 100)]
    robots: u32,
    /// Draw what is measured against a number of robots or of runs, as SVG and PNG, into this folder (sim, record)
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// First port of the virtual autopilots
    #[arg(long, default_value_t = 21_000)]
    port_base: u16,
}

/// The benches.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Name {
    /// Scan bytes in to command bytes out, one robot and many
    Latency,
    /// Many MAVLink robots from start to all driving
    Bringup,
    /// A lidar's scans, ours against parry's ray cast in the same places
    Rays,
    /// Robot-steps a second beside the peers' figures, cost against the number of robots, the wire in virtual time
    Sim,
    /// Processor time and size of a recording
    Record,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let usual = match arguments.name {
        Name::Record => "config/swarms/ten.toml",
        Name::Latency | Name::Bringup | Name::Rays | Name::Sim => "config/swarms/first.toml",
    };
    let template = match load_swarm(arguments.swarm.as_deref().unwrap_or(Path::new(usual)), &[]) {
        Ok(template) => template,
        Err(problems) => return crate::command::refuse(&problems),
    };
    let measured = match arguments.name {
        Name::Latency => measure_latency(arguments, &template).map(|result| show(&result, arguments.json)),
        Name::Bringup => measure_bringup(arguments, &template).map(|result| show(&result, arguments.json)),
        Name::Rays => {
            show(&rays(arguments.quick), arguments.json);
            Ok(())
        }
        Name::Record => measure_record(arguments, &template).and_then(|result| {
            show(&result, arguments.json);
            draw(arguments, "record", &record_chart(&result))
        }),
        Name::Sim => measure_sim(arguments, &template).and_then(|result| {
            show(&result, arguments.json);
            draw(arguments, "sim", &sim_chart(&result))
        }),
    };
    match measured {
        Ok(()) => Exit::Reached,
        Err(error) => {
            eprintln!("{error:#}");
            Exit::CannotStart
        }
    }
}

fn show<T: Serialize + Display>(result: &T, json: bool) {
    if json {
        // Only strings and numbers: this cannot fail to print.
        println!("{}", serde_json::to_string_pretty(result).unwrap_or_default());
    } else {
        println!("{result}");
    }
}

fn draw(arguments: &Arguments, name: &str, chart: &Chart) -> anyhow::Result<()> {
    let Some(folder) = &arguments.figures else { return Ok(()) };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    for (extension, bytes) in [("svg", chart.svg()?.into_bytes()), ("png", chart.png()?)] {
        let path = folder.join(name).with_extension(extension);
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        eprintln!("{}", path.display());
    }
    Ok(())
}

fn sim_chart(result: &SimResult) -> Chart {
    let points = result.flocks.iter().map(|row| [f64::from(row.robots), row.step_us]).collect();
    Chart {
        title: "Cost of a robot-step against the number of robots".into(),
        subtitle: format!("flocks of twenty, one thread; {}", result.conditions),
        x_label: "robots".into(),
        y_label: "microseconds a robot-step".into(),
        x_log: true,
        series: vec![Series { points, ..Series::default() }],
        ..Chart::default()
    }
}

fn record_chart(result: &RecordResult) -> Chart {
    let series = [("without recording", &result.cores_without), ("with recording", &result.cores_with)];
    let points =
        |cores: &[f64]| cores.iter().zip(1_u32..).map(|(cores, run)| [f64::from(run), cores * 100.0]).collect();
    Chart {
        title: "What a recording costs".into(),
        subtitle: format!("{} robots and their simulator; {}", result.robots, result.conditions),
        x_label: "run".into(),
        y_label: "% of a core".into(),
        y_least: Some([0.0, 1.0]),
        series: series
            .into_iter()
            .map(|(name, cores)| Series { name: name.into(), points: points(cores), ..Series::default() })
            .collect(),
        ..Chart::default()
    }
}

fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build()
}

fn measure_latency(arguments: &Arguments, template: &Swarm) -> anyhow::Result<LatencyResult> {
    let conditions = Conditions::now();
    let measure_s = if arguments.quick { 3.0 } else { 120.0 };
    let mut rows = Vec::new();
    for count in [1, arguments.robots] {
        let swarm = convoy(template, &arguments.kind, count, arguments.port_base)?;
        // A hundred robots give a hundred times the samples in the same time.
        let measure_s = if count > 1 { measure_s / 4.0 } else { measure_s };
        rows.push(runtime()?.block_on(latency(&swarm, 8.0, measure_s))?);
    }
    Ok(LatencyResult { conditions, rows })
}

fn measure_bringup(arguments: &Arguments, template: &Swarm) -> anyhow::Result<drover_bench::BringupResult> {
    let mut swarm = convoy(template, &arguments.kind, arguments.robots, arguments.port_base)?;
    swarm.duration_s = 120.0;
    let watch_s = if arguments.quick { 2.0 } else { 20.0 };
    runtime()?.block_on(bringup(&swarm, watch_s))
}

fn measure_record(arguments: &Arguments, template: &Swarm) -> anyhow::Result<RecordResult> {
    let ((pairs, watch_s), size_s) = if arguments.quick { ((1, 2.0), 20.0) } else { ((5, 20.0), 600.0) };
    let mut swarm = template.clone();
    for robot in &mut swarm.robots {
        if let Links::Mavlink { autopilot } = &mut robot.links {
            *autopilot = format!("udpout:127.0.0.1:{}", u32::from(arguments.port_base) + robot.id);
        }
    }
    runtime()?.block_on(record(&swarm, (pairs, watch_s), size_s))
}

fn measure_sim(arguments: &Arguments, template: &Swarm) -> anyhow::Result<SimResult> {
    let convoy = convoy(template, &arguments.kind, arguments.robots, arguments.port_base)?;
    sim(&convoy, arguments.quick)
}
