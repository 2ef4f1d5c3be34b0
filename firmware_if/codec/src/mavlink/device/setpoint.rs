//! SET_POSITION_TARGET_LOCAL_NED (84) as ArduPilot Rover 4.7 understands it: measured against its own simulator.

use crate::mavlink::ned;
use crate::mavlink::raw::Raw;
use drover_contract::math::atan2;
use drover_contract::{Pose, Twist, Vec2, wrap};

/// The frames that are taken; BODY_FRD (12) and LOCAL_FRD (20) are silently ignored.
const LOCAL_NED: u8 = 1;
const LOCAL_OFFSET_NED: u8 = 7;
const BODY_NED: u8 = 8;
const BODY_OFFSET_NED: u8 = 9;

/// One bit of a group is enough to ignore the whole group.
const IGNORE_POSITION: u16 = 0x003;
const IGNORE_VELOCITY: u16 = 0x018;
const IGNORE_ACCELERATION: u16 = 0x0C0;
const IGNORE_YAW: u16 = 0x400;
const IGNORE_YAW_RATE: u16 = 0x800;

/// The message as it came, units and frames of the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// POSITION_TARGET_TYPEMASK: what to ignore.
    pub type_mask: u16,
    /// MAV_FRAME.
    pub frame: u8,
    /// North and east (or forward and right), metres.
    pub position_m: [f32; 2],
    /// North and east (or forward and right), m/s.
    pub velocity_mps: [f32; 2],
    /// Heading, radians clockwise.
    pub yaw_rad: f32,
    /// Turn, rad/s clockwise.
    pub yaw_rate_radps: f32,
}

/// What a setpoint asks of a rover, in our frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    /// Drive and turn like this.
    Twist(Twist),
    /// Turn to this heading in the world and drive along it.
    Course {
        /// Heading in the world, radians.
        yaw_rad: f64,
        /// Along it, m/s.
        speed_mps: f64,
    },
    /// Drive to this point of the world; it never times out.
    Point(Vec2),
    /// Acceleration was not ignored: refused, with a text.
    AccelerationUsed,
    /// Nothing that a rover takes.
    Ignored,
}

impl Setpoint {
    pub(super) fn read(raw: Raw<'_>) -> Self {
        Self {
            type_mask: raw.u16(48),
            frame: raw.u8(52),
            position_m: [raw.f32(4), raw.f32(8)],
            velocity_mps: [raw.f32(16), raw.f32(20)],
            yaw_rad: raw.f32(40),
            yaw_rate_radps: raw.f32(44),
        }
    }

    /// What is asked of a rover that stands at `pose_wb`. A number that is not finite asks it to stand still (a real
    /// autopilot ends itself over it).
    #[must_use]
    pub fn demand(&self, pose_wb: &Pose) -> Demand {
        if !matches!(self.frame, LOCAL_NED | LOCAL_OFFSET_NED | BODY_NED | BODY_OFFSET_NED) {
            return Demand::Ignored;
        }
        let used = |group: u16| self.type_mask & group == 0;
        if used(IGNORE_ACCELERATION) {
            return Demand::AccelerationUsed;
        }
        let groups = (used(IGNORE_VELOCITY), used(IGNORE_YAW), used(IGNORE_YAW_RATE));
        let demand = match groups {
            _ if used(IGNORE_POSITION) => self.point(pose_wb),
            (true, false, true) => Demand::Twist(Twist::new(self.speed_mps(), self.turn_radps())),
            (true, false, false) => self.course(pose_wb),
            (true, true, false) => Demand::Course { yaw_rad: self.heading(pose_wb), speed_mps: self.speed_mps() },
            (false, false, true) => Demand::Twist(Twist::new(0.0, self.turn_radps())),
            (false, true, false) => Demand::Course { yaw_rad: self.heading(pose_wb), speed_mps: 0.0 },
            (_, true, true) | (false, false, false) => Demand::Ignored,
        };
        if demand.is_finite() { demand } else { Demand::Twist(Twist::ZERO) }
    }

    /// `sign(vx) * |v|` in every frame: sideways counts as forward.
    fn speed_mps(&self) -> f64 {
        let [forward, right] = self.velocity_mps.map(f64::from);
        let speed = Vec2::new(forward, right).norm();
        if forward < 0.0 { -speed } else { speed }
    }

    fn turn_radps(&self) -> f64 {
        0.0 - f64::from(self.yaw_rate_radps)
    }

    fn in_body(&self) -> bool {
        matches!(self.frame, BODY_NED | BODY_OFFSET_NED)
    }

