//! Looks at a run while it goes on: gathers what the robots say, shows it, does what those who look on ask, sees the
//! end.

use crate::measures::Measures;
use crate::seen::moment_of;
use crate::summary::{Summary, Tally};
use crate::up::{Robots, UpOptions};
use drover_bridge::PlantHandle;
use drover_config::Swarm;
use drover_contract::{Clock, Stamp};
use drover_io::PacedClock;
use drover_record::foxglove::LinkHealth;
use drover_record::{Control, Moment, Phase, Recorder, RunState, StopState};
use drover_robot::{Shutdown, StopReason, View, send_stop, stop_message};
use std::future::Future;
use std::time::Duration;
use tokio::sync::{mpsc, watch};

/// How a run ends of which somebody wants another one.
pub const RESTARTED: &str = "restarted from the live view";
/// How a run ends whose robots were all stopped, in words.
pub const STOPPED: &str = "stopped from the live view";

/// How often the run is looked at.
const WATCH_PERIOD: Duration = Duration::from_millis(50);
/// How often the links' health is recorded.
const HEALTH_PERIOD: Duration = Duration::from_millis(500);
/// Robots that were told to end have this long.
const END_PATIENCE: Duration = Duration::from_secs(12);
/// Slower than this a body stands, m/s and rad/s.
const STANDSTILL: f64 = 0.01;
/// A message to all robots in one process is repeated this often: a link's queue may be full just then.
const REPEATS: u8 = 3;

/// A stop that was asked for.
struct AskedStop {
    at: Stamp,
    all_standing: Option<Stamp>,
}

pub(crate) struct Watcher<'a> {
    swarm: &'a Swarm,
    clock: &'a PacedClock,
    plant: &'a PlantHandle,
    views: mpsc::Receiver<(usize, View)>,
    say: mpsc::Sender<Vec<u8>>,
    pub(crate) recorder: Option<&'a Recorder>,
    /// Whether every robot is a process of its own.
    pub(crate) processes: bool,
    pub(crate) tallies: Vec<Tally>,
    pub(crate) measures: Measures,
    seen_s: f64,
    stop: Option<AskedStop>,
    words: String,
    health_due: Stamp,
}

impl<'a> Watcher<'a> {
    pub(crate) fn new(
        swarm: &'a Swarm,
        clock: &'a PacedClock,
        plant: &'a PlantHandle,
        views: mpsc::Receiver<(usize, View)>,
        say: mpsc::Sender<Vec<u8>>,
    ) -> Self {
        Self {
            swarm,
            clock,
            plant,
            views,
            say,
            recorder: None,
            processes: false,
            tallies: vec![Tally::default(); swarm.robots.len()],
            measures: plant.with(|plant| Measures::new(swarm, plant.arena())),
            seen_s: 0.0,
            stop: None,
            words: String::new(),
            health_due: Stamp::ZERO,
        }
    }

    /// Watch until the end, then tell every robot. Why it ended, and when.
    pub(crate) async fn watch<W, I>(
        &mut self,
        robots: &Robots,
        eyes: &mut UpOptions<'_, W>,
        end: &watch::Sender<Option<Shutdown>>,
        interrupt: I,
    ) -> (String, f64)
    where
        W: FnMut(f64, &[Tally]),
        I: Future<Output = ()>,
    {
        let began = self.clock.now();
        let mut ticker = tokio::time::interval(WATCH_PERIOD);
        tokio::pin!(interrupt);
        let (why, reason) = loop {
            tokio::select! {
                _ = ticker.tick() => {}
                () = &mut interrupt => break ("interrupted", StopReason::Operator),
            }
            let time_s = self.clock.now().since(began).as_secs_f64();
            self.look(robots, time_s);
            (eyes.on_view)(time_s, &self.tallies);
            if self.attend(eyes) {
                break (RESTARTED, StopReason::Operator);
            }
            let all_there = self.tallies.iter().all(|tally| tally.view.as_ref().is_some_and(|view| view.reached));
            if all_there && self.stop.is_none() {
                break ("every robot reached the end", StopReason::Shutdown);
            }
            if time_s >= self.swarm.duration_s {
                let stopped = self.stop.is_some();
                break (if stopped { STOPPED } else { "the time was over" }, StopReason::Shutdown);
            }
        };
        self.tallies.iter_mut().for_each(Tally::note_end);
        // A held clock would let nobody be seen to stand.
        self.clock.set_rate(1.0);
        // Nobody listening means that every robot has ended by itself.
        let _ = end.send(Some(Shutdown(reason)));
        (why.into(), self.clock.now().since(began).as_secs_f64())
    }

    fn look(&mut self, robots: &Robots, time_s: f64) {
        while let Ok((index, view)) = self.views.try_recv() {
            self.tallies[index].see(view, time_s);
        }
        let times_s = (time_s, time_s - self.seen_s);
        self.seen_s = time_s;
        // Nobody has been told to end: whose task or process has ended is dead.
        let lives = |robot: usize| robots.running.get(robot).is_some_and(|running| !running.is_finished());
        let (tallies, measures) = (&self.tallies, &mut self.measures);
        let said = |robot: usize| lives(robot).then(|| tallies[robot].said());
        self.plant.with(|plant| measures.see(plant.arena(), said, times_s));
    }

