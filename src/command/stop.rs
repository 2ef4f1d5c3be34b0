//! `drover stop SWARM.toml`: every robot that hears the beacon plane stops, latched.

use crate::command::{overrides, refuse};
use crate::exit::Exit;
use drover_config::{BeaconPlane, Checked, check_file_with};
use drover_contract::RobotId;
use drover_robot::send_stop;
use std::path::PathBuf;

/// Arguments of `drover stop`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The swarm's file, or the file of one of its robots
    file: PathBuf,
    /// Stop this robot alone
    #[arg(long, value_name = "ID")]
    robot: Option<u32>,
    /// Set a configuration key before reading, for example beacon.port=15999
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let set = match overrides(&arguments.set) {
        Ok(set) => set,
        Err(exit) => return exit,
    };
    let (swarm, plane) = match check_file_with(&arguments.file, &set) {
        Ok(Checked::Swarm(swarm)) => (swarm.name.clone(), swarm.beacon.clone()),
        Ok(Checked::Robot(file)) => (file.swarm.clone(), file.beacon.clone()),
        Ok(Checked::Kind(_) | Checked::World(_)) => {
            eprintln!("{}: neither a swarm nor a robot file: give one of those", arguments.file.display());
            return Exit::BadInput;
        }
        Err(problems) => return refuse(&problems),
    };
    match send(&swarm, &plane, arguments.robot.map(RobotId)) {
        Ok(()) => {
            eprintln!("stop sent to {} on {}:{}", whom(arguments.robot), plane.group, plane.port);
            Exit::Reached
        }
        Err(error) => {
            eprintln!("{error}");
            Exit::CannotStart
        }
    }
}

fn whom(robot: Option<u32>) -> String {
    robot.map_or_else(|| "every robot".into(), |id| format!("robot {id}"))
}

fn send(swarm: &str, plane: &BeaconPlane, robot: Option<RobotId>) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    Ok(runtime.block_on(send_stop(swarm, plane, robot))?)
}
