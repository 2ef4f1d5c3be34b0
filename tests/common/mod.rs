//! Shared by the tests in real time: the shipped swarm on free ports, a world to drive in, children to kill.

#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part of it")]

use drover_bridge::{Bridge, CanChoice, NearSide, PlantHandle, pace};
use drover_config::{Override, Swarm, load_swarm};
use drover_contract::Clock;
use drover_io::OsClock;
use serde_json::Value;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Slower than this a body stands, m/s and rad/s.
pub const STANDSTILL: f64 = 0.01;

/// The binary under test.
pub fn drover() -> Command {
    Command::new(env!("CARGO_BIN_EXE_drover"))
}

/// The top of the project.
pub fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The shipped swarm's file.
pub fn first_toml() -> PathBuf {
    top().join("config/swarms/first.toml")
}

/// First port of a range that nobody uses now. Tests run side by side: each looks for its own.
pub fn free_port_base() -> u16 {
    const PORTS: u16 = 320;
    for attempt in 0..200 {
        let probe = UdpSocket::bind("127.0.0.1:0").expect("a free port");
        let base = probe.local_addr().expect("its address").port();
        let usable = base < u16::MAX - PORTS && base > 1024;
        let free = |port| UdpSocket::bind(("127.0.0.1", port)).is_ok();
        drop(probe);
        if usable && (base..base + PORTS).all(free) {
            return base;
        }
        std::thread::sleep(Duration::from_millis(attempt));
    }
    panic!("no {PORTS} free UDP ports in a row");
}

/// Overrides that keep a run of the shipped swarm to itself, recordings in `folder`.
pub fn private(folder: &Path) -> Vec<String> {
    let base = free_port_base();
    vec![
        format!("mavlink_port_base={base}"),
        format!("beacon.port={}", base + 319),
        format!("record_dir={:?}", folder.display().to_string()),
    ]
}

/// The shipped swarm, to itself, with more keys set.
pub fn first_swarm(folder: &Path, set: &[&str]) -> Swarm {
    let mut all = private(folder);
    all.extend(set.iter().map(|text| (*text).to_owned()));
    let all: Vec<Override> = all.iter().map(|text| Override::parse(text).expect("a good override")).collect();
    load_swarm(&first_toml(), &all).unwrap_or_else(|problems| panic!("{problems}"))
}

/// `drover up` on the shipped swarm with `arguments`, to its end.
pub fn up(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = up_command(folder, arguments);
    command.output().expect("drover runs")
}

/// The same with another shipped swarm.
pub fn up_swarm(name: &str, folder: &Path, arguments: &[&str]) -> Output {
    let mut command = drover();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/swarms/{name}.toml"));
    command.arg("up").arg(file).args(arguments).stdin(Stdio::null());
    private(folder).iter().for_each(|set| {
        command.arg("--set").arg(set);
    });
    command.output().expect("drover runs")
}

/// The same, not started yet.
pub fn up_command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = drover();
    command.arg("up").arg(first_toml()).args(arguments).stdin(Stdio::null());
    private(folder).iter().for_each(|set| {
        command.arg("--set").arg(set);
    });
    command
}

/// What a program printed as one JSON document.
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        panic!("{error}; exit {:?}\nstdout: {out}\nstderr: {err}", output.status.code())
    })
}

/// What issue 2 asks of a summary: all there, no contact, nothing aged, everybody seen to stand.
pub fn assert_reached_safely(summary: &Value) {
    let text = serde_json::to_string_pretty(summary).unwrap_or_default();
    assert_eq!(summary["reached"], true, "{text}");
    assert_eq!(summary["robots"].as_array().map(Vec::len), Some(5), "{text}");
    assert!(summary["robots"].as_array().is_some_and(|all| all.iter().all(|robot| robot["reached"] == true)), "{text}");
    assert!(summary["min_gap_robot_m"].as_f64().is_some_and(|gap_m| gap_m > 0.0), "{text}");
    assert!(summary["min_gap_wall_m"].as_f64().is_some_and(|gap_m| gap_m > 0.0), "{text}");
    assert_eq!(summary["aged_commands"], 0, "{text}");
    assert_eq!(summary["stopped"], true, "{text}");
}

