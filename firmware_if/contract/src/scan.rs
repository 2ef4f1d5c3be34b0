//! What a lidar saw.

use crate::{Stamp, Vec2};

/// One beam of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beam {
    /// Something at this range, metres.
    Hit(f64),
    /// Nothing up to the sensor's greatest range.
    Clear,
    /// No reading: dropped out, blinded, never received. It is not "free".
    Unknown,
}

/// A full turn (or part of one) of range readings around the body's origin, in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// When the oldest of it was received.
    pub stamp: Stamp,
    /// Direction of the first beam's centre, radians, body frame.
    pub angle_first_rad: f64,
    /// From one beam to the next, radians; positive is counter-clockwise.
    pub angle_step_rad: f64,
    /// Nearer than this the sensor cannot measure, metres.
    pub range_m_min: f64,
    /// Farther than this the sensor cannot measure, metres.
    pub range_m_max: f64,
    /// The readings, first beam first.
    pub beams: Vec<Beam>,
}

impl Scan {
    /// Direction of beam `index`, radians in the body frame, not wrapped.
    #[must_use]
    pub fn angle_rad(&self, index: usize) -> f64 {
        self.angle_first_rad + self.angle_step_rad * index as f64
    }

    /// The hits as points in the body frame, with the index of their beam.
    pub fn points_b(&self) -> impl Iterator<Item = (usize, Vec2)> + '_ {
        self.beams.iter().enumerate().filter_map(|(index, beam)| match beam {
            Beam::Hit(range_m) => {
                let (sin, cos) = crate::math::sin_cos(self.angle_rad(index));
                Some((index, Vec2::new(range_m * cos, range_m * sin)))
            }
            Beam::Clear | Beam::Unknown => None,
        })
    }

    /// The nearest hit, metres from the body's origin.
    #[must_use]
    pub fn nearest_m(&self) -> Option<f64> {
        let hits = self.beams.iter().filter_map(|beam| match beam {
            Beam::Hit(range_m) => Some(*range_m),
            Beam::Clear | Beam::Unknown => None,
        });
        hits.min_by(f64::total_cmp)
    }

    /// The share of beams without a reading, 0..=1; 1 for a scan without beams.
    #[must_use]
    pub fn unknown_share(&self) -> f64 {
        if self.beams.is_empty() {
            return 1.0;
        }
        let unknown = self.beams.iter().filter(|beam| **beam == Beam::Unknown).count();
        unknown as f64 / self.beams.len() as f64
    }
}
