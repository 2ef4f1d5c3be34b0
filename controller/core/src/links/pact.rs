//! The agreement of two robots on one disc: versions, proposals, answers. No time, no places; `mod.rs` has the proof.
//!
//! ```text
//! owner:  none or held v -> propose w: obeys what it held and w -> answer "hold w": held w
//!                                                               -> answer "w, not held": as before, without w
//! other:  none or held v -> hears w: takes it (held w) or refuses it; once answered, the answer stands
//! ```
//!
//! Versions are serial numbers (they wrap, 0 is none): at most one is open, so those that meet differ by little.

use drover_contract::{LinkEntry, RobotId, Vec2};
use std::cmp::Ordering;

/// One disc that two robots agreed on, or that is proposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pact {
    pub(super) version: u16,
    pub(super) centre_w: Vec2,
    /// The owner's term when its length was last taken.
    pub(super) made: u32,
    /// That length, metres.
    pub(super) weight_m: f64,
}

impl Pact {
    /// Whether a pact may take the place of `old`: newer, or as old and no longer.
    fn may_follow(&self, old: &Self) -> bool {
        match self.made.cmp(&old.made) {
            Ordering::Greater => true,
            Ordering::Equal => self.weight_m <= old.weight_m,
            Ordering::Less => false,
        }
    }
}

/// What came of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    Nothing,
    /// A version is agreed: its link exists.
    Agreed,
    /// A version is refused for good.
    Refused,
    /// The other end keeps nothing any more.
    Ended,
}

/// One end of a link with one other robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The newest version proposed (owner), or taken or refused (other end).
    mark: u16,
    pub(super) held: Option<Pact>,
    /// The owner's, until it is answered.
    pub(super) pending: Option<Pact>,
}

impl Pair {
    pub(super) const fn new() -> Self {
        Self { mark: 0, held: None, pending: None }
    }

    /// Whether anything binds this end.
    pub(super) const fn binds(&self) -> bool {
        self.held.is_some() || self.pending.is_some()
    }

    /// The owner proposes; from now on it stays in this disc too. Nothing may be pending.
    pub(super) fn propose(&mut self, centre_w: Vec2, made: u32, weight_m: f64) {
        debug_assert!(self.pending.is_none(), "one proposal at a time");
        self.mark = if self.mark == u16::MAX { 1 } else { self.mark + 1 };
        self.pending = Some(Pact { version: self.mark, centre_w, made, weight_m });
    }

    /// The owner hears from the other end.
    pub(super) fn hear_answer(&mut self, entry: &LinkEntry) -> Heard {
        let mut heard = Heard::Nothing;
        if let Some(pending) = self.pending {
            if entry.version == pending.version && entry.holds && entry.newest {
                (self.held, self.pending) = (Some(pending), None);
                return Heard::Agreed;
            }
            if entry.version == pending.version || newer(entry.version, pending.version) {
                self.pending = None;
                heard = Heard::Refused;
            }
        }
        if newer(entry.version, self.mark) {
            // We forgot what we once proposed: go on behind it.
            self.mark = entry.version;
        }
        if !entry.holds && self.held.take().is_some() {
            heard = Heard::Ended;
        }
        heard
    }

    /// The other end hears from the owner; `willing` says whether it takes a proposal, given what it holds.
    pub(super) fn hear_owner(
        &mut self,
        entry: &LinkEntry,
        willing: impl FnOnce(&Pact, Option<&Pact>) -> bool,
    ) -> Heard {
        let mut heard = Heard::Nothing;
        let taken = |held: &Pact| entry.proposes && held.version == entry.version;
        if self.held.is_some_and(|held| !entry.holds && !taken(&held)) {
            self.held = None;
            heard = Heard::Ended;
        }
        if entry.proposes && newer(entry.version, self.mark) {
            self.mark = entry.version;
            let LinkEntry { version, centre_w, made, weight_m, .. } = *entry;
            let offered = Pact { version, centre_w, made, weight_m };
            if self.held.is_none_or(|held| offered.may_follow(&held)) && willing(&offered, self.held.as_ref()) {
                self.held = Some(offered);
                heard = Heard::Agreed;
            } else if heard == Heard::Nothing {
                heard = Heard::Refused;
            }
        }
        heard
    }

    /// Ends what is held. The owner may do so only while nothing is pending.
    pub(super) fn end(&mut self) {
        self.held = None;
    }

    /// The other end died or is given up: nothing binds any more. Versions go on.
    pub(super) fn abandon(&mut self) {
        (self.held, self.pending) = (None, None);
    }

