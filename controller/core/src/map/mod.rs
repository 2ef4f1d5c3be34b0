//! What is known of a place: cells that are unknown, free or occupied, ways on them, what is seen from them.
//!
//! | file | what |
//! |---|---|
//! | [`board`] | cells with frontier flags that are kept as cells are learnt |
//! | [`field`] | steps from a cell to all others; who is nearest to each |
//! | [`sight`] | what a robot on a cell sees |

mod board;
mod field;
mod lattice;
mod ledger;
mod sight;
mod tiles;

pub use board::{Board, Known};
pub use field::{Field, Owners, Unknowns};
pub use lattice::Lattice;
pub use ledger::{Change, Ledger, WRITERS_MAX};
pub use sight::Sight;
