//! What is the case this tick, and the first reason among it not to move.

use super::Reason;
use drover_config::Timeouts;
use drover_contract::{DriveState, Twist};
use std::time::Duration;

/// More than this share of beams without a reading is blindness.
const UNKNOWN_SHARE_MAX: f64 = 0.5;

/// The drive's state, without its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DriveFact {
    Silent,
    BringUp(&'static str),
    Refused,
    Ready,
}

impl From<&DriveState> for DriveFact {
    fn from(state: &DriveState) -> Self {
        match state {
            DriveState::Silent => Self::Silent,
            DriveState::BringUp(step) => Self::BringUp(step),
            DriveState::Refused(_) => Self::Refused,
            DriveState::Ready(_) => Self::Ready,
        }
    }
}

/// Something that ages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Freshness {
    /// Never heard.
    Absent,
    /// Heard, too long ago.
    Old,
    /// Heard in time.
    Fresh,
}

impl Freshness {
    pub(crate) fn of(age: Option<Duration>, timeout_ms: u32) -> Self {
        match age {
            None => Self::Absent,
            Some(age) if age > Duration::from_millis(u64::from(timeout_ms)) => Self::Old,
            Some(_) => Self::Fresh,
        }
    }
}

/// What the law asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RequestFact {
    /// A motion (or standing still).
    Finite,
    /// Something that is not a number.
    NotFinite,
    /// Nothing: why.
    Missing(&'static str),
}

impl RequestFact {
    pub(crate) fn of(request: Result<Twist, &'static str>) -> Self {
        match request {
            Ok(twist) if twist.is_finite() => Self::Finite,
            Ok(_) => Self::NotFinite,
            Err(why) => Self::Missing(why),
        }
    }
}

/// The ages of everything that must be fresh; `None` is "never".
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ages {
    pub(crate) scan: Option<Duration>,
    pub(crate) odometry: Option<Duration>,
    /// Of the pose fix; dead reckoning is as old as its odometry.
    pub(crate) pose: Option<Duration>,
}

/// The facts of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conditions {
    pub(crate) drive: DriveFact,
    pub(crate) scan: Freshness,
    pub(crate) blind: bool,
    pub(crate) odometry: Freshness,
    pub(crate) pose: Freshness,
    pub(crate) late: bool,
    pub(crate) request: RequestFact,
}

impl Conditions {
    /// The facts that come before a law is asked; the request is still missing.
    pub(crate) fn sensed(drive: &DriveState, ages: Ages, unknown_share: f64, timeouts: &Timeouts) -> Self {
        Self {
            drive: drive.into(),
            scan: Freshness::of(ages.scan, timeouts.scan_ms),
            blind: unknown_share > UNKNOWN_SHARE_MAX,
            odometry: Freshness::of(ages.odometry, timeouts.odometry_ms),
            pose: Freshness::of(ages.pose, timeouts.odometry_ms),
            late: false,
            request: RequestFact::Missing("no law was asked"),
        }
    }

    /// Why the robot is not ready at all: the drive first, then what was never heard.
    pub(crate) fn unready(&self) -> Option<Reason> {
        match self.drive {
            DriveFact::Silent => return Some(Reason::DriveSilent),
            DriveFact::BringUp(step) => return Some(Reason::DriveBringUp(step)),
            DriveFact::Refused => return Some(Reason::DriveRefused),
            DriveFact::Ready => {}
        }
        let absent = |fact: Freshness, reason: Reason| (fact == Freshness::Absent).then_some(reason);
        absent(self.odometry, Reason::NoOdometry)
            .or(absent(self.pose, Reason::NoPose))
            .or(absent(self.scan, Reason::NoScan))
    }

    /// Why a sensor or the pulse forbids motion this tick.
    pub(crate) fn impaired(&self) -> Option<Reason> {
        let old = |fact: Freshness, reason: Reason| (fact == Freshness::Old).then_some(reason);
        old(self.odometry, Reason::OdometryOld)
            .or(old(self.pose, Reason::PoseOld))
            .or(old(self.scan, Reason::ScanOld))
            .or(self.blind.then_some(Reason::ScanBlind))
            .or(self.late.then_some(Reason::LateTick))
    }

    /// Why the law's request cannot be followed this tick.
    pub(crate) fn unasked(&self) -> Option<Reason> {
        match self.request {
            RequestFact::Finite => None,
            RequestFact::NotFinite => Some(Reason::RequestNotFinite),
            RequestFact::Missing(why) => Some(Reason::Law(why)),
        }
    }

    /// Whether a law may be asked: nothing forbids motion but the law itself.
    pub(crate) fn fit(&self) -> bool {
        self.unready().is_none() && self.impaired().is_none()
    }
}
