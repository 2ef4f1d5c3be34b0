//! Exit codes: what a script may rely on.

/// Shown under `drover --help`; the README repeats it.
pub(crate) const HELP: &str = "\
Exit codes:
  0    done: what was asked for was reached
  1    ran in good order, but not everything was reached (the summary says what and why)
  2    wrong arguments or configuration: nothing was started
  3    could not start: a port in use, an interface missing or down
  4    unsafe: a contact, an aged command, or a robot that was not seen to stop
  130  interrupted; every robot was stopped and seen to stop

DROVER_LOG=info (or debug, or drover_robot=trace) shows what happens, on stderr.";

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Exit {
    /// Done.
    Reached = 0,
    /// Ran in good order without reaching everything.
    NotReached = 1,
    /// Nothing was started: arguments or configuration are wrong. clap uses the same number.
    BadInput = 2,
    /// Something the run needs is missing.
    CannotStart = 3,
    /// What must never happen has happened.
    Unsafe = 4,
    /// Ctrl-C or SIGTERM, obeyed.
    Interrupted = 130,
}
