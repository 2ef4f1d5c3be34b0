//! One file a subcommand.

#[cfg(feature = "sim")]
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod run;
pub(crate) mod stop;
#[cfg(feature = "sim")]
pub(crate) mod up;

use crate::exit::Exit;
use drover_config::{Override, Problem, Problems};

/// Read all `--set KEY=VALUE`, or say what is wrong with every one of them.
pub(crate) fn overrides(set: &[String]) -> Result<Vec<Override>, Exit> {
    let (good, bad): (Vec<_>, Vec<_>) = set.iter().map(|text| Override::parse(text)).partition(Result::is_ok);
    let bad: Vec<Problem> = bad.into_iter().filter_map(Result::err).collect();
    if !bad.is_empty() {
        bad.iter().for_each(|problem| eprintln!("{problem}"));
        return Err(Exit::BadInput);
    }
    Ok(good.into_iter().filter_map(Result::ok).collect())
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
