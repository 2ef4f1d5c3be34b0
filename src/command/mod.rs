//! One file a subcommand.

#[cfg(feature = "sim")]
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod export;
#[cfg(feature = "view")]
pub(crate) mod plot;
#[cfg(feature = "view")]
pub(crate) mod replay;
#[cfg(feature = "view")]
pub(crate) mod report;
pub(crate) mod run;
#[cfg(feature = "sim")]
pub(crate) mod sim;
pub(crate) mod stop;
#[cfg(feature = "sim")]
pub(crate) mod up;

use crate::exit::Exit;
use drover_config::{Override, Problems};
use drover_record::RecordingFile;
use std::path::Path;

/// Read all `--set KEY=VALUE`, or say what is wrong with every one of them.
pub(crate) fn overrides(set: &[String]) -> Result<Vec<Override>, Exit> {
    let mut good = Vec::new();
    let mut all_good = true;
    for text in set {
        match Override::parse(text) {
            Ok(one) => good.push(one),
            Err(problem) => {
                eprintln!("{problem}");
                all_good = false;
            }
        }
    }
    if all_good { Ok(good) } else { Err(Exit::BadInput) }
}

/// Print every problem of a file.
pub(crate) fn refuse(problems: &Problems) -> Exit {
    eprintln!("{problems}");
    Exit::BadInput
}

/// Read a recording, or say why it cannot be read; one that was not ended in good order is said to be so.
pub(crate) fn open_recording(file: &Path) -> Result<RecordingFile, Exit> {
    let recording = RecordingFile::open(file).map_err(|error| {
        eprintln!("{error}");
        Exit::BadInput
    })?;
    if !recording.complete {
        eprintln!("{}: not ended in good order; what is there is used", file.display());
    }
    Ok(recording)
}

/// Ready when the operator (Ctrl-C) or the system (SIGTERM) asks to end.
pub(crate) async fn asked_to_end() {
    use tokio::signal::unix::{SignalKind, signal};
    let Ok(mut terminate) = signal(SignalKind::terminate()) else {
        // Without the second signal the first still works.
        let _ = tokio::signal::ctrl_c().await;
        return;
    };
    tokio::select! {
        _ = tokio::signal::ctrl_c() => {}
        _ = terminate.recv() => {}
    }
}