    /// Show the run and do what is asked of it; whether another one is wanted.
    fn attend<W>(&mut self, eyes: &mut UpOptions<'_, W>) -> bool {
        let watched = eyes.onlooker.as_ref().is_some_and(|onlooker| onlooker.is_watching());
        if watched || self.recorder.is_some() || self.stop.is_some() {
            let moment = self.moment();
            self.record(&moment);
            if let Some(onlooker) = &mut eyes.onlooker {
                onlooker.show(moment);
            }
        }
        let Some(onlooker) = &mut eyes.onlooker else { return false };
        while let Some(control) = onlooker.next_control() {
            match control {
                Control::Restart => return true,
                other => self.obey(other),
            }
        }
        false
    }

    fn obey(&mut self, control: Control) {
        match control {
            Control::Stop => self.stop_all(),
            Control::Pause => self.pace(0.0),
            Control::Resume => self.pace(1.0),
            Control::Speed { rate } => self.pace(rate),
            // Only a recording has a future to go to; a restart is the caller's.
            Control::Seek { .. } | Control::Restart => {}
        }
    }

    fn pace(&mut self, rate: f64) {
        // A robot's process has a clock of its own. While a stop is under way time goes on as it is.
        if !self.processes && self.stop.as_ref().is_none_or(|stop| stop.all_standing.is_some()) {
            self.clock.set_rate(rate);
        }
    }

    /// Stop every robot over the beacon plane, latched, as `drover stop` does.
    fn stop_all(&mut self) {
        self.clock.set_rate(1.0);
        self.words = STOPPED.into();
        if self.stop.is_none() {
            self.stop = Some(AskedStop { at: self.clock.now(), all_standing: None });
        }
        if self.processes {
            let (name, plane) = (self.swarm.name.clone(), self.swarm.beacon.clone());
            tokio::spawn(async move {
                if let Err(error) = send_stop(&name, &plane, None).await {
                    tracing::error!("{error}");
                }
            });
        } else {
            for seq in 0..REPEATS {
                // A full queue already holds a stop.
                let _ = self.say.try_send(stop_message(&self.swarm.name, None, seq));
            }
        }
    }

    fn moment(&mut self) -> Moment {
        let now = self.clock.now();
        let robots = self.swarm.robots.iter().map(|robot| robot.id);
        let robots = robots.zip(self.tallies.iter().map(|tally| tally.view.clone()));
        let run = RunState { rate: self.clock.rate(), words: self.words.clone(), ..RunState::default() };
        let mut moment = self.plant.with(|plant| moment_of(now, plant.arena(), robots, run));
        moment.run.stop = self.stop_state(now, &moment);
        moment.run.phase = match moment.run.stop {
            Some(StopState { all_standing_s: Some(_), .. }) => Phase::Stopped,
            Some(_) => Phase::Stopping,
            None if moment.run.rate > 0.0 => Phase::Running,
            None => Phase::Paused,
        };
        moment
    }

    fn stop_state(&mut self, now: Stamp, moment: &Moment) -> Option<StopState> {
        let stop = self.stop.as_mut()?;
        let latched = moment.robots.iter().filter(|robot| robot.state == "stopped").count();
        let stands = |twist_b: [f64; 2]| twist_b.iter().all(|speed| speed.abs() < STANDSTILL);
        let truths = moment.robots.iter().filter_map(|robot| robot.truth.as_ref());
        let standing = truths.filter(|truth| stands(truth.twist_b)).count();
        // One that stands and is not latched may drive on.
        if stop.all_standing.is_none() && standing.min(latched) == moment.robots.len() {
            stop.all_standing = Some(now);
        }
        Some(StopState {
            asked_s: stop.at.as_secs_f64(),
            latched,
            standing,
            all_standing_s: stop.all_standing.map(Stamp::as_secs_f64),
        })
    }

    fn record(&mut self, moment: &Moment) {
        let Some(recorder) = self.recorder else { return };
        if self.processes {
            recorder.moment_with_scans(moment);
        } else {
            recorder.moment(moment);
        }
        let now = self.clock.now();
        if now >= self.health_due {
            self.health_due = now + HEALTH_PERIOD;
            for view in self.tallies.iter().filter_map(|tally| tally.view.as_ref()) {
                recorder.health(now, LinkHealth::of_view(view));
            }
        }
        if let (Some(why), true) = (recorder.state().failed, self.words.is_empty()) {
            self.words = format!("the recording has ended: {why}");
        }
    }

    /// Await every robot's last words; what is still running after a patience is ended.
    pub(crate) async fn collect(&mut self, robots: Robots) {
        let limit = tokio::time::Instant::now() + END_PATIENCE;
        for (tally, mut running) in self.tallies.iter_mut().zip(robots.running) {
            match tokio::time::timeout_at(limit, &mut running).await {
                Ok(report) => tally.report = report.ok().flatten(),
                Err(_) => running.abort(),
            }
        }
        while let Ok((index, view)) = self.views.try_recv() {
            self.tallies[index].view = Some(view);
        }
        if let Some(ether) = robots.ether {
            ether.abort();
        }
    }

    /// Show how it ended.
    pub(crate) fn show_end<W>(&mut self, eyes: &mut UpOptions<'_, W>, summary: &Summary) {
        let mut moment = self.moment();
        moment.run.phase = Phase::Ended;
        let stood = if summary.stopped { "every robot stands" } else { "NOT every robot was seen to stand" };
        moment.run.words = format!("{}; {stood}", summary.ended);
        self.record(&moment);
        if let Some(onlooker) = &mut eyes.onlooker {
            onlooker.show(moment);
        }
    }
}
