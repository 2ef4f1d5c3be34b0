//! The one-step safe set: the last layer under every law that moves points, whatever the law asks for.
//!
//! A robot at `x` that has one period to move may choose any end `p` of a straight move for which
//!
//! - **C** (connected): `p` lies in a disc for every link that is kept. With the disc of diameter `r_c` about the
//!   middle of both ends (Ando et al. 1999), or any disc of that size on which both agreed, the two ends stay within
//!   `r_c`.
//! - **R** (robots): `p` lies in the own half of the gap to every other robot, less half of the distance `d_s` to keep
//!   (a buffered Voronoi cell).
//! - **O** (obstacles): the whole segment from `x` to `p` keeps `d_o` from every wall, by exact distances between
//!   segments.
//!
//! Staying (`p = x`) is always in the set, so it is never empty. C and R are convex and hold at `x`: they hold at every
//! point of the segment, so in continuous time and whenever within the period each robot sets off. Where a bound is
//! broken already, because a measurement was wrong, the set forbids only that it becomes worse.
//!
//! [`SafeSet`] is the set; [`Steering`] chooses the move in it that the law most likely meant.
//!
//! [`Orca`] is the other way to avoid: among velocities instead of places, each robot taking half of every change, and
//! [`track`] its form for differential drives.
//!
//! **Source**: C: H. Ando, Y. Oasa, I. Suzuki, M. Yamashita, "Distributed memoryless point convergence algorithm for
//! mobile robots with limited visibility", IEEE Trans. Robotics and Automation 15(5), 1999. R: D. Zhou et al., "Fast,
//! on-line collision avoidance for dynamic vehicles using buffered Voronoi cells", IEEE RA-L 2(2), 2017. The
//! combination with a swept O, and the choice by least deviation: ours.

mod capsule;
mod orca;
mod safe_set;
mod steering;

pub use capsule::Capsule;
pub use orca::{Orca, OrcaParams, OrcaPeer, Tracking, track};
pub use safe_set::{Disc, HalfPlane, SafeSet, SafeSetParams};
pub use steering::{Steer, Steering};
