//! Who goes to which target: a step of planning when a swarm is read.

use crate::geometry::Point;
use crate::{Assignment, Behaviour, Swarm};
use pathfinding::prelude::{Matrix, kuhn_munkres_min};

/// Most targets that are assigned: the work grows with their third power. A thousand take about a second.
pub(crate) const TARGETS_MAX: usize = 1_000;

/// With `assignment = "hungarian"`, puts the targets into the order of the robots' ids: the robot with the k-th
/// smallest id goes to the k-th target. The sum of squared distances from the starts is the least; targets of nobody
/// come last.
pub(crate) fn assign(swarm: &mut Swarm) {
    let Behaviour::Deploy(deploy) = &mut swarm.behaviour else { return };
    if deploy.assignment == Assignment::Hungarian {
        let mut robots: Vec<_> = swarm.robots.iter().map(|robot| (robot.id, robot.start)).collect();
        robots.sort_unstable_by_key(|(id, _)| *id);
        let starts: Vec<Point> = robots.iter().map(|(_, start)| [start.x_m, start.y_m]).collect();
        reorder(&starts, &mut deploy.targets_m);
    }
}

/// Puts `targets` into the order of `starts`. An order that is as good as the best stays as it is, so that what was
/// assigned, written and read again is equal to itself.
fn reorder(starts: &[Point], targets: &mut Vec<Point>) {
    if starts.is_empty() || starts.len() > targets.len() || targets.len() > TARGETS_MAX {
        return; // such swarms are refused
    }
    let costs = Matrix::from_fn(starts.len(), targets.len(), |(start, target)| cost(starts[start], targets[target]));
    let (least, mut order) = kuhn_munkres_min(&costs);
    let given: i64 = (0..starts.len()).map(|index| costs[(index, index)]).sum();
    if given == least {
        return;
    }
    let mut taken = vec![false; targets.len()];
    order.iter().for_each(|target| taken[*target] = true);
    order.extend((0..targets.len()).filter(|target| !taken[*target]));
    *targets = order.iter().map(|target| targets[*target]).collect();
}

/// Squared distance, mm^2: whole numbers, so that the same starts make the same assignment anywhere. At most 8e14, and
/// so 8e17 for all: nothing overflows.
fn cost(start: Point, target: Point) -> i64 {
    let [x, y] = [0, 1].map(|axis| libm::round((start[axis] - target[axis]) * 1_000.0) as i64);
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::{cost, reorder};
    use crate::geometry::Point;
    use proptest::prelude::*;

    fn total(starts: &[Point], targets: &[Point]) -> i64 {
        starts.iter().zip(targets).map(|(start, target)| cost(*start, *target)).sum()
    }

    #[test]
    fn ways_that_cross_are_exchanged_and_the_rest_comes_last() {
        let mut targets = vec![[5.0, 0.0], [9.0, 9.0], [5.0, 3.0], [-9.0, 9.0]];
        reorder(&[[0.0, 3.0], [0.0, 0.0]], &mut targets);
        assert_eq!(targets, [[5.0, 3.0], [5.0, 0.0], [9.0, 9.0], [-9.0, 9.0]]);
    }

    #[test]
    fn of_orders_that_are_equally_good_the_given_one_stays() {
        // Both robots are as far from one target as from the other.
        let given = vec![[0.0, 5.0], [0.0, -5.0]];
        let mut targets = given.clone();
        reorder(&[[1.0, 0.0], [-1.0, 0.0]], &mut targets);
        assert_eq!(targets, given);
    }

    #[test]
    fn a_thousand_are_assigned_as_far_apart_as_coordinates_go() {
        let place =
            |index: u32| f64::from(index.wrapping_mul(2_654_435_761)) / f64::from(u32::MAX) * 20_000.0 - 10_000.0;
        let starts: Vec<Point> = (0..1_000).map(|index| [place(index), place(index + 5_000)]).collect();
        let mut targets: Vec<Point> = (0..1_000).map(|index| [place(index + 9_000), place(index + 20_000)]).collect();
        let before = total(&starts, &targets);
        reorder(&starts, &mut targets);
        assert!(total(&starts, &targets) < before / 5);
    }

    proptest! {
        #[test]
        fn no_other_order_is_better(
            starts in prop::collection::vec([-9.0..9.0_f64, -9.0..9.0], 1..6),
            targets in prop::collection::vec([-9.0..9.0_f64, -9.0..9.0], 6..7),
        ) {
            let mut assigned = targets.clone();
            reorder(&starts, &mut assigned);
            prop_assert_eq!(total(&starts, &assigned), best(&starts, &targets));
            let mut sorted = [targets, assigned.clone()];
            sorted.iter_mut().for_each(|list| list.sort_by(|a, b| a[0].total_cmp(&b[0])));
            prop_assert_eq!(&sorted[0], &sorted[1], "the same targets");
            let again = assigned.clone();
            reorder(&starts, &mut assigned);
            prop_assert_eq!(assigned, again);
        }
    }

    /// The least cost, by trying everything. Recursive: at most five starts.
    fn best(starts: &[Point], targets: &[Point]) -> i64 {
        let Some((first, rest)) = starts.split_first() else { return 0 };
        let with = |target: usize| {
            let others: Vec<Point> =
                (0..targets.len()).filter(|other| *other != target).map(|at| targets[at]).collect();
            cost(*first, targets[target]) + best(rest, &others)
        };
        (0..targets.len()).map(with).min().unwrap_or(0)
    }
}
