//! What is known of a place: cells that are unknown, free or occupied, ways on them, what is seen from them, and how
//! several robots come to know it together.
//!
//! | file | what |
//! |---|---|
//! | [`lattice`] | where cells lie in the world |
//! | [`board`] | cells with frontier flags that are kept as cells are learnt |
//! | [`field`] | steps from a cell to all others; who is nearest to each |
//! | [`sight`] | what a robot on a cell sees |
//! | [`shared`] | the map that a team makes: own evidence in log odds, and others' words |
//! | [`ledger`] | everybody's words, numbered, so that maps can be joined in any order |
//! | [`exchange`] | what to tell whom |
//! | [`image`] | the map as files of ROS' map_server |
//! | [`space`] | the map for a body of some size |
//! | [`tiles`] | memory for what is used |

mod board;
mod exchange;
mod field;
mod image;
mod lattice;
mod ledger;
mod shared;
mod sight;
mod space;
mod tiles;

pub use board::{Board, Known};
pub use exchange::Exchange;
pub(crate) use field::steps_from;
pub use field::{Field, Owners, Unknowns};
pub use image::MapImage;
pub use lattice::Lattice;
pub use ledger::{Change, Ledger, WRITERS_MAX};
pub use shared::{Ray, SharedMap};
pub use sight::Sight;
pub use space::Space;
