//! Who goes where, also after losses: worked out by everyone alike from the same list, without a word.
//!
//! The robot with the k-th smallest id has the k-th target. When a robot is gone, its target is a hole; the robot whose
//! own target the layout misses least takes it: the outermost one without which the rest still hangs together.

use super::topology::Graph;
use drover_contract::{RobotId, Vec2};

/// The layout and who has which place in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// Sorted.
    ids: Vec<RobotId>,
    targets_w: Vec<Vec2>,
    range_m: f64,
}

impl Places {
    /// Of robots with these ids, in any order, and the targets in the order of sorted ids; `range_m` is the radio's.
    #[must_use]
    pub fn new(ids: impl IntoIterator<Item = RobotId>, targets_m: &[[f64; 2]], range_m: f64) -> Self {
        let mut ids: Vec<RobotId> = ids.into_iter().collect();
        ids.sort_unstable();
        let targets_w = targets_m.iter().take(ids.len()).map(|[x, y]| Vec2::new(*x, *y)).collect();
        Self { ids, targets_w, range_m }
    }

    /// The target of robot `own` while the robots `gone` (sorted) are not there; `None` for a stranger.
    #[must_use]
    pub fn target_w(&self, own: RobotId, gone: &[RobotId]) -> Option<Vec2> {
        let rank = self.rank(own)?;
        let mut holds: Vec<Option<usize>> = (0..self.ids.len()).map(Some).collect();
        for lost in gone.iter().filter_map(|id| self.rank(*id)) {
            let Some(hole) = holds[lost].take() else { continue };
            let present: Vec<usize> = (0..self.ids.len()).filter(|at| holds[*at].is_some()).collect();
            let least = self.least_missed(hole, &present, &holds);
            if let Some(heir) = least {
                holds[heir] = Some(hole);
            }
        }
        holds[rank].and_then(|at| self.targets_w.get(at)).copied()
    }

    /// Of the robots `present`, the one whose target is missed least, if it is missed less than the hole.
    fn least_missed(&self, hole: usize, present: &[usize], holds: &[Option<usize>]) -> Option<usize> {
        let centre_w = self.targets_w.iter().sum::<Vec2>() / self.targets_w.len().max(1) as f64;
        let out_m = |target: usize| (self.targets_w[target] - centre_w).norm();
        let held = || present.iter().filter_map(|robot| holds[*robot].map(|target| (*robot, target)));
        // Whether all held targets and the hole hang together without one of them.
        let spare = |target: usize| {
            let rest = |at: usize| at != target && (at == hole || held().any(|(_, held)| held == at));
            let at_w: Vec<Option<Vec2>> =
                self.targets_w.iter().enumerate().map(|(at, target_w)| rest(at).then_some(*target_w)).collect();
            Graph::new(&at_w, self.range_m).all().parts(|at| at_w[at].is_some()) <= 1
        };
        if spare(hole) && held().all(|(_, target)| out_m(target) <= out_m(hole)) {
            return None;
        }
        let mut outward: Vec<(usize, usize)> =
            held().filter(|(_, target)| out_m(*target) > out_m(hole) || !spare(hole)).collect();
        outward.sort_by(|(a, one), (b, other)| out_m(*other).total_cmp(&out_m(*one)).then(a.cmp(b)));
        outward.into_iter().find(|(_, target)| spare(*target)).map(|(robot, _)| robot)
    }

    fn rank(&self, id: RobotId) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column() -> Places {
        Places::new((1..=5).map(RobotId), &[[0.0, 0.0], [0.0, 5.0], [0.0, 10.0], [0.0, 15.0], [0.0, 20.0]], 7.0)
    }

    #[test]
    fn a_hole_in_the_middle_is_filled_from_an_end_and_one_at_an_end_is_left() {
        let places = column();
        let all = |gone: &[RobotId]| -> Vec<Option<f64>> {
            (1..=5).map(|id| places.target_w(RobotId(id), gone).map(|target_w| target_w.y)).collect()
        };
        assert_eq!(all(&[]), [Some(0.0), Some(5.0), Some(10.0), Some(15.0), Some(20.0)]);
        assert_eq!(all(&[RobotId(3)]), [Some(10.0), Some(5.0), None, Some(15.0), Some(20.0)]);
        assert_eq!(all(&[RobotId(5)]), [Some(0.0), Some(5.0), Some(10.0), Some(15.0), None]);
        assert_eq!(all(&[RobotId(2), RobotId(3)])[1..3], [None, None]);
        assert_eq!(places.target_w(RobotId(9), &[]), None, "a stranger");
    }
}