/// A world that runs beside the test, with what its robots are to connect to.
pub struct Place {
    /// The world and its firmware.
    pub plant: PlantHandle,
    /// What each robot is to connect to.
    pub near_sides: Vec<NearSide>,
    /// Where recordings and robot files go.
    pub folder: TempDir,
    swarm: Swarm,
    _runtime: tokio::runtime::Runtime,
}

impl Place {
    /// Open all links of `swarm`'s firmware, for robots that are processes.
    pub fn open(swarm: Swarm, folder: TempDir) -> Self {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime = runtime.expect("a runtime");
        let clock = OsClock::new();
        let opened =
            runtime.block_on(async { Bridge::open(&swarm, CanChoice::best(&swarm, true).backing, clock.now()) });
        let (bridge, near_sides) = opened.unwrap_or_else(|error| panic!("{error}"));
        let plant = bridge.plant();
        runtime.spawn(pace(bridge, clock));
        Self { plant, near_sides, folder, swarm, _runtime: runtime }
    }

    /// Write robot `index`'s file.
    pub fn robot_file(&self, index: usize) -> PathBuf {
        let id = self.swarm.robots[index].id;
        let mut file = self.swarm.robot_file(id).expect("a robot of the swarm");
        file.robot.links = self.near_sides[index].links().expect("links with addresses");
        let path = self.folder.path().join(format!("robot-{id}.toml"));
        std::fs::write(&path, file.to_toml()).expect("a writable folder");
        path
    }

    /// Start robot `index` as a process.
    pub fn start(&self, index: usize) -> Running {
        let file = self.robot_file(index);
        Running::start(drover().arg("run").arg(file).arg("--json").stdin(Stdio::null()).stdout(Stdio::null()))
    }

    /// The swarm.
    pub fn swarm(&self) -> &Swarm {
        &self.swarm
    }

    /// Speed of body `index`, m/s.
    pub fn speed_mps(&self, index: usize) -> f64 {
        self.plant.with(|plant| plant.truth(index).twist_b.speed_mps)
    }

    /// Whether body `index` moves.
    pub fn moves(&self, index: usize) -> bool {
        let twist_b = self.plant.with(|plant| plant.truth(index).twist_b);
        twist_b.speed_mps.abs() > STANDSTILL || twist_b.yaw_rate_radps.abs() > STANDSTILL
    }

    /// Wait until `done`; panics with `what` after `limit_s`.
    pub fn wait(&self, what: &str, limit_s: f64, mut done: impl FnMut(&Self) -> bool) {
        let limit = Instant::now() + Duration::from_secs_f64(limit_s);
        while Instant::now() < limit {
            if done(self) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("not within {limit_s} s: {what}");
    }

    /// Watch body `index` for `watch_s` seconds: how long after now it last moved, s.
    pub fn last_motion_s(&self, index: usize, watch_s: f64) -> f64 {
        let began = Instant::now();
        let mut last = began;
        while began.elapsed().as_secs_f64() < watch_s {
            if self.moves(index) {
                last = Instant::now();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        last.duration_since(began).as_secs_f64()
    }
}

/// Export a recording into a folder of its own beside it.
pub fn exported(recording: &Path) -> PathBuf {
    let folder = recording.with_extension("export");
    let output = drover().arg("export").arg(recording).arg("--to").arg(&folder).output().expect("drover runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

/// A child that does not outlive its test.
pub struct Running(Child);

impl Running {
    /// Start it.
    pub fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}")))
    }

    /// SIGKILL: it gets no chance to say goodbye.
    pub fn kill(&mut self) {
        self.0.kill().expect("it was running");
        self.0.wait().expect("it has ended");
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// Wait for its end.
    pub fn wait(mut self) -> std::process::ExitStatus {
        self.0.wait().expect("it was started")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Send a signal by name, as a shell would.
pub fn signal(name: &str, process: u32) {
    let sent = Command::new("kill").arg(format!("-{name}")).arg(process.to_string()).status().expect("kill runs");
    assert!(sent.success(), "kill -{name} {process}");
}

/// The Python that has the peers which others wrote.
pub fn peers_python() -> String {
    std::env::var("DROVER_PEERS_PYTHON").expect(
        "DROVER_PEERS_PYTHON is not set: run tests/run, or set it to a Python with tests/conformance/requirements.txt",
    )
}

/// One of the peers in tests/conformance/peers.
pub fn peer(script: &str) -> Command {
    let mut command = Command::new(peers_python());
    command.arg(top().join("tests/conformance/peers").join(script));
    command
}