    /// The other end, the owner, lives anew: its versions start again.
    pub(super) fn restart(&mut self) {
        *self = Self::new();
    }

    /// What this end tells.
    pub(super) fn entry(&self, peer: RobotId, peer_epoch: u32) -> LinkEntry {
        let shown = self.pending.or(self.held);
        LinkEntry {
            peer,
            peer_epoch: peer_epoch as u16,
            version: self.mark,
            holds: self.held.is_some(),
            newest: self.held.is_some_and(|held| held.version == self.mark),
            proposes: self.pending.is_some(),
            asks: false,
            centre_w: self.pending.map_or_else(Vec2::zeros, |pending| pending.centre_w),
            made: shown.map_or(0, |pact| pact.made),
            weight_m: shown.map_or(0.0, |pact| pact.weight_m),
        }
    }
}

/// Whether version `a` comes after `b`, where 0 comes before all.
fn newer(a: u16, b: u16) -> bool {
    a != 0 && (b == 0 || a.wrapping_sub(b).cast_signed() > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEER: RobotId = RobotId(2);

    fn take(_: &Pact, _: Option<&Pact>) -> bool {
        true
    }

    fn agree(owner: &mut Pair, other: &mut Pair, made: u32) {
        owner.propose(Vec2::zeros(), made, 1.0);
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Agreed);
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Agreed);
    }

    #[test]
    fn the_owner_obeys_both_discs_until_the_other_end_has_answered() {
        let (mut owner, mut other) = (Pair::new(), Pair::new());
        agree(&mut owner, &mut other, 1);
        let before = other.entry(PEER, 1);
        owner.propose(Vec2::new(1.0, 0.0), 1, 1.0);
        assert_eq!(owner.hear_answer(&before), Heard::Nothing, "an answer to an earlier version");
        assert!(owner.held.is_some() && owner.pending.is_some());
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Agreed);
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Agreed);
        assert!(owner.held == other.held && owner.pending.is_none());
    }

    #[test]
    fn what_is_refused_once_is_never_taken_later() {
        let (mut owner, mut other) = (Pair::new(), Pair::new());
        agree(&mut owner, &mut other, 1);
        owner.propose(Vec2::new(1.0, 0.0), 2, 1.0);
        let proposal = owner.entry(PEER, 1);
        assert_eq!(other.hear_owner(&proposal, |_, _| false), Heard::Refused);
        assert_eq!(other.hear_owner(&proposal, take), Heard::Nothing);
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Refused);
        assert!(owner.held == other.held && owner.held.is_some_and(|held| held.version == 1));
    }

    #[test]
    fn a_proposal_binds_its_owner_although_the_other_end_ended_the_link_meanwhile() {
        let (mut owner, mut other) = (Pair::new(), Pair::new());
        agree(&mut owner, &mut other, 1);
        other.end();
        owner.propose(Vec2::zeros(), 2, 1.0);
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Ended);
        assert!(owner.pending.is_some() && owner.held.is_none());
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Agreed, "as a first one");
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Agreed);
    }

    #[test]
    fn an_end_on_either_side_ends_the_other_and_an_older_link_takes_no_newer_ones_place() {
        let (mut owner, mut other) = (Pair::new(), Pair::new());
        agree(&mut owner, &mut other, 5);
        owner.end();
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Ended);
        agree(&mut owner, &mut other, 5);
        other.end();
        assert_eq!(owner.hear_answer(&other.entry(PEER, 1)), Heard::Ended);
        agree(&mut owner, &mut other, 5);
        owner.propose(Vec2::zeros(), 4, 1.0);
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Refused);
        owner.hear_answer(&other.entry(PEER, 1));
        owner.propose(Vec2::zeros(), 5, 1.01);
        assert_eq!(other.hear_owner(&owner.entry(PEER, 1), take), Heard::Refused);
    }

    #[test]
    fn versions_wrap_and_skip_none() {
        let (mut owner, mut other) = (Pair::new(), Pair::new());
        (0..70_000).for_each(|made| agree(&mut owner, &mut other, made));
        assert!(owner.held == other.held && owner.held.is_some_and(|held| u32::from(held.version) == 70_000 - 65_535));
        let mut forgetful = Pair::new();
        forgetful.propose(Vec2::zeros(), 1, 1.0);
        assert_eq!(forgetful.hear_answer(&other.entry(PEER, 1)), Heard::Refused, "it goes on behind what was");
        agree(&mut forgetful, &mut other, 80_000);
    }
}
