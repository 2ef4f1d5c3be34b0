//! `drover bench bringup`: so many MAVLink robots in one process, from start to all driving, over real UDP.
//!
//! The figures hold the robots and the simulator that stands in for their hardware: both run in this process.

use crate::machine::{Conditions, ProcessUse};
use drover_config::Swarm;
use drover_contract::BehaviourState;
use drover_swarm::{Summary, Tally, UpOptions, up};
use serde::Serialize;
use std::fmt;

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct BringupResult {
    /// Under which conditions.
    pub conditions: Conditions,
    /// Robots.
    pub robots: usize,
    /// From the first start to the moment at which every robot's drive obeys and its supervisor lets it drive, s; none
    /// if that never came.
    pub all_driving_s: Option<f64>,
    /// Of that, what the virtual autopilots take until they can be armed, s.
    pub prearm_s: f64,
    /// How long the robots were then watched, s.
    pub watched_s: f64,
    /// Ticks of a robot per second while watched, median (20 Hz are asked for; a fresh scan ticks, too).
    pub tick_hz_median: f64,
    /// The slowest robot's.
    pub tick_hz_min: f64,
    /// Simulated seconds per second while watched: below 1, the simulator lags.
    pub world_rate: f64,
    /// Cores kept busy while watched, per robot, simulator included.
    pub cpu_per_robot: f64,
    /// Resident memory gained since before the start, per robot, MiB, simulator included.
    pub memory_mib_per_robot: f64,
    /// Ticks that came late, of all robots.
    pub late_ticks: u64,
    /// Commands too old to be sent.
    pub aged_commands: u64,
}

/// The swarm at one moment.
#[derive(Clone)]
struct Note {
    time_s: f64,
    used: ProcessUse,
    ticks: Vec<u64>,
}

/// What is noted while the swarm runs.
#[derive(Default)]
struct Notes {
    all_driving: Option<Note>,
    last: Option<Note>,
}

/// Bring `swarm` up and watch it drive for `watch_s` seconds.
///
/// # Errors
/// If a link cannot be opened, or /proc cannot be read.
pub async fn bringup(swarm: &Swarm, watch_s: f64) -> anyhow::Result<BringupResult> {
    let conditions = Conditions::now();
    let before = ProcessUse::now()?;
    let (summary, notes) = watched(swarm, watch_s, false).await?;
    let prearm_s = swarm.kinds.values().map(|kind| kind.sim.prearm_s).fold(0.0, f64::max);
    let robots = swarm.robots.len();
    let (hz_median, hz_min) = notes.tick_hz();
    Ok(BringupResult {
        conditions,
        robots,
        all_driving_s: notes.all_driving.as_ref().map(|note| note.time_s),
        prearm_s,
        watched_s: notes.watched_s(),
        tick_hz_median: hz_median,
        tick_hz_min: hz_min,
        world_rate: summary.world_rate,
        cpu_per_robot: notes.cores() / robots as f64,
        memory_mib_per_robot: notes.resident_gain_mib(before) / robots as f64,
        late_ticks: summary.robots.iter().filter_map(|robot| robot.commands_changed.get("late tick")).sum(),
        aged_commands: summary.aged_commands,
    })
}

/// The share of a core that `swarm` and its simulator use while all drive, recorded or not, over `watch_s` seconds.
pub(crate) async fn drive_for(swarm: &Swarm, watch_s: f64, record: bool) -> anyhow::Result<f64> {
    Ok(watched(swarm, watch_s, record).await?.1.cores())
}

/// Bring `swarm` up and note how it drives for `watch_s` seconds from when all of it does.
async fn watched(swarm: &Swarm, watch_s: f64, record: bool) -> anyhow::Result<(Summary, Notes)> {
    let mut notes = Notes::default();
    let (done, is_done) = tokio::sync::oneshot::channel::<()>();
    let mut done = Some(done);
    let on_view = |time_s: f64, tallies: &[Tally]| {
        notes.see(time_s, tallies);
        if notes.watched_s() >= watch_s {
            // Sent once; the run ends on it.
            let _ = done.take().map(|done| done.send(()));
        }
    };
    let interrupt = async { drop(is_done.await) };
    let options = UpOptions { processes: None, record, on_view, onlooker: None };
    let summary = up(swarm, options, interrupt).await?;
    Ok((summary, notes))
}

impl Notes {
    fn see(&mut self, time_s: f64, tallies: &[Tally]) {
        let views: Vec<_> = tallies.iter().filter_map(|tally| tally.view.as_ref()).collect();
        let Ok(used) = ProcessUse::now() else { return };
        let ticks: Vec<u64> = views.iter().map(|view| view.ticks).collect();
        let driving = |state: &str| state == BehaviourState::Active.word() || state == BehaviourState::Held.word();
        let note = Note { time_s, used, ticks };
        if views.len() == tallies.len() && views.iter().all(|view| view.link == "ready" && driving(&view.state)) {
            self.all_driving.get_or_insert_with(|| note.clone());
        }
        if self.all_driving.is_some() {
            self.last = Some(note);
        }
    }

    fn span(&self) -> Option<(&Note, &Note)> {
        self.all_driving.as_ref().zip(self.last.as_ref())
    }

    fn watched_s(&self) -> f64 {
        self.span().map_or(0.0, |(first, last)| last.time_s - first.time_s)
    }

    fn cores(&self) -> f64 {
        self.span().map_or(f64::NAN, |(first, last)| (last.used.cpu_s - first.used.cpu_s) / self.watched_s())
    }

    fn resident_gain_mib(&self, before: ProcessUse) -> f64 {
        self.last.as_ref().map_or(f64::NAN, |last| last.used.resident_mib - before.resident_mib)
    }

    fn tick_hz(&self) -> (f64, f64) {
        let Some((first, last)) = self.span() else { return (f64::NAN, f64::NAN) };
        let hz = |(from, to): (&u64, &u64)| (to - from) as f64 / self.watched_s();
        let mut all: Vec<f64> = first.ticks.iter().zip(&last.ticks).map(hz).collect();
        all.sort_by(f64::total_cmp);
        (all.get(all.len() / 2).copied().unwrap_or(f64::NAN), all.first().copied().unwrap_or(f64::NAN))
    }
}

impl fmt::Display for BringupResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "bringup: {} MAVLink robots and their simulator in one process; {}", self.robots, self.conditions)?;
        let all = self.all_driving_s.map_or_else(|| "NEVER".into(), |time_s| format!("{time_s:.1} s"));
        writeln!(f, "  start to all driving   {all} (of which {:.1} s until they can be armed)", self.prearm_s)?;
        writeln!(f, "  watched for            {:.1} s", self.watched_s)?;
        writeln!(
            f,
            "  ticks per robot        median {:.1} Hz, slowest {:.1} Hz",
            self.tick_hz_median, self.tick_hz_min
        )?;
        writeln!(f, "  world time / real time {:.3}", self.world_rate)?;
        writeln!(f, "  processor per robot    {:.2} % of a core", self.cpu_per_robot * 100.0)?;
        writeln!(f, "  memory per robot       {:.2} MiB", self.memory_mib_per_robot)?;
        write!(f, "  late ticks             {}; aged commands {}", self.late_ticks, self.aged_commands)
    }
}
