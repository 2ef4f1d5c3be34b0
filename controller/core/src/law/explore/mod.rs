//! Exploration: robots that know nothing of a place map it together (Wu 2008, and what beats it).
//!
//! | file | what |
//! |---|---|
//! | [`view`] | what a robot knows when it decides, and what a method of choosing is |
//! | [`explorer`] | one robot: it keeps a target, and goes to it step by step |
//! | [`value`] | affinity, distance, direction, stimulation (eq. 9 to 14) |
//! | [`immune`] | the paper, INEA (eq. 15), and the basic immune network that it compares with |
//! | [`network`] | the immune network itself (eq. 4, 6 to 8) |
//! | [`classic`] | nearest, greedy, Burgard, Hungarian, MinPos, market |
//! | [`sweep`] | what ships |
//! | [`meeting`] | where and when those meet who hear each other only from near |
//! | [`parts`] | parts of a place for those who cannot talk while they work |
//! | [`surveyor`] | a real robot: evidence, space, ways, peers |
//! | [`way`], [`mates`] | its way over the space of its body; its peers |

mod classic;
mod explorer;
mod immune;
mod mates;
mod meeting;
mod network;
mod parts;
mod surveyor;
mod sweep;
mod value;
mod view;
mod way;

pub use explorer::{Explorer, Move};
pub use immune::population;
pub use meeting::{Gathering, Meetings};
pub use network::mean_concentrations;
pub use parts::{parts, sectors};
pub(crate) use surveyor::Surveyor;
pub use view::{Mate, View};