    fn heading(&self, pose_wb: &Pose) -> f64 {
        let yaw_rad = f64::from(self.yaw_rad);
        if self.in_body() { wrap(pose_wb.yaw_rad - yaw_rad) } else { ned::flip_heading(yaw_rad) }
    }

    fn course(&self, pose_wb: &Pose) -> Demand {
        let [ahead, right] = self.velocity_mps.map(f64::from);
        let clockwise = atan2(right, ahead);
        let yaw_rad = if self.in_body() { wrap(pose_wb.yaw_rad - clockwise) } else { ned::flip_heading(clockwise) };
        Demand::Course { yaw_rad, speed_mps: Vec2::new(ahead, right).norm() }
    }

    fn point(&self, pose_wb: &Pose) -> Demand {
        let [north, east] = self.position_m.map(f64::from);
        Demand::Point(match self.frame {
            LOCAL_NED => Vec2::new(east, north),
            LOCAL_OFFSET_NED => pose_wb.position() + Vec2::new(east, north),
            _ => pose_wb.transform(Vec2::new(north, -east)),
        })
    }
}

impl Demand {
    fn is_finite(&self) -> bool {
        match self {
            Self::Twist(twist) => twist.is_finite(),
            Self::Course { yaw_rad, speed_mps } => yaw_rad.is_finite() && speed_mps.is_finite(),
            Self::Point(point) => point.x.is_finite() && point.y.is_finite(),
            Self::AccelerationUsed | Self::Ignored => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn setpoint(type_mask: u16, frame: u8, velocity_mps: [f32; 2], yaw_rate_radps: f32) -> Setpoint {
        Setpoint { type_mask, frame, position_m: [0.0; 2], velocity_mps, yaw_rad: 0.0, yaw_rate_radps }
    }

    fn twist(demand: Demand) -> Twist {
        match demand {
            Demand::Twist(twist) => twist,
            other => panic!("{other:?} is no twist"),
        }
    }

    #[test]
    fn the_skid_steer_mask_means_the_same_in_all_four_frames_and_with_neighbouring_masks() {
        for frame in [1, 7, 8, 9] {
            for mask in [1479, 1511, 1475, 1415] {
                let got = twist(setpoint(mask, frame, [1.0, 0.0], 0.5).demand(&Pose::default()));
                assert_eq!(got, Twist::new(1.0, -0.5), "mask {mask} in frame {frame}");
            }
        }
    }

    #[test]
    fn the_frames_that_the_autopilot_ignores_are_ignored() {
        for frame in [0, 2, 12, 20, 255] {
            assert_eq!(setpoint(1479, frame, [1.0, 0.0], 0.5).demand(&Pose::default()), Demand::Ignored);
        }
    }

    #[test]
    fn sideways_velocity_counts_as_forward_and_the_sign_comes_from_ahead() {
        let speed = |velocity| twist(setpoint(1479, 8, velocity, 0.0).demand(&Pose::default())).speed_mps;
        assert!((speed([0.0, 1.0]) - 1.0).abs() < 1e-12);
        assert!((speed([-1.0, 1.0]) + 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn acceleration_in_use_is_refused_and_yaw_with_yaw_rate_is_ignored() {
        for mask in [0, 1031, 1543] {
            assert_eq!(setpoint(mask, 8, [1.0, 0.0], 0.0).demand(&Pose::default()), Demand::AccelerationUsed);
        }
        assert_eq!(setpoint(455, 8, [1.0, 0.0], 0.0).demand(&Pose::default()), Demand::Ignored);
    }

    #[test]
    fn not_a_number_asks_to_stand_still() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(twist(setpoint(1479, 8, [bad, 0.0], 0.0).demand(&Pose::default())), Twist::ZERO);
            assert_eq!(twist(setpoint(1479, 8, [1.0, 0.0], bad).demand(&Pose::default())), Twist::ZERO);
        }
    }

    #[test]
    fn a_velocity_over_ground_is_a_course() {
        let demand = setpoint(3527, 1, [0.0, 2.0], 0.0).demand(&Pose::default());
        let Demand::Course { yaw_rad, speed_mps } = demand else { panic!("{demand:?}") };
        assert!(yaw_rad.abs() < 1e-12, "east");
        assert!((speed_mps - 2.0).abs() < 1e-12);
        let north = setpoint(3527, 1, [2.0, 0.0], 0.0).demand(&Pose::default());
        let Demand::Course { yaw_rad, .. } = north else { panic!("{north:?}") };
        assert!((yaw_rad - FRAC_PI_2).abs() < 1e-12);
    }
}
