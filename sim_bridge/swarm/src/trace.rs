//! What a run in virtual time leaves behind: a recording, the resolved swarm and the result.

use crate::seen::moment_of;
use crate::trial::{Trial, TrialResult};
use anyhow::Context;
use drover_config::Swarm;
use drover_contract::Stamp;
use drover_record::{Pace, Recorder, RecorderOptions, RunState, Setting};
use std::fs::{create_dir_all, write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How often everybody is written down.
const EVERY: Duration = Duration::from_millis(100);

/// The folder of one run, and the recording in it.
pub(crate) struct Trace {
    folder: PathBuf,
    ids: Vec<u32>,
    due: Stamp,
    recorder: Recorder,
    /// Whether scans come with the moments, and not from the robots' own loops.
    scans: bool,
}

impl Trace {
    /// Makes the folder, with the resolved swarm in it.
    pub(crate) fn create(folder: &Path, swarm: &Swarm, scans: bool) -> anyhow::Result<Self> {
        create_dir_all(folder)?;
        write(folder.join("swarm.toml"), swarm.to_toml())?;
        // Virtual time begins in 1970, so that one seed gives the same bytes whenever it is run.
        let options = RecorderOptions { path: folder.join("run.mcap"), pace: Pace::Virtual, unix_offset_us: 0 };
        let recorder = Recorder::create(options, &Setting::of_swarm(swarm, 0))?;
        let ids = swarm.robots.iter().map(|robot| robot.id).collect();
        Ok(Self { folder: folder.to_owned(), ids, due: Stamp::ZERO, recorder, scans })
    }

    /// What writes.
    pub(crate) const fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Write everybody down if it is time to.
    pub(crate) fn see(&mut self, trial: &dyn Trial) {
        if trial.now() < self.due {
            return;
        }
        self.due = trial.now() + EVERY;
        let views = (0..self.ids.len()).map(|robot| trial.view(robot));
        let run = RunState { rate: 1.0, ..RunState::default() };
        let moment = moment_of(trial.now(), trial.arena(), self.ids.iter().copied().zip(views), run);
        if self.scans {
            self.recorder.moment_with_scans(&moment);
        } else {
            self.recorder.moment(&moment);
        }
    }

    /// The run is over: its result.
    pub(crate) fn finish(self, result: &TrialResult) -> anyhow::Result<()> {
        let document = serde_json::to_value(result)?;
        self.recorder.finish(&document);
        write(self.folder.join("result.json"), serde_json::to_string_pretty(&document)?)?;
        match self.recorder.state().failed {
            Some(why) => Err(anyhow::anyhow!(why)).context("the recording is not whole"),
            None => Ok(()),
        }
    }
}
