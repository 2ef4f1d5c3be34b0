//! Our types and our messages: from one to the other and back.

use super::own::{Beacon, Decision, HeardLink, State};
use crate::{Heard, Place, RobotMoment, Truth};
use drover_contract::{BehaviourState, Pose, RobotId, Stamp, Twist};
use drover_core::Status;
use std::time::Duration;

impl State {
    /// A robot at `time_s` seconds since the run began: all but its scan and whom it hears.
    #[must_use]
    pub fn new(time_s: f64, robot: &RobotMoment) -> Self {
        let truth = robot.truth;
        Self {
            time_s,
            id: robot.id,
            state: robot.state.clone(),
            reason: robot.reason.clone(),
            changed: robot.changed.clone(),
            link: robot.link.clone(),
            x_m: robot.believed.map(|place| place.x_m),
            y_m: robot.believed.map(|place| place.y_m),
            yaw_rad: robot.believed.map(|place| place.yaw_rad),
            pos_bound_m: robot.pos_bound_m,
            true_x_m: truth.map(|truth| truth.place.x_m),
            true_y_m: truth.map(|truth| truth.place.y_m),
            true_yaw_rad: truth.map(|truth| truth.place.yaw_rad),
            true_speed_mps: truth.map(|truth| truth.twist_b[0]),
            true_yaw_rate_radps: truth.map(|truth| truth.twist_b[1]),
            in_contact: truth.map(|truth| truth.in_contact),
            speed_mps: robot.twist_b[0],
            yaw_rate_radps: robot.twist_b[1],
            command_speed_mps: robot.command_b[0],
            command_yaw_rate_radps: robot.command_b[1],
            request_speed_mps: robot.request_b.map(|twist_b| twist_b[0]),
            request_yaw_rate_radps: robot.request_b.map(|twist_b| twist_b[1]),
            target_x_m: robot.target_w.map(|target_w| target_w[0]),
            target_y_m: robot.target_w.map(|target_w| target_w[1]),
            nearest_m: robot.nearest_m,
            scan_age_ms: robot.scan_age_ms,
            link_age_ms: robot.link_age_ms,
            progress: robot.progress,
            reached: robot.reached,
            charge: robot.charge,
        }
    }

    /// The robot that this tells of, without its scan and whom it hears.
    #[must_use]
    pub fn robot(&self) -> RobotMoment {
        let true_place = place(self.true_x_m, self.true_y_m, self.true_yaw_rad);
        let true_twist_b = pair(self.true_speed_mps, self.true_yaw_rate_radps);
        RobotMoment {
            id: self.id,
            state: self.state.clone(),
            reason: self.reason.clone(),
            changed: self.changed.clone(),
            link: self.link.clone(),
            truth: true_place.zip(true_twist_b).map(|(place, twist_b)| Truth {
                place,
                twist_b,
                in_contact: self.in_contact.unwrap_or_default(),
            }),
            believed: place(self.x_m, self.y_m, self.yaw_rad),
            pos_bound_m: self.pos_bound_m,
            twist_b: [self.speed_mps, self.yaw_rate_radps],
            command_b: [self.command_speed_mps, self.command_yaw_rate_radps],
            request_b: pair(self.request_speed_mps, self.request_yaw_rate_radps),
            target_w: pair(self.target_x_m, self.target_y_m),
            nearest_m: self.nearest_m,
            scan_age_ms: self.scan_age_ms,
            link_age_ms: self.link_age_ms,
            progress: self.progress,
            reached: self.reached,
            charge: self.charge,
            heard: Vec::new(),
            scan: None,
        }
    }
}

fn pair(first: Option<f64>, second: Option<f64>) -> Option<[f64; 2]> {
    first.zip(second).map(|(first, second)| [first, second])
}

fn place(x_m: Option<f64>, y_m: Option<f64>, yaw_rad: Option<f64>) -> Option<Place> {
    Some(Place { x_m: x_m?, y_m: y_m?, yaw_rad: yaw_rad? })
}

impl From<&Heard> for HeardLink {
    fn from(heard: &Heard) -> Self {
        Self { id: heard.id, age_ms: heard.age_ms, kept: heard.kept }
    }
}

impl From<&HeardLink> for Heard {
    fn from(link: &HeardLink) -> Self {
        Self { id: link.id, age_ms: link.age_ms, kept: link.kept }
    }
}

impl From<&Status> for Decision {
    fn from(status: &Status) -> Self {
        let command_b = status.command.twist_b();
        Self {
            stamp_us: status.stamp.as_micros(),
            verdict: status.verdict.to_string(),
            request_speed_mps: status.request.map(|request| request.speed_mps),
            request_yaw_rate_radps: status.request.map(|request| request.yaw_rate_radps),
            command_speed_mps: command_b.speed_mps,
            command_yaw_rate_radps: command_b.yaw_rate_radps,
            changed: status.changed.map(Into::into),
            nearest_m: status.nearest_m,
            scan_age_us: status.scan_age.map(micros),
            odometry_age_us: status.odometry_age.map(micros),
            x_m: status.pose_wb.x_m,
            y_m: status.pose_wb.y_m,
            yaw_rad: status.pose_wb.yaw_rad,
            pos_bound_m: status.pos_bound_m,
            progress: status.progress,
            reached: status.reached,
        }
    }
}

fn micros(span: Duration) -> u64 {
    u64::try_from(span.as_micros()).unwrap_or(u64::MAX)
}

impl From<&drover_contract::Beacon> for Beacon {
    fn from(beacon: &drover_contract::Beacon) -> Self {
        Self {
            robot: beacon.robot.0,
            epoch: beacon.epoch,
            seq: beacon.seq,
            sent_us: beacon.sent.as_micros(),
            x_m: beacon.pose_wb.x_m,
            y_m: beacon.pose_wb.y_m,
            yaw_rad: beacon.pose_wb.yaw_rad,
            speed_mps: beacon.twist_b.speed_mps,
            yaw_rate_radps: beacon.twist_b.yaw_rate_radps,
            accel_mps2: beacon.accel_mps2,
            pos_bound_m: beacon.pos_bound_m,
            radius_m: beacon.radius_m,
            state: beacon.state.word().into(),
            progress: beacon.progress,
            leader: beacon.leader.map(|id| id.0),
        }
    }
}

impl Beacon {
    /// The beacon that this tells of; `None` if its state is a word that we do not know.
    #[must_use]
    pub fn beacon(&self) -> Option<drover_contract::Beacon> {
        use BehaviourState::{Active, Done, Held, Stopped, Waiting};
        let state = [Waiting, Active, Held, Done, Stopped].into_iter().find(|state| state.word() == self.state)?;
        Some(drover_contract::Beacon {
            robot: RobotId(self.robot),
            epoch: self.epoch,
            seq: self.seq,
            sent: Stamp::from_micros(self.sent_us),
            pose_wb: Pose { x_m: self.x_m, y_m: self.y_m, yaw_rad: self.yaw_rad },
            twist_b: Twist { speed_mps: self.speed_mps, yaw_rate_radps: self.yaw_rate_radps },
            accel_mps2: self.accel_mps2,
            pos_bound_m: self.pos_bound_m,
            radius_m: self.radius_m,
            state,
            progress: self.progress,
            leader: self.leader.map(RobotId),
        })
    }
}
