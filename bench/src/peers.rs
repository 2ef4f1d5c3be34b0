//! Peers that others wrote, run beside us: Python programs, each in a venv that `bench/peers/setup` makes.

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Both are found from the repository's root; anywhere else there are no peers.
const SCRIPT: &str = "bench/peers/irsim.py";
/// Interpreter and lidar of IR-SIM, and of the same with its lidar in C++.
const PEERS: [(&str, &str); 2] =
    [("target/peers-irsim/bin/python", "python"), ("target/peers-irsimx/bin/python", "cpp")];

/// Beyond the time for its ticks: a peer has to start, build its world and warm up.
const START_S: u64 = 60;

/// What a peer reached.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PeerRate {
    /// Its name.
    pub peer: String,
    /// Its version.
    pub version: String,
    /// How many robots.
    pub robots: u32,
    /// Beams of each robot's lidar.
    pub beams: u32,
    /// Robots times ticks a second.
    pub robot_steps_per_s: f64,
    /// Where it differs.
    pub notes: String,
}

/// Every peer that is installed, on our work.
///
/// # Errors
/// If one is installed and fails, takes too long, or says something else than a rate.
pub(crate) fn peers(robots: u32, quick: bool) -> anyhow::Result<Vec<PeerRate>> {
    let there = PEERS.iter().filter(|(python, _)| Path::new(SCRIPT).is_file() && Path::new(python).exists());
    there.map(|(python, lidar)| irsim(python, lidar, robots, quick)).collect()
}

fn irsim(python: &str, lidar: &str, robots: u32, quick: bool) -> anyhow::Result<PeerRate> {
    let (ticks, seconds_max) = if quick { (5, 2) } else { (200, 20) };
    let mut command = Command::new(python);
    command.arg(SCRIPT).args(["--robots", &robots.to_string(), "--ticks", &ticks.to_string()]);
    command.args(["--seconds-max", &seconds_max.to_string(), "--lidar", lidar]);
    let said = output(&mut command, Duration::from_secs(START_S + seconds_max)).context(SCRIPT)?;
    serde_json::from_str(&said).with_context(|| format!("{SCRIPT} said {said:?}"))
}

/// What `command` prints until it ends, which it must within `limit`. What it complains about goes where ours goes.
fn output(command: &mut Command, limit: Duration) -> anyhow::Result<String> {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?;
    let ended = wait(&mut child, limit);
    if ended.is_err() {
        // It may have ended by itself just now; then there is nothing to kill, and that is fine.
        let _ = child.kill();
        child.wait()?;
    }
    ended?;
    let mut said = String::new();
    child.stdout.take().context("no output")?.read_to_string(&mut said)?;
    Ok(said)
}

/// Until `child` has ended well. A line or two fit into the pipe meanwhile.
fn wait(child: &mut Child, limit: Duration) -> anyhow::Result<()> {
    const POLL: Duration = Duration::from_millis(20);
    let begun = Instant::now();
    while begun.elapsed() < limit {
        match child.try_wait()? {
            Some(status) if status.success() => return Ok(()),
            Some(status) => bail!("ended with {status}"),
            None => std::thread::sleep(POLL),
        }
    }
    bail!("not done after {} s", limit.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, limit_ms: u64) -> anyhow::Result<String> {
        output(Command::new("sh").args(["-c", script]), Duration::from_millis(limit_ms))
    }

    #[test]
    fn a_line_is_read_and_failures_and_hangs_are_errors() {
        assert_eq!(shell("echo line", 10_000).unwrap(), "line\n");
        assert!(shell("exit 3", 10_000).unwrap_err().to_string().contains("3"));
        assert!(shell("exec sleep 60", 50).unwrap_err().to_string().contains("not done"));
    }

    #[test]
    fn a_rate_is_read_and_more_fields_do_no_harm() {
        let said = r#"{"peer": "p", "version": "1", "robots": 10, "beams": 360, "ticks": 5,
            "robot_steps_per_s": 284.5, "notes": ""}"#;
        let rate: PeerRate = serde_json::from_str(said).unwrap();
        assert_eq!((rate.robots, rate.beams), (10, 360));
    }
}
