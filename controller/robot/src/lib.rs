//! The run loop of one robot: the same loop in the field, against the simulator, and in virtual time.
//!
//! [`RobotLoop`] is sans-time: somebody calls [`RobotLoop::turn`] and says what time it is. [`drive`] is the shell that
//! calls it in real time, watches it from another thread ([`Guard`]) and stops the robot when it panics or hangs.
//! [`assemble`] puts a loop together from a robot's file and its [`Hardware`].

mod adapter;
mod assemble;
mod guard;
mod map_files;
mod params;
mod report;
mod rerun;
mod robot_loop;
mod shell;
mod stop;
mod witness;

pub use adapter::{Adapter, LinkCounters};
pub use assemble::{Assembled, Assembly, DatagramSender, Hardware, assemble};
pub use drover_core::StopReason;
pub use guard::{Guard, Heart, StopAction};
pub use map_files::MapFiles;
pub use params::epoch_from_unix;
pub use report::{HeardView, Line, Report, ScanView, View};
pub use rerun::rerun;
pub use robot_loop::{LoopParts, RobotLoop};
pub use shell::{Shutdown, Teller, drive};
pub use stop::{StopError, send_stop, stop_message};
pub use witness::{Recording, Witness};
