//! Who meets whom within one step, and where along it.

use crate::body::Motion;
use crate::place::Place;
use crate::sweep::{SKIN_M, first_contact};
use drover_contract::Pose;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A body's motion in this step, and how much of it nothing prevents.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) from_wb: Pose,
    pub(crate) motion: Motion,
    pub(crate) share: f64,
    /// No part of the body moves farther than this in the whole step, metres.
    pub(crate) sweep_m: f64,
}

/// Finds contacts; its lists are kept from step to step.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    pairs: Vec<Pair>,
    /// (robot, index of a pair that it is in), sorted.
    of_robot: Vec<(u32, u32)>,
    due: BinaryHeap<Meeting>,
    /// Robots that a contact stops now.
    met: Vec<usize>,
}

/// Two bodies that may meet in this step, and where along it they do.
#[derive(Clone, Copy, Debug)]
struct Pair {
    robots: [usize; 2],
    contact: Option<f64>,
}

/// A contact that is due: the earliest is the greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Meeting {
    share: f64,
    pair: usize,
}

impl Eq for Meeting {}

impl Ord for Meeting {
    fn cmp(&self, other: &Self) -> Ordering {
        other.share.total_cmp(&self.share).then(other.pair.cmp(&self.pair))
    }
}

impl PartialOrd for Meeting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Contacts {
    /// Clip motions at contacts between bodies, the earliest contact first.
    ///
    /// A clipped body stands where it is from then on, so only contacts at or after that moment can be new: every round
    /// ends the step for at least one body more.
    pub(crate) fn resolve(&mut self, place: &Place, plans: &mut [Plan]) {
        self.find_pairs(place, plans);
        self.due.clear();
        for pair in 0..self.pairs.len() {
            self.look_at(pair, place, plans);
        }
        if self.due.is_empty() {
            return;
        }
        self.index_by_robot();
        while let Some(share) = self.due.peek().map(|meeting| meeting.share) {
            self.take_all_at(share);
            for robot in &self.met {
                plans[*robot].share = plans[*robot].share.min(share);
            }
            for at in 0..self.met.len() {
                for pair in self.pairs_of(self.met[at]) {
                    self.look_at(self.of_robot[pair].1 as usize, place, plans);
                }
            }
        }
    }

    /// Whom a contact at this very moment stops. Contacts at one moment count together: which is looked at first must
    /// not decide who is stopped.
    fn take_all_at(&mut self, share: f64) {
        self.met.clear();
        while let Some(meeting) = self.due.peek().copied().filter(|meeting| meeting.share <= share) {
            self.due.pop();
            let Pair { robots, contact } = self.pairs[meeting.pair];
            // One that was looked at again since has another moment, or none.
            if contact == Some(meeting.share) {
                self.met.extend(robots);
            }
        }
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.pairs.capacity() * size_of::<Pair>()
            + self.of_robot.capacity() * size_of::<(u32, u32)>()
            + self.due.capacity() * size_of::<Meeting>()
    }

    /// All pairs of bodies that could meet in this step.
    fn find_pairs(&mut self, place: &Place, plans: &[Plan]) {
        self.pairs.clear();
        let discs = place.discs();
        let sweep_m_max = plans.iter().map(|plan| plan.sweep_m).fold(0.0, f64::max);
        let reach = |robot: usize| discs[robot].radius_m + plans[robot].sweep_m;
        for a in 0..plans.len() {
            let window_m = reach(a) + sweep_m_max + SKIN_M;
            for b in place.bodies_near(discs[a].centre_w, window_m).filter(|b| *b > a) {
                let apart2 = (discs[a].centre_w - discs[b].centre_w).norm_squared();
                let reach_m = reach(a) + reach(b) + SKIN_M;
                if apart2 <= reach_m * reach_m {
                    self.pairs.push(Pair { robots: [a, b], contact: None });
                }
            }
        }
    }

    fn index_by_robot(&mut self) {
        self.of_robot.clear();
        for (index, pair) in self.pairs.iter().enumerate() {
            self.of_robot.extend(pair.robots.map(|robot| (robot as u32, index as u32)));
        }
        self.of_robot.sort_unstable();
    }

    fn pairs_of(&self, robot: usize) -> std::ops::Range<usize> {
        let robot = robot as u32;
        let first = self.of_robot.partition_point(|(of, _)| *of < robot);
        first..self.of_robot.partition_point(|(of, _)| *of <= robot)
    }

    fn look_at(&mut self, pair: usize, place: &Place, plans: &[Plan]) {
        let contact = contact_of(self.pairs[pair].robots, place, plans);
        self.pairs[pair].contact = contact;
        self.due.extend(contact.map(|share| Meeting { share, pair }));
    }
}

/// Where along the step these two meet, if that ends the motion of one of them earlier than known so far.
fn contact_of([a, b]: [usize; 2], place: &Place, plans: &[Plan]) -> Option<f64> {
    let (plan_a, plan_b) = (&plans[a], &plans[b]);
    let way_m = plan_a.sweep_m + plan_b.sweep_m;
    let gap_at = |share: f64| {
        let poses_wb = [plan_a.pose_at(share), plan_b.pose_at(share)];
        place.body_gap_m([a, b], poses_wb, way_m + SKIN_M)
    };
    let share = first_contact(way_m, gap_at)?;
    (share < plan_a.share.max(plan_b.share)).then_some(share)
}
