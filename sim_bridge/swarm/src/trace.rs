//! What a run in virtual time leaves behind: where everybody was, and with the wire every byte.

use crate::trial::{Trial, TrialResult};
use drover_config::Swarm;
use drover_contract::Stamp;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

/// How often everybody is written down.
const EVERY: Duration = Duration::from_millis(100);

/// Everybody's way, as a table of text that any spreadsheet reads.
pub(crate) struct Trace {
    ids: Vec<u32>,
    due: Stamp,
    text: String,
}

impl Trace {
    pub(crate) fn new(swarm: &Swarm) -> Self {
        let text = "time_s,robot,x_m,y_m,yaw_rad,speed_mps,yaw_rate_radps,in_contact,state,reason\n".to_owned();
        Self { ids: swarm.robots.iter().map(|robot| robot.id).collect(), due: Stamp::ZERO, text }
    }

    /// Write everybody down if it is time to.
    pub(crate) fn see(&mut self, trial: &dyn Trial) {
        if trial.now() < self.due {
            return;
        }
        self.due = trial.now() + EVERY;
        for (robot, id) in self.ids.iter().enumerate() {
            let state = trial.arena().state(robot);
            let (pose, twist) = (state.pose_wb, state.twist_b);
            let (word, reason) = trial.status(robot).map_or(("dead", String::new()), |status| {
                (status.state.word(), status.verdict.to_string())
            });
            // Writing to a text in memory does not fail.
            let _ = writeln!(
                self.text,
                "{},{id},{:.6},{:.6},{:.6},{:.6},{:.6},{},{word},{reason}",
                trial.now(),
                pose.x_m,
                pose.y_m,
                pose.yaw_rad,
                twist.speed_mps,
                twist.yaw_rate_radps,
                u8::from(state.in_contact),
            );
        }
    }

    /// Write a run's folder: the trace, the resolved swarm, the result, and what was recorded of the wire.
    pub(crate) fn write(
        &self,
        folder: &Path,
        swarm: &Swarm,
        trial: &dyn Trial,
        result: &TrialResult,
    ) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("states.csv"), &self.text)?;
        std::fs::write(folder.join("swarm.toml"), swarm.to_toml())?;
        std::fs::write(folder.join("result.json"), serde_json::to_string_pretty(result)?)?;
        for (name, bytes) in trial.recordings() {
            std::fs::write(folder.join(name), bytes)?;
        }
        Ok(())
    }
}
