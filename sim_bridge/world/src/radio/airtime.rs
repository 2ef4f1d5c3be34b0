//! The time that messages take on a channel that all share.
//!
//! Each receiver hears one message at a time; the next one waits until the air around it is free, or is lost if that
//! takes too long. Carrier sense is simplified to this: a message waits for each of its receivers on its own, so it may
//! begin at one before it begins at another; two senders that do not hear each other (hidden nodes) take turns at a
//! receiver between them as if they did, where a real channel would lose both to a collision; and a robot can hear
//! while it sends.

use drover_config::Airtime;
use drover_contract::Stamp;
use std::time::Duration;

/// Until when the air around each robot is taken.
#[derive(Clone, Debug)]
pub(super) struct Air {
    message: Duration,
    wait_max: Duration,
    busy_until: Vec<Stamp>,
}

impl Air {
    /// Free air around `robots` robots.
    pub(super) fn new(rule: &Airtime, robots: usize) -> Self {
        let span = |ms: f64| Duration::from_micros((ms.max(0.0) * 1e3) as u64);
        Self { message: span(rule.message_ms), wait_max: span(rule.wait_ms_max), busy_until: vec![Stamp::ZERO; robots] }
    }

    /// Put a message on the air around `to`; when its last bit is there. `None`: it would have to wait too long.
    pub(super) fn take(&mut self, now: Stamp, to: u32) -> Option<Stamp> {
        let busy_until = &mut self.busy_until[to as usize];
        let begin = now.max(*busy_until);
        if begin.since(now) > self.wait_max {
            return None;
        }
        *busy_until = begin + self.message;
        Some(*busy_until)
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.busy_until.capacity() * size_of::<Stamp>()
    }
}
