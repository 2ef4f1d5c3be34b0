//! Peers that others wrote, beside a test; and one robot alone.

#![allow(dead_code, reason = "each test binary uses a part of it")]

use crate::common::{Running, drover, first_swarm, peer, signal};
use drover_config::{Links, Swarm};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Stdio};
use std::time::{Duration, Instant};

/// A peer's script that runs beside the test and does not outlive it.
pub(crate) struct Peer {
    child: Child,
    stdout: BufReader<ChildStdout>,
    script: String,
}

impl Peer {
    /// Start it.
    pub(crate) fn start(script: &str, arguments: &[&str]) -> Self {
        let mut command = peer(script);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let stdout = BufReader::new(child.stdout.take().expect("it is a pipe"));
        Self { child, stdout, script: script.to_owned() }
    }

    /// The next line that it prints, JSON.
    pub(crate) fn line(&mut self) -> Value {
        let mut line = String::new();
        self.stdout.read_line(&mut line).expect("its output");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{} printed {line:?}: {error}", self.script))
    }

    /// Tell it to end; its last words.
    pub(crate) fn end(self) -> Value {
        signal("TERM", self.child.id());
        self.finish()
    }

    /// Wait for its end, which must be a good one; its last words.
    pub(crate) fn finish(mut self) -> Value {
        let last = self.line();
        let ended = self.child.wait().expect("it was started");
        assert!(ended.success(), "{} ended with {ended}: {last:#}", self.script);
        last
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A robot's process, and where its views go.
pub(crate) struct Driven {
    /// The process.
    pub(crate) running: Running,
    views: PathBuf,
}

impl Driven {
    /// `drover run` on a robot's file.
    pub(crate) fn start(file: &Path) -> Self {
        let views = file.with_extension("views");
        let stdout = File::create(&views).expect("a writable folder");
        let errors = File::create(file.with_extension("errors")).expect("a writable folder");
        let mut command = drover();
        command.arg("run").arg(file).arg("--json").stdin(Stdio::null()).stdout(stdout).stderr(errors);
        Self { running: Running::start(&mut command), views }
    }

    /// Its newest view.
    pub(crate) fn view(&self) -> Option<Value> {
        let text = std::fs::read_to_string(&self.views).expect("its views");
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let newest = whole.lines().rev().find_map(|line| serde_json::from_str::<Value>(line).ok())?;
        newest.get("view").cloned()
    }

    /// Wait until its newest view is as wanted; that view.
    pub(crate) fn wait_view(&self, what: &str, limit_s: f64, wanted: impl Fn(&Value) -> bool) -> Value {
        let limit = Instant::now() + Duration::from_secs_f64(limit_s);
        let mut newest = Value::Null;
        while Instant::now() < limit {
            newest = self.view().unwrap_or_default();
            if wanted(&newest) {
                return newest;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("not within {limit_s} s: {what}; at last {newest:#}\n{}", self.errors());
    }

    /// What it wrote on standard error.
    pub(crate) fn errors(&self) -> String {
        std::fs::read_to_string(self.views.with_extension("errors")).expect("its errors")
    }

    /// End it as an operator does; its exit code.
    pub(crate) fn terminate(self) -> Option<i32> {
        signal("TERM", self.running.id());
        self.running.wait().code()
    }
}

/// Whether a view says that the robot drives faster than `speed_mps`.
pub(crate) fn faster_than(speed_mps: f64) -> impl Fn(&Value) -> bool {
    move |view| view["speed_mps"].as_f64().is_some_and(|mps| mps > speed_mps)
}

/// The shipped swarm with robot `id` alone in it, leading.
pub(crate) fn alone(folder: &Path, id: u32) -> Swarm {
    let mut swarm = first_swarm(folder, &[&format!("behaviour.leader={id}")]);
    swarm.robots.retain(|robot| robot.id == id);
    assert_eq!(swarm.robots.len(), 1);
    swarm
}

/// The file of the only robot of `swarm`, with these links.
pub(crate) fn file_with_links(swarm: &Swarm, links: Links, folder: &Path) -> PathBuf {
    let mut file = swarm.robot_file(swarm.robots[0].id).expect("it is of the swarm");
    file.robot.links = links;
    let path = folder.join("robot.toml");
    std::fs::write(&path, file.to_toml()).expect("a writable folder");
    path
}

/// A number of a peer's report.
pub(crate) fn number(report: &Value, name: &str) -> f64 {
    report[name].as_f64().unwrap_or_else(|| panic!("no number {name} in {report:#}"))
}
