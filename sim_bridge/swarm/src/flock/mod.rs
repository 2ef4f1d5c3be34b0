//! Flocks: the simulated points of the paper, and what any flock is measured by.

mod figures;
mod points;

pub use figures::FlockFigures;
pub(crate) use figures::Flocking;
pub use points::FlockSwarm;
