//! `drover export RUN.mcap`: what a recording holds, in the formats of other tools.

use crate::command::open_recording;
use crate::exit::Exit;
use crate::meter;
use anyhow::Context;
use drover_record::RecordingFile;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Arguments of `drover export`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The recording
    file: PathBuf,
    /// Folder to write to; beside the recording unless given
    #[arg(long, value_name = "FOLDER")]
    to: Option<PathBuf>,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let recording = match open_recording(&arguments.file) {
        Ok(recording) => recording,
        Err(exit) => return exit,
    };
    let beside = || arguments.file.with_extension("export");
    match export(&recording, &arguments.to.clone().unwrap_or_else(beside)) {
        Ok(()) => Exit::Reached,
        Err(error) => {
            eprintln!("{error:#}");
            Exit::CannotStart
        }
    }
}

fn export(recording: &RecordingFile, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let (bar, moved) = meter::share("links' bytes");
    let wire = recording.wire_files(moved);
    bar.finish_and_clear();
    let left_out = wire.left_out();
    let mut files = wire.into_files();
    files.insert("states.csv".into(), states(recording).into_bytes());
    for (name, bytes) in &files {
        let path = folder.join(name);
        std::fs::write(&path, bytes).with_context(|| format!("cannot write {}", path.display()))?;
        println!("{}  {} bytes", path.display(), bytes.len());
    }
    if left_out > 0 {
        eprintln!("{left_out} messages are no MAVLink frames and are left out: a tlog cannot carry them");
    }
    Ok(())
}

/// Everybody's way as a table that any spreadsheet reads.
fn states(recording: &RecordingFile) -> String {
    let mut text = String::from(
        "time_s,robot,x_m,y_m,yaw_rad,speed_mps,yaw_rate_radps,in_contact,believed_x_m,believed_y_m,state,reason\n",
    );
    for moment in recording.moments(false) {
        for robot in &moment.robots {
            let Some(place) = robot.place() else { continue };
            let truth = robot.truth.as_ref();
            let [speed_mps, yaw_rate_radps] = truth.map_or(robot.twist_b, |truth| truth.twist_b);
            let in_contact = truth.map_or(0, |truth| u8::from(truth.in_contact));
            let believed = robot.believed.unwrap_or(place);
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{:.6},{},{:.6},{:.6},{:.6},{speed_mps:.6},{yaw_rate_radps:.6},{in_contact},{:.6},{:.6},{},\"{}\"",
                moment.time_s,
                robot.id,
                place.x_m,
                place.y_m,
                place.yaw_rad,
                believed.x_m,
                believed.y_m,
                robot.state,
                robot.reason.replace('"', "\"\"")
            );
        }
    }
    text
}
