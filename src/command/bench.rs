//! `drover bench NAME`: measure, and print what is measured.

mod explore_charts;

use crate::exit::Exit;
use crate::meter;
use anyhow::Context;
use drover_bench::{
    Conditions, DeployPlan, DeployResult, ExplorePart, ExplorePlan, FlockPlan, FlockResult, LatencyResult,
    RecordResult, SimResult, Ways, bringup, convoy, deploy, deploy_ways, explore, flock, flock_ways, latency, rays,
    record, sim,
};
use drover_config::{Links, Problems, Swarm, load_swarm};
use drover_contract::{Pose, Twist};
use drover_picture::{Chart, Run, Series, pictures};
use drover_record::{Moment, RobotMoment, Setting, Truth};
use serde::Serialize;
use std::fmt::Display;
use std::ops::Range;
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
    /// The swarm whose kinds and behaviour are used: config/swarms/first.toml, or ten.toml for record, unless given;
    /// for deploy, flock and explore the only scene, instead of config/swarms/deploy_*.toml, flock_*.toml,
    /// explore_*.toml
    #[arg(long)]
    swarm: Option<PathBuf>,
    /// The MAVLink kind of that swarm to measure with
    #[arg(long, default_value = "rover_mavlink")]
    kind: String,
    /// Robots at most
    #[arg(long, default_value_t = 100)]
    robots: u32,
    /// Seeds of each row's runs, without B: 0..20 unless given, 0..40 for flock, 0..10 or fewer for explore
    #[arg(long, value_name = "A..B", value_parser = seeds)]
    seeds: Option<Range<u64>>,
    /// Draw what is measured against a number of robots or of runs, for deploy and flock the robots' ways, for explore
    /// the paper's figures, as SVG and PNG, into this folder (sim, record, deploy, flock, explore)
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// This part of explore alone: rows, killed, teams, large, figures or cost
    #[arg(long, value_name = "PART", value_parser = part)]
    only: Option<ExplorePart>,
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
    /// Deployment: the paper's, ours, its parts, modern peers, on the same scenes and seeds; what a round costs
    Deploy,
    /// Flocking: the paper's, repairs of it, ours, its parts, on the same scenes and seeds; what a decision costs
    Flock,
    /// Exploration: the paper's, without its parts, classical methods, ours, on the same places and starts, also when a
    /// robot dies, with more robots, on larger places; what a decision costs
    Explore,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let measured = match arguments.name {
        Name::Deploy => measure_deploy(arguments),
        Name::Flock => measure_flock(arguments),
        Name::Explore => measure_explore(arguments),
        Name::Rays => {
            show(&rays(arguments.quick), arguments.json);
            Ok(())
        }
        Name::Latency | Name::Bringup | Name::Sim | Name::Record => measure_with_template(arguments),
    };
    match measured {
        Ok(()) => Exit::Reached,
        Err(error) => {
            eprintln!("{error:#}");
            if error.is::<Problems>() { Exit::BadInput } else { Exit::CannotStart }
        }
    }
}

/// The benches that run a swarm made after another.
fn measure_with_template(arguments: &Arguments) -> anyhow::Result<()> {
    let usual = if matches!(arguments.name, Name::Record) { "ten" } else { "first" };
    let usual = Path::new("config/swarms").join(usual).with_extension("toml");
    let template = load_swarm(arguments.swarm.as_deref().unwrap_or(&usual), &[])?;
    match arguments.name {
        Name::Latency => show(&measure_latency(arguments, &template)?, arguments.json),
        Name::Bringup => show(&measure_bringup(arguments, &template)?, arguments.json),
        Name::Record => {
            let result = measure_record(arguments, &template)?;
            show(&result, arguments.json);
            draw(arguments, "record", &record_chart(&result))?;
        }
        Name::Sim => {
            let result = measure_sim(arguments, &template)?;
            show(&result, arguments.json);
            draw(arguments, "sim", &sim_chart(&result))?;
        }
        Name::Rays | Name::Deploy | Name::Flock | Name::Explore => {} // they need none
    }
    Ok(())
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
    write(folder, name, [("svg", chart.svg()?.into_bytes()), ("png", chart.png()?)])
}

fn write(folder: &Path, name: &str, files: [(&str, Vec<u8>); 2]) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    for (extension, bytes) in files {
        let path = folder.join(name).with_extension(extension);
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        eprintln!("{}", path.display());
    }
    Ok(())
}

