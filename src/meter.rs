//! Progress of long work: a bar with rate and remaining time on a terminal, nothing in a pipe.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar for `length` units of work.
pub(crate) fn bar(length: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr());
    let form = "[{bar:30}] {percent:>3} %  {msg}  {eta} left";
    let style = ProgressStyle::with_template(form).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.progress_chars("#."));
    bar
}

/// A bar for a share of work, 0..=1, and the function that moves it.
pub(crate) fn share(what: &str) -> (ProgressBar, impl FnMut(f64) + use<>) {
    const STEPS: f64 = 1_000.0;
    let bar = bar(STEPS as u64);
    bar.set_message(what.to_owned());
    let moved = bar.clone();
    (bar, move |share| moved.set_position((share.clamp(0.0, 1.0) * STEPS) as u64))
}
