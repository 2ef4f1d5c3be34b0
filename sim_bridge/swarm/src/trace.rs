//! What a run in virtual time leaves behind: where everybody was, and with the wire every byte.

use crate::trial::{Trial, TrialResult};
use drover_config::Swarm;
use drover_contract::Stamp;
use std::fs::{File, create_dir_all, write};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How often everybody is written down.
const EVERY: Duration = Duration::from_millis(100);

/// The folder of one run, and everybody's way in it, as a table of text that any spreadsheet reads.
pub(crate) struct Trace {
    folder: PathBuf,
    ids: Vec<u32>,
    due: Stamp,
    states: BufWriter<File>,
    /// What went wrong first; a run goes on without its table.
    failed: Option<io::Error>,
}

impl Trace {
    /// Makes the folder, with the resolved swarm in it.
    pub(crate) fn create(folder: &Path, swarm: &Swarm) -> io::Result<Self> {
        create_dir_all(folder)?;
        write(folder.join("swarm.toml"), swarm.to_toml())?;
        let mut states = BufWriter::new(File::create(folder.join("states.csv"))?);
        writeln!(states, "time_s,robot,x_m,y_m,yaw_rad,speed_mps,yaw_rate_radps,in_contact,state,reason")?;
        let ids = swarm.robots.iter().map(|robot| robot.id).collect();
        Ok(Self { folder: folder.to_owned(), ids, due: Stamp::ZERO, states, failed: None })
    }

    /// Write everybody down if it is time to.
    pub(crate) fn see(&mut self, trial: &dyn Trial) {
        if trial.now() < self.due || self.failed.is_some() {
            return;
        }
        self.due = trial.now() + EVERY;
        self.failed = self.rows(trial).err();
    }

    fn rows(&mut self, trial: &dyn Trial) -> io::Result<()> {
        for (robot, id) in self.ids.iter().enumerate() {
            let state = trial.arena().state(robot);
            let (pose, twist) = (state.pose_wb, state.twist_b);
            let status = trial.status(robot);
            let word = status.map_or("dead", |status| status.state.word());
            let reason = status.map(|status| status.verdict.to_string()).unwrap_or_default();
            writeln!(
                self.states,
                "{},{id},{:.6},{:.6},{:.6},{:.6},{:.6},{},{word},{reason}",
                trial.now(),
                pose.x_m,
                pose.y_m,
                pose.yaw_rad,
                twist.speed_mps,
                twist.yaw_rate_radps,
                u8::from(state.in_contact),
            )?;
        }
        Ok(())
    }

    /// The run is over: its result, and what was recorded of the wire.
    pub(crate) fn finish(mut self, trial: &dyn Trial, result: &TrialResult) -> io::Result<()> {
        self.states.flush()?;
        if let Some(error) = self.failed {
            return Err(error);
        }
        write(self.folder.join("result.json"), serde_json::to_string_pretty(result)?)?;
        for (name, bytes) in trial.recordings() {
            write(self.folder.join(name), bytes)?;
        }
        Ok(())
    }
}