/// Where the robots went, from above; who is out of view is not drawn.
fn draw_ways(folder: &Path, ways: &Ways) -> anyhow::Result<()> {
    let robots = || ways.swarm.robots.iter().map(|robot| robot.id);
    let moment = |(time_s, poses): &(f64, Vec<Pose>)| {
        let seen = |pose: &&Pose| ways.shows([pose.x_m, pose.y_m]);
        let truths = poses.iter().map(|pose| Some(pose).filter(seen).map(|pose| Truth::new(*pose, Twist::ZERO, false)));
        let robots = robots().zip(truths).map(|(id, truth)| RobotMoment::unheard(id, truth)).collect();
        Moment { time_s: *time_s, robots, ..Moment::default() }
    };
    let setting = Setting::of_swarm(&ways.swarm, 0);
    let run = Run {
        setting: Setting {
            route_m: ways.shown_of(&setting.route_m),
            goal: setting.goal.filter(|goal| ways.shows(goal.at_m)),
            ..setting
        },
        moments: ways.moments.iter().map(moment).collect(),
        ..Run::default()
    };
    let ways_alone = pictures(&run)?.into_iter().find(|picture| picture.name == "trajectories");
    let picture = ways_alone.context("there is no picture of ways")?;
    write(folder, &ways.name, [("svg", picture.svg.into_bytes()), ("png", picture.png)])
}

fn deploy_chart(result: &DeployResult) -> Chart {
    let points = result.cost.iter().map(|row| [f64::from(row.robots), row.round_us]).collect();
    decision_chart(points, ["deployment", "robots", "microseconds a robot and round"], &result.conditions)
}

fn flock_chart(result: &FlockResult) -> Chart {
    let points = result.cost.iter().map(|row| [f64::from(row.followers), row.tick_us]).collect();
    decision_chart(points, ["flocking", "followers", "microseconds a robot and tick"], &result.conditions)
}

fn decision_chart(points: Vec<[f64; 2]>, [what, x_label, y_label]: [&str; 3], conditions: &Conditions) -> Chart {
    Chart {
        title: format!("Cost of a decision against the number of {x_label}"),
        subtitle: format!("{what} in the open, one thread; {conditions}"),
        x_label: x_label.into(),
        y_label: y_label.into(),
        x_log: true,
        series: vec![Series { points, ..Series::default() }],
        ..Chart::default()
    }
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

fn measure_deploy(arguments: &Arguments) -> anyhow::Result<()> {
    let plan = DeployPlan::new(arguments.swarm.as_deref(), arguments.seeds.clone(), arguments.quick)?;
    let result = counted(plan.runs(), |on_run| deploy(&plan, on_run))?;
    show(&result, arguments.json);
    let Some(folder) = &arguments.figures else { return Ok(()) };
    if !result.cost.is_empty() {
        draw(arguments, "deploy_cost", &deploy_chart(&result))?;
    }
    deploy_ways(&plan)?.iter().try_for_each(|ways| draw_ways(folder, ways))
}

fn measure_flock(arguments: &Arguments) -> anyhow::Result<()> {
    let plan = FlockPlan::new(arguments.swarm.as_deref(), arguments.seeds.clone(), arguments.quick)?;
    let result = counted(plan.runs(), |on_run| flock(&plan, on_run))?;
    show(&result, arguments.json);
    let Some(folder) = &arguments.figures else { return Ok(()) };
    if !result.cost.is_empty() {
        draw(arguments, "flock_cost", &flock_chart(&result))?;
    }
    flock_ways(&plan, &result)?.iter().try_for_each(|ways| draw_ways(folder, ways))
}

fn measure_explore(arguments: &Arguments) -> anyhow::Result<()> {
    let plan = ExplorePlan::new(arguments.swarm.as_deref(), arguments.seeds.clone(), arguments.quick)?;
    let plan = plan.only(arguments.only);
    let result = counted(plan.runs(), |on_run| explore(&plan, on_run))?;
    show(&result, arguments.json);
    explore_charts::of(&result).iter().try_for_each(|(name, chart)| draw(arguments, name, chart))
}

/// `measure`, which tells of every run that has ended, behind a bar of so many.
fn counted<T>(runs: u64, measure: impl FnOnce(&(dyn Fn() + Sync)) -> anyhow::Result<T>) -> anyhow::Result<T> {
    let bar = meter::bar(runs);
    bar.set_message(format!("of {runs} runs"));
    let result = measure(&|| bar.inc(1));
    bar.finish_and_clear();
    result
}

fn part(text: &str) -> Result<ExplorePart, String> {
    let names = ExplorePart::ALL.map(ExplorePart::name).join(", ");
    ExplorePart::named(text).ok_or_else(|| format!("{text:?} is none of {names}"))
}

fn seeds(text: &str) -> Result<Range<u64>, String> {
    let ends = text.split_once("..").and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    let is_some = |seeds: &Range<u64>| !seeds.is_empty();
    ends.filter(is_some).ok_or_else(|| format!("{text:?} is not A..B with whole numbers, B greater than A"))
}
