//! Robots as processes of their own, as in the field: each a `drover run` with its file.
//!
//! A child prints one JSON line a view on stdout, and a last one with its report. Its standard input is its lifeline:
//! when we close it, or die, the child stops its robot and ends.

use anyhow::Context;
use drover_config::RobotFile;
use drover_robot::{Line, Report};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout, Command};

use crate::tasks::ViewSender;

/// A child that was told to end is given this long, then it is killed: its drive's own watchdog takes over.
const PATIENCE: Duration = Duration::from_secs(10);

/// One robot's process.
pub(crate) struct ChildRobot {
    child: Child,
    lifeline: Option<ChildStdin>,
    lines: Option<Lines<BufReader<ChildStdout>>>,
}

impl ChildRobot {
    /// Write `file` beside the recordings and start `binary run` with it.
    pub(crate) fn start(binary: &Path, file: &RobotFile, folder: &Path) -> anyhow::Result<Self> {
        let path = folder.join(format!("robot-{}.toml", file.robot.id));
        std::fs::write(&path, file.to_toml()).with_context(|| format!("cannot write {}", path.display()))?;
        let mut child = Command::new(binary)
            .arg("run")
            .arg(&path)
            .args(["--json", "--attached"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .with_context(|| format!("cannot start {}", binary.display()))?;
        let lifeline = child.stdin.take();
        let lines = child.stdout.take().map(|out| BufReader::new(out).lines());
        Ok(Self { child, lifeline, lines })
    }

    /// Pass on what the child says until it ends; its report, if it gave one.
    pub(crate) async fn attend(
        mut self,
        index: usize,
        views: ViewSender,
        mut end: tokio::sync::watch::Receiver<Option<drover_robot::Shutdown>>,
    ) -> Option<Report> {
        let mut lines = self.lines.take()?;
        let mut report = None;
        let mut deadline = None;
        loop {
            let line = tokio::select! {
                line = lines.next_line() => line,
                changed = end.changed(), if self.lifeline.is_some() => {
                    if changed.is_err() || end.borrow().is_some() {
                        self.lifeline = None;
                        deadline = Some(tokio::time::Instant::now() + PATIENCE);
                    }
                    continue;
                }
                () = sleep_until(deadline) => break,
            };
            match line {
                Ok(Some(text)) => match serde_json::from_str(&text) {
                    Ok(Line::View(view)) => drop(views.try_send((index, *view))),
                    Ok(Line::Report(last)) => report = Some(*last),
                    Err(error) => tracing::warn!(%error, "a robot's process printed what is no view"),
                },
                Ok(None) | Err(_) => break,
            }
        }
        if tokio::time::timeout(PATIENCE, self.child.wait()).await.is_err() {
            // It hangs: the drive's own watchdog is what stops the robot now.
            let _ = self.child.kill().await;
        }
        report
    }
}

async fn sleep_until(deadline: Option<tokio::time::Instant>) {
    match deadline {
        Some(deadline) => tokio::time::sleep_until(deadline).await,
        None => std::future::pending().await,
    }
}
