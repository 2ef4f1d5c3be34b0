//! Finds what is near without looking at everything: a tree of bounding boxes (each halves its children along the
//! longer side). Looking up costs about log n, however the boxes are spread.

use crate::geometry::Point;

/// A rectangle along the axes: south-west and north-east corner, metres.
pub(crate) type Bounds = [Point; 2];

/// The smallest rectangle around `points`; `None` without any.
pub(crate) fn bounds(points: impl IntoIterator<Item = Point>) -> Option<Bounds> {
    points.into_iter().map(|point| [point, point]).reduce(around)
}

/// The smallest rectangle around two.
fn around(a: Bounds, b: Bounds) -> Bounds {
    let [[a_low, a_high], [b_low, b_high]] = [a, b];
    [[a_low[0].min(b_low[0]), a_low[1].min(b_low[1])], [a_high[0].max(b_high[0]), a_high[1].max(b_high[1])]]
}

/// Whether two rectangles have a point in common.
fn overlap([a_low, a_high]: Bounds, [b_low, b_high]: Bounds) -> bool {
    (0..2).all(|axis| a_low[axis] <= b_high[axis] && b_low[axis] <= a_high[axis])
}

/// Things with their boxes.
#[derive(Debug)]
pub(crate) struct Boxes<T> {
    items: Vec<(Bounds, T)>,
    /// The box around each part of `items`: all, its two halves, their halves and so on, see [`node_count`].
    nodes: Vec<Bounds>,
}

/// Parts of this many things are not divided.
const LEAF: usize = 8;

impl<T> Boxes<T> {
    /// Sorts `items` into a tree.
    pub(crate) fn new(mut items: Vec<(Bounds, T)>) -> Self {
        let mut nodes = vec![[[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]; node_count(items.len())];
        build(&mut items, &mut nodes, 0);
        Self { items, nodes }
    }

    /// Calls `visit` with everything whose box overlaps `area`.
    pub(crate) fn overlapping<'b>(&'b self, area: Bounds, visit: &mut impl FnMut(&'b T)) {
        self.look(area, 0, &self.items, visit);
    }

    /// Recursive: a tree over n things is log n deep.
    fn look<'b>(&'b self, area: Bounds, node: usize, items: &'b [(Bounds, T)], visit: &mut impl FnMut(&'b T)) {
        if !self.nodes.get(node).is_some_and(|bounds| overlap(*bounds, area)) {
            return;
        }
        if items.len() <= LEAF {
            items.iter().filter(|(bounds, _)| overlap(*bounds, area)).for_each(|(_, item)| visit(item));
            return;
        }
        let (left, right) = items.split_at(items.len() / 2);
        self.look(area, 2 * node + 1, left, visit);
        self.look(area, 2 * node + 2, right, visit);
    }
}

/// Node `i` has the children `2 i + 1` and `2 i + 2`: as many as a full tree of that depth has.
fn node_count(items: usize) -> usize {
    let (mut size, mut count) = (items, 1);
    while size > LEAF {
        size = size.div_ceil(2);
        count = 2 * count + 1;
    }
    count
}

fn build<T>(items: &mut [(Bounds, T)], nodes: &mut [Bounds], node: usize) {
    let whole = items.iter().map(|(bounds, _)| *bounds).reduce(around);
    if let (Some(place), Some(whole)) = (nodes.get_mut(node), whole) {
        *place = whole;
    }
    let Some([low, high]) = whole.filter(|_| items.len() > LEAF) else { return };
    let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
    let middle = |(bounds, _): &(Bounds, T)| bounds[0][axis] + bounds[1][axis];
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let (left, right) = items.split_at_mut(half);
    build(left, nodes, 2 * node + 1);
    build(right, nodes, 2 * node + 2);
}

#[cfg(test)]
mod tests {
    use super::{Boxes, bounds, overlap};
    use proptest::prelude::*;

    #[test]
    fn nothing_is_found_in_nothing() {
        let mut found = 0;
        Boxes::<u8>::new(Vec::new()).overlapping([[0.0; 2], [1.0; 2]], &mut |_| found += 1);
        assert_eq!(found, 0);
        assert_eq!(bounds([]), None);
    }

    proptest! {
        #[test]
        fn exactly_what_overlaps_is_found(
            corners in prop::collection::vec(([-9.0..9.0_f64, -9.0..9.0], [0.0..3.0_f64, 0.0..3.0]), 0..200),
            low in [-9.0..9.0_f64, -9.0..9.0],
        ) {
            let all: Vec<_> = corners.iter().map(|(low, size)| [*low, [low[0] + size[0], low[1] + size[1]]]).collect();
            let area = [low, [low[0] + 1.0, low[1] + 2.0]];
            let expected: Vec<usize> = (0..all.len()).filter(|index| overlap(all[*index], area)).collect();
            let boxes = Boxes::new(all.into_iter().enumerate().map(|(index, bounds)| (bounds, index)).collect());
            let mut found = Vec::new();
            boxes.overlapping(area, &mut |index| found.push(*index));
            found.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}
