//! The words that both sides of the firmware interface use.
//!
//! Pure values and small traits; no sockets, no clock, no chance. SI units, world frame ENU (x east, y north), body
//! frame FLU (x forward, y left), angles in (-pi, pi], counter-clockwise positive. Wire units never come this far.

mod beacon;
mod can;
mod command;
mod event;
mod frame;
mod id;
mod link;
mod links;
mod map;
pub mod math;
mod scan;
mod stamp;

pub use beacon::{Beacon, BehaviourState};
pub use can::{CanFrame, CanFrameError, CanId};
pub use command::{Limits, NotFinite, SafeCommand};
pub use event::{Battery, DriveState, Event, Odometry, PoseFix, Severity, Watchdog, WheelTravel};
pub use frame::{Pose, Twist, Vec2, wrap};
pub use id::{CanNode, MavId, RobotId};
pub use link::{BusHealth, CanBus, Clock, Link, LinkError};
pub use links::{
    Departure, EDGES_TOLD_MAX, LINKS_TOLD_MAX, LinkEdge, LinkEntry, LinkReport, RootOffer, WEIGHT_M_MAX, on_grid_m,
};
pub use map::{CHANGES_BYTES_MAX, HEADS_TOLD_MAX, MapChunk, MapHead, MapReport, Writer};
pub use scan::{Beam, Scan};
pub use stamp::Stamp;
