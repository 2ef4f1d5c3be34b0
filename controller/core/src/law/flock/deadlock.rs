//! When a robot is in a trap.
//!
//! The paper's robot "stops or oscillates"; its thresholds T1 and T2 are lost with the figure. Read here as: over a
//! window it got on slower than a limit, there is a wall (two returns at least), and wall and attractor pull against
//! each other, (x - o).(attractor - x) < 0.
//!
//! What ships asks another question: is it the walls, and not a peer, that keep the robot from going where it wishes?
//! If they have done so for the whole window, it is in a trap, however much it is being pushed around.

use drover_contract::{Stamp, Vec2};
use std::collections::VecDeque;
use std::time::Duration;

/// After wall following a robot is not in a deadlock again for this long.
const REFRACTORY: Duration = Duration::from_millis(500);
/// Most places that a window remembers: a longer one is looked at more coarsely.
const PLACES_MAX: usize = 32;

/// The paper's test: net displacement over a window.
#[derive(Clone, Debug, Default)]
pub(super) struct Displacement {
    places: VecDeque<(Stamp, Vec2)>,
}

impl Displacement {
    /// Forget everything; the next answer is `None` for a whole window and the refractory time.
    pub(super) fn restart(&mut self) {
        self.places.clear();
    }

    /// Mean speed of the net displacement over `window`, m/s; none before there is a whole one.
    pub(super) fn speed_mps(&mut self, now: Stamp, at_w: Vec2, window: Duration) -> Option<f64> {
        let every = window / (PLACES_MAX as u32 - 1);
        if self.places.back().is_none_or(|(stamp, _)| now.since(*stamp) >= every) {
            self.places.push_back((now, at_w));
        }
        while self.places.len() > 1 && now.since(self.places[1].0) >= window {
            self.places.pop_front();
        }
        let (since, from_w) = *self.places.front()?;
        let span = now.since(since);
        (span >= window).then(|| (at_w - from_w).norm() / span.as_secs_f64())
    }
}

/// What ships: for how long walls have kept the robot from its wish.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blocked {
    since: Option<Stamp>,
    quiet_until: Option<Stamp>,
}

impl Blocked {
    /// Whether walls have been in the way for all of `window`; `now_so`: whether they are now.
    pub(super) fn lasts(&mut self, now: Stamp, now_so: bool, window: Duration) -> bool {
        self.since = now_so.then(|| self.since.unwrap_or(now));
        let quiet = self.quiet_until.is_some_and(|until| now < until);
        !quiet && self.since.is_some_and(|since| now.since(since) >= window)
    }

    /// Wall following has ended.
    pub(super) fn rest(&mut self, now: Stamp) {
        self.since = None;
        self.quiet_until = Some(now + REFRACTORY);
    }
}

/// The same for the paper's robots.
pub(super) fn refractory_over(now: Stamp, left: Option<Stamp>) -> bool {
    left.is_none_or(|left| now.since(left) >= REFRACTORY)
}
