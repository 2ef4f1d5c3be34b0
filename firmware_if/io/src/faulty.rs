//! A middleman that loses messages, for tests: around a [`Link`] or a [`CanBus`].

use drover_contract::{BusHealth, CanBus, CanFrame, Link, LinkError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};

/// A link that does what its [`FaultHandle`] says. What is lost is lost silently, as on a cable that was pulled:
/// nothing is kept for later, and no error is given.
pub struct Faulty<L> {
    inner: L,
    faults: Arc<Mutex<Faults>>,
}

/// Breaks and mends a [`Faulty`] link, from anywhere. Clones are the same handle.
#[derive(Clone)]
pub struct FaultHandle {
    faults: Arc<Mutex<Faults>>,
}

struct Faults {
    cut: bool,
    drop_share: f64,
    chance: u64,
    lost: u64,
}

impl Faults {
    /// Whether the next message is lost.
    fn lose(&mut self) -> bool {
        let lost = self.cut || self.next_share() < self.drop_share;
        self.lost += u64::from(lost);
        lost
    }

    /// The next of a seeded sequence, 0..1 (splitmix64, of Steele, Lea and Flood: "Fast splittable pseudorandom number
    /// generators", OOPSLA 2014).
    fn next_share(&mut self) -> f64 {
        self.chance = self.chance.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.chance;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn lock(faults: &Mutex<Faults>) -> MutexGuard<'_, Faults> {
    faults.lock().unwrap_or_else(PoisonError::into_inner)
}

impl FaultHandle {
    /// From now on nothing passes, in either direction.
    pub fn cut(&self) {
        lock(&self.faults).cut = true;
    }

    /// Messages pass again. What was sent meanwhile stays lost.
    pub fn restore(&self) {
        lock(&self.faults).cut = false;
    }

    /// From now on lose this share of the messages, 0..=1, each on its own, in both directions.
    pub fn set_drop_share(&self, share: f64) {
        lock(&self.faults).drop_share = share;
    }

    /// How many messages were lost so far.
    #[must_use]
    pub fn lost(&self) -> u64 {
        lock(&self.faults).lost
    }
}

impl<L> Faulty<L> {
    /// A middleman around `inner` that passes everything until its handle says otherwise; `seed` decides which messages
    /// are lost when a share of them is.
    #[must_use]
    pub fn new(inner: L, seed: u64) -> (Self, FaultHandle) {
        let faults = Arc::new(Mutex::new(Faults { cut: false, drop_share: 0.0, chance: seed, lost: 0 }));
        (Self { inner, faults: Arc::clone(&faults) }, FaultHandle { faults })
    }

    fn lose(&self) -> bool {
        lock(&self.faults).lose()
    }
}

impl<L: Link> Link for Faulty<L> {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        while let Some(len) = self.inner.try_recv(buf)? {
            if !self.lose() {
                return Ok(Some(len));
            }
        }
        Ok(None)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        if self.lose() { Ok(()) } else { self.inner.send(bytes) }
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }
}

impl<B: CanBus> CanBus for Faulty<B> {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        while let Some(frame) = self.inner.try_recv()? {
            if !self.lose() {
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        if self.lose() { Ok(()) } else { self.inner.send(frame) }
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }

    fn health(&self) -> BusHealth {
        self.inner.health()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MemoryBus, memory_link};
    use drover_contract::CanId;

    fn drain(link: &mut impl Link) -> Vec<u8> {
        let mut buf = [0; 8];
        std::iter::from_fn(|| link.try_recv(&mut buf).unwrap().map(|_| buf[0])).collect()
    }

    #[test]
    fn what_crosses_while_a_link_is_cut_never_arrives_even_after_it_is_mended() {
        let (near, mut far) = memory_link(64);
        let (mut near, handle) = Faulty::new(near, 1);
        handle.cut();
        near.send(&[1]).unwrap();
        far.send(&[2]).unwrap();
        assert!(drain(&mut near).is_empty());
        handle.restore();
        near.send(&[3]).unwrap();
        far.send(&[4]).unwrap();
        assert_eq!(drain(&mut far), [3]);
        assert_eq!(drain(&mut near), [4]);
        assert_eq!(handle.lost(), 2);
    }

    #[test]
    fn the_same_seed_loses_the_same_messages_and_about_the_share_that_was_asked_for() {
        let lost_with = |seed| {
            let (near, mut far) = memory_link(2000);
            let (mut near, handle) = Faulty::new(near, seed);
            handle.set_drop_share(0.25);
            (0..1000_u16).for_each(|n| near.send(&[n as u8]).unwrap());
            (drain(&mut far), handle.lost())
        };
        assert_eq!(lost_with(7), lost_with(7));
        assert_ne!(lost_with(7).0, lost_with(8).0);
        // Binomial, 1000 draws of 0.25: standard deviation 13.7.
        assert!(lost_with(7).1.abs_diff(250) < 60, "{} of 1000 lost", lost_with(7).1);
    }

    #[test]
    fn a_cut_bus_carries_no_frame_either_way() {
        let bus = MemoryBus::new(8);
        let (mut node, handle) = Faulty::new(bus.node(), 1);
        let mut other = bus.node();
        let frame = CanFrame::new(CanId::Standard(0x111), &[0; 8]).unwrap();
        handle.cut();
        node.send(&frame).unwrap();
        other.send(&frame).unwrap();
        assert_eq!((node.try_recv(), other.try_recv()), (Ok(None), Ok(None)));
        handle.restore();
        other.send(&frame).unwrap();
        assert_eq!(node.try_recv(), Ok(Some(frame)));
    }
}
