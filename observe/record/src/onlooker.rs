//! Who looks on.

use crate::moment::Moment;
use crate::setting::{Control, Controls, Setting};

/// Somebody who looks on while a run goes on. Nothing here may block.
pub trait Onlooker: Send {
    /// A run begins, of which this may be asked.
    fn begin(&mut self, setting: Setting, controls: Controls);
    /// This is how it is now; about twenty times a second.
    fn show(&mut self, moment: Moment);
    /// What is asked of it, if anything is.
    fn next_control(&mut self) -> Option<Control>;
    /// Whether anybody sees what is shown.
    fn is_watching(&self) -> bool;
}
