//! `drover plot RUN.mcap`: pictures of a recorded run, as SVG and PNG.

use crate::command::open_recording;
use crate::exit::Exit;
use crate::meter;
use anyhow::Context;
use drover_picture::{Intervention, Run, pictures};
use drover_record::RecordingFile;
use std::path::{Path, PathBuf};

/// Arguments of `drover plot`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The recording
    file: PathBuf,
    /// Folder to write to; beside the recording unless given
    #[arg(long, value_name = "FOLDER")]
    to: Option<PathBuf>,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let beside = || arguments.file.with_extension("plots");
    with_run(&arguments.file, |run| draw(run, &arguments.to.clone().unwrap_or_else(beside)))
}

/// Read a recording and do something with it.
pub(crate) fn with_run(file: &Path, work: impl FnOnce(&Run) -> anyhow::Result<()>) -> Exit {
    let recording = match open_recording(file) {
        Ok(recording) => recording,
        Err(exit) => return exit,
    };
    match work(&run_of(&recording, file)) {
        Ok(()) => Exit::Reached,
        Err(error) => {
            eprintln!("{error:#}");
            Exit::CannotStart
        }
    }
}

fn run_of(recording: &RecordingFile, file: &Path) -> Run {
    let interventions = recording.interventions().into_iter();
    Run {
        setting: recording.setting.clone(),
        moments: recording.moments(true),
        interventions: interventions.map(|(time_s, robot, reason)| Intervention { time_s, robot, reason }).collect(),
        summary: recording.summary.clone(),
        title: file.display().to_string(),
    }
}

fn draw(run: &Run, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let (bar, _) = meter::share("drawing");
    let drawn = pictures(run);
    bar.finish_and_clear();
    for picture in drawn? {
        for (extension, bytes) in [("svg", picture.svg.as_bytes()), ("png", &picture.png[..])] {
            let path = folder.join(picture.name).with_extension(extension);
            std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
            println!("{}", path.display());
        }
    }
    Ok(())
}
