//! `drover replay RUN.mcap`: a recording in the live view, or fed to today's code.

mod check;

use crate::command::{asked_to_end, open_recording};
use crate::exit::Exit;
use crate::onlook::{View, ViewArguments};
use drover_record::{Control, Controls, Moment, Onlooker, Phase, RecordingFile};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often the view is fed.
const PERIOD: Duration = Duration::from_millis(50);
/// Fastest replay.
const RATE_MAX: f64 = 100.0;

/// Arguments of `drover replay`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The recording
    file: PathBuf,
    /// Seconds of the recording per second; the page can change it
    #[arg(long, default_value_t = 1.0, value_name = "RATE", value_parser = rate)]
    speed: f64,
    /// Feed what the robots' links received to today's code, and say where its decisions first differ
    #[arg(long)]
    check: bool,
    /// With --check: print one JSON document on stdout
    #[arg(long, requires = "check")]
    json: bool,
    #[command(flatten)]
    view: ViewArguments,
}

fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if rate > 0.0 && rate <= RATE_MAX { Ok(rate) } else { Err(format!("{rate}: more than 0 and at most {RATE_MAX}")) }
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let recording = match open_recording(&arguments.file) {
        Ok(recording) => recording,
        Err(exit) => return exit,
    };
    if arguments.check {
        return check::check(&recording, arguments.json);
    }
    match show(&recording, arguments) {
        Ok(()) => Exit::Reached,
        Err(error) => {
            eprintln!("{error:#}");
            Exit::CannotStart
        }
    }
}

fn show(recording: &RecordingFile, arguments: &Arguments) -> anyhow::Result<()> {
    let moments = recording.moments(true);
    anyhow::ensure!(!moments.is_empty(), "there is nothing in the recording to show");
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    runtime.block_on(async {
        let mut view = View::start(&arguments.view, true).await?;
        view.announce();
        eprintln!("{:.1} s are shown; Ctrl-C ends", recording.duration_s);
        let mut setting = recording.setting.clone();
        setting.duration_s = Some(recording.duration_s);
        view.begin(setting, Controls { stop: false, pace: true, restart: true, seek: true });
        let mut player = Player { moments, at_s: 0.0, rate: arguments.speed, held: false };
        let mut ticker = tokio::time::interval(PERIOD);
        let mut before = Instant::now();
        let end = asked_to_end();
        tokio::pin!(end);
        loop {
            tokio::select! {
                _ = ticker.tick() => {}
                () = &mut end => return Ok(()),
            }
            while let Some(control) = view.next_control() {
                player.obey(control);
            }
            let now = Instant::now();
            player.advance(now.duration_since(before));
            before = now;
            view.show(player.moment());
        }
    })
}

/// Where in a recording somebody is.
struct Player {
    /// At least one, in the order of time.
    moments: Vec<Moment>,
    at_s: f64,
    rate: f64,
    held: bool,
}

impl Player {
    fn obey(&mut self, control: Control) {
        match control {
            Control::Pause => self.held = true,
            Control::Resume => self.held = false,
            Control::Speed { rate } if rate > 0.0 && rate <= RATE_MAX => {
                self.rate = rate;
                self.held = false;
            }
            Control::Restart => self.at_s = 0.0,
            Control::Seek { time_s } if time_s.is_finite() => self.at_s = time_s.clamp(0.0, self.end_s()),
            Control::Stop | Control::Speed { .. } | Control::Seek { .. } => {}
        }
    }

    fn end_s(&self) -> f64 {
        self.moments.last().map_or(0.0, |last| last.time_s)
    }

    fn advance(&mut self, span: Duration) {
        if !self.held {
            self.at_s = (self.at_s + span.as_secs_f64() * self.rate).min(self.end_s());
        }
    }

    /// The newest moment up to where we are.
    fn moment(&self) -> Moment {
        let after = self.moments.partition_point(|moment| moment.time_s <= self.at_s);
        let mut moment = self.moments[after.saturating_sub(1).min(self.moments.len() - 1)].clone();
        moment.run.rate = if self.held { 0.0 } else { self.rate };
        moment.run.phase = match (self.held, self.at_s >= self.end_s()) {
            (_, true) => Phase::Ended,
            (true, false) => Phase::Paused,
            (false, false) => moment.run.phase,
        };
        moment
    }
}
