//! A swarm in Foxglove's messages: what recordings hold and what a live Foxglove connection is sent.
//!
//! Frames: `world` (ENU, metres); `robot-N`, where robot N believes to be; `body-N`, where its body truly is, in
//! simulation only, and `mover-N`, where the N-th mover of the place is, from 1. Every time here is `unix_us`,
//! microseconds since the Unix epoch. What draws a place, robots or links is made to be seen: heights and colours mean
//! nothing.

mod frames;
mod message;
mod own;
mod scene;
mod state;
#[cfg(test)]
mod tests;

pub use frames::{WORLD, body_frame, grid, laser_scan, log, mover_frame, robot_frame, scan_moment, topic, transforms};
pub use own::{Beacon, BeaconHeard, Decision, HeardLink, LinkHealth, State, Wire, WireGroup};
pub use scene::{scene_links, scene_place, scene_robots};

use foxglove::messages::{Color, Point3, Pose, Quaternion, Timestamp, Vector3};

/// A time as Foxglove tells it; the greatest that it can tell (in 2106) for later ones.
#[must_use]
pub fn timestamp(unix_us: u64) -> Timestamp {
    let nanos = (unix_us % 1_000_000) as u32 * 1_000;
    u32::try_from(unix_us / 1_000_000).map_or(Timestamp::MAX, |seconds| Timestamp::new(seconds, nanos))
}

fn point([x, y]: [f64; 2], z: f64) -> Point3 {
    Point3 { x, y, z }
}

fn rotation(yaw_rad: f64) -> Quaternion {
    /// Finer than anybody sees, and ends in zeros: that keeps recordings small.
    const PER_UNIT: f64 = 65_536.0;
    let (z, w) = (yaw_rad / 2.0).sin_cos();
    let [z, w] = [z, w].map(|part| (part * PER_UNIT).round() / PER_UNIT);
    Quaternion { x: 0.0, y: 0.0, z, w }
}

fn pose([x, y]: [f64; 2], z: f64, yaw_rad: f64) -> Pose {
    Pose { position: Some(Vector3 { x, y, z }), orientation: Some(rotation(yaw_rad)) }
}

fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}
