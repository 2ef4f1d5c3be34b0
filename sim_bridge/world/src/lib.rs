//! The simulated place: geometry, bodies, lidar, virtual firmware, radio. Pure and deterministic.

pub mod firmware;
