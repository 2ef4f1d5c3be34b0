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
