//! The collective potential field, eq. 1-14.
//!
//! "Infinite" forces are priorities, not numbers: where one acts, all finite ones are dropped, and the direction is
//! that of the sum of the infinite ones' unit vectors; if they cancel, the robot stands (the paper: infinity minus
//! infinity, "stands still").

use drover_config::Deploy;
use drover_contract::Vec2;
use std::ops::Add;

/// Infinite forces whose unit vectors add up to less than this cancel.
const CANCEL: f64 = 1e-9;
/// Things nearer than this have no direction, metres.
const TOGETHER_M: f64 = 1e-9;

/// Gains and distances, metres; gains as in the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gains {
    pub(crate) goal: f64,
    pub(crate) link: f64,
    pub(crate) repel: f64,
    /// `d_a`: repulsion acts within it.
    pub(crate) avoid_m: f64,
    /// `d_a^min`: nearer, repulsion is infinite.
    pub(crate) avoid_m_min: f64,
    /// `r_sc`: links longer than this attract.
    pub(crate) calm_m: f64,
    /// `r_c^max`: links longer than this attract infinitely.
    pub(crate) stretched_m: f64,
}

impl Gains {
    pub(crate) fn of(deploy: &Deploy) -> Self {
        // xi of the paper: both ends of a link may move apart by a full step each.
        let both_m = 2.0 * deploy.speed_mps * deploy.period_s;
        let stretched_m = deploy.range_m - both_m;
        Self {
            goal: deploy.goal_gain,
            link: deploy.link_gain,
            repel: deploy.repel_gain,
            avoid_m: both_m + deploy.epsilon_m,
            avoid_m_min: deploy.avoid_m_min,
            calm_m: stretched_m - both_m,
            stretched_m,
        }
    }

    /// `F_goal`.
    pub(crate) fn goal(&self, at_w: Vec2, goal_w: Vec2) -> Force {
        Force::finite((goal_w - at_w) * self.goal)
    }

    /// `F_com` of a link to a peer.
    pub(crate) fn link(&self, at_w: Vec2, peer_w: Vec2) -> Force {
        let to_peer = peer_w - at_w;
        let apart_m = to_peer.norm();
        if apart_m <= self.calm_m {
            Force::NONE
        } else if apart_m <= self.stretched_m {
            Force::finite(to_peer * self.link)
        } else {
            Force::infinite(to_peer / apart_m)
        }
    }

    /// The same force along the way to the peer, which begins towards `via_w`.
    pub(crate) fn link_via(&self, at_w: Vec2, peer_w: Vec2, via_w: Vec2) -> Force {
        let straight = self.link(at_w, peer_w);
        match (via_w - at_w).try_normalize(TOGETHER_M) {
            Some(unit) if straight.is_infinite => Force::infinite(unit),
            Some(unit) => Force::finite(unit * straight.finite.norm()),
            None => straight,
        }
    }

    /// `F_rep` of a robot or of the nearest place of an obstacle.
    pub(crate) fn repel(&self, at_w: Vec2, entity_w: Vec2) -> Force {
        let away = at_w - entity_w;
        let apart_m = away.norm();
        if apart_m >= self.avoid_m || apart_m < TOGETHER_M {
            return Force::NONE;
        }
        let unit = away / apart_m;
        if apart_m < self.avoid_m_min {
            return Force::infinite(unit);
        }
        Force::finite(unit * (self.repel * (1.0 / apart_m - 1.0 / self.avoid_m) / (apart_m * apart_m)))
    }
}

/// A force: a finite part, m/s, and infinite ones, as unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Force {
    finite: Vec2,
    infinite: Vec2,
    is_infinite: bool,
}

impl Force {
    pub(crate) const NONE: Self =
        Self { finite: Vec2::new(0.0, 0.0), infinite: Vec2::new(0.0, 0.0), is_infinite: false };

    fn finite(finite: Vec2) -> Self {
        Self { finite, ..Self::NONE }
    }

    fn infinite(unit: Vec2) -> Self {
        Self { infinite: unit, is_infinite: true, ..Self::NONE }
    }

    /// Its direction, a unit vector; none where it vanishes.
    pub(crate) fn direction(&self) -> Option<Vec2> {
        let acting = if self.is_infinite { self.infinite } else { self.finite };
        acting.try_normalize(CANCEL)
    }

    /// Step 6: the displacement of one period, at most `step_m` long, metres.
    pub(crate) fn step(&self, period_s: f64, step_m: f64) -> Vec2 {
        let Some(direction) = self.direction() else { return Vec2::zeros() };
        direction * if self.is_infinite { step_m } else { step_m.min(self.finite.norm() * period_s) }
    }
}

impl Add for Force {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            finite: self.finite + other.finite,
            infinite: self.infinite + other.infinite,
            is_infinite: self.is_infinite || other.is_infinite,
        }
    }
}

impl std::iter::Sum for Force {
    fn sum<I: Iterator<Item = Self>>(forces: I) -> Self {
        forces.fold(Self::NONE, Add::add)
    }
}
