//! Where the body goes if a command is given for one tick and then the brakes are applied.
//!
//! ```text
//!   now        + latency        + tick                        still
//!    |  before    |   candidate   |   stop: brake and unwind    |
//! ```
//!
//! The command before still acts during the latency (measuring, link and drive), then the candidate for one tick, then
//! STOP. Speeds change no faster than the limits say. A candidate whose whole course keeps clear can be given now, for
//! there is always the next tick to stop in: the stopping-distance rule v^2 / 2b + v t, along the course really driven.

use crate::limit::{approach, step};
use drover_contract::{Limits, Pose, Twist, Vec2};

/// Measured speeds below this are standing still: the noise of a drive must not lock a robot.
pub(super) const STILL_MPS: f64 = 0.02;
/// Step of the course, seconds.
const STEP_S: f64 = 0.05;
/// No course takes more steps: 20 s.
const STEPS_MAX: usize = 400;

/// Where a course begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Start {
    /// The measured velocity.
    pub(super) is_b: Twist,
    /// The command before, still on its way to the wheels.
    pub(super) before_b: Twist,
}

/// How long the phases last, and how fast speeds change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace<'a> {
    pub(super) latency_s: f64,
    pub(super) tick_s: f64,
    pub(super) limits: &'a Limits,
}

/// The centre's course while the command before still acts, in the body frame of now, the present place not included.
/// It is the same whatever is commanded next: where it ends, courses go on.
pub(super) fn latency_course(start: Start, pace: &Pace<'_>, out: &mut Vec<Vec2>) -> State {
    out.clear();
    let mut state = State { pose: Pose::default(), twist_b: still(start.is_b) };
    state.phase(start.before_b, pace.latency_s, pace.limits, out);
    state
}

/// The course from there on if `candidate_b` is given for one tick and the brakes are applied then.
pub(super) fn course(mut state: State, candidate_b: Twist, pace: &Pace<'_>, out: &mut Vec<Vec2>) {
    out.clear();
    state.phase(candidate_b, pace.tick_s, pace.limits, out);
    while state.twist_b.speed_mps.abs() > 1e-6 && out.len() < STEPS_MAX {
        state.phase(Twist::ZERO, STEP_S, pace.limits, out);
    }
}

/// The measured velocity, with what is no more than a drive's noise taken for standing.
pub(super) fn still(is_b: Twist) -> Twist {
    let speed_mps = if is_b.speed_mps.abs() < STILL_MPS { 0.0 } else { is_b.speed_mps };
    Twist { speed_mps, ..is_b }
}

/// Where a course has come to.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pose: Pose,
    twist_b: Twist,
}

impl State {
    fn phase(&mut self, target_b: Twist, span_s: f64, limits: &Limits, out: &mut Vec<Vec2>) {
        // Rounded up by hand, which needs no call.
        let whole = (span_s / STEP_S) as usize;
        let steps = (whole + usize::from(span_s / STEP_S > whole as f64)).max(1);
        let dt_s = span_s / steps as f64;
        for _ in 0..steps {
            let next = Twist {
                speed_mps: approach(self.twist_b.speed_mps, target_b.speed_mps, limits, dt_s),
                yaw_rate_radps: step(
                    self.twist_b.yaw_rate_radps,
                    target_b.yaw_rate_radps,
                    limits.yaw_accel_radps2_max * dt_s,
                ),
            };
            let mean = Twist {
                speed_mps: f64::midpoint(self.twist_b.speed_mps, next.speed_mps),
                yaw_rate_radps: f64::midpoint(self.twist_b.yaw_rate_radps, next.yaw_rate_radps),
            };
            self.pose = self.pose.advance(mean, dt_s);
            self.twist_b = next;
            out.push(self.pose.position());
        }
    }
}
