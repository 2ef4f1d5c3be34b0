//! What a loop shows to whoever records it.

use drover_contract::{Scan, Severity, Stamp};
use drover_core::Status;
use drover_io::Tape;

/// Sees what a robot senses and decides. It must answer at once: it is called from within the loop's turn.
pub trait Witness: Send {
    /// A tick has been decided.
    fn decided(&mut self, status: &Status);
    /// A scan has come.
    fn scanned(&mut self, scan: &Scan);
    /// Words for the operator.
    fn said(&mut self, now: Stamp, severity: Severity, words: &str);
}

/// Everything that is recorded of one robot.
pub struct Recording {
    /// What its loop was given and what it sent.
    pub tape: Tape,
    /// What it made of it.
    pub witness: Box<dyn Witness>,
}

impl Recording {
    /// A recording of the bytes alone.
    #[must_use]
    pub fn of_bytes(tape: Tape) -> Self {
        Self { tape, witness: Box::new(Nobody) }
    }
}

/// Looks away.
struct Nobody;

impl Witness for Nobody {
    fn decided(&mut self, _status: &Status) {}
    fn scanned(&mut self, _scan: &Scan) {}
    fn said(&mut self, _now: Stamp, _severity: Severity, _words: &str) {}
}
