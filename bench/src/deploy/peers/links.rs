//! Who hears whom: links, spanning trees, and whether a swarm hangs together, for a whole period as well.

use drover_contract::Vec2;
use nalgebra::DMatrix;

/// Two robots, the lower index first.
pub(super) type Link = (usize, usize);

/// Sets of robots that grow together.
struct Groups(Vec<usize>);

impl Groups {
    fn new(robots: usize) -> Self {
        Self((0..robots).collect())
    }

    fn head(&mut self, mut robot: usize) -> usize {
        while self.0[robot] != robot {
            self.0[robot] = self.0[self.0[robot]];
            robot = self.0[robot];
        }
        robot
    }

    /// Whether the two were apart before.
    fn join(&mut self, (one, other): Link) -> bool {
        let (one, other) = (self.head(one), self.head(other));
        self.0[one] = other;
        one != other
    }
}

/// All pairs of robots.
pub(super) fn pairs(robots: usize) -> impl Iterator<Item = Link> {
    (0..robots).flat_map(move |one| (one + 1..robots).map(move |other| (one, other)))
}

/// The links of range `range_m`.
pub(super) fn within(at_w: &[Vec2], range_m: f64) -> Vec<Link> {
    pairs(at_w.len()).filter(|(one, other)| (at_w[*one] - at_w[*other]).norm() <= range_m).collect()
}

/// Whether `links` join all robots.
pub(super) fn connect(robots: usize, links: impl IntoIterator<Item = Link>) -> bool {
    let mut groups = Groups::new(robots);
    links.into_iter().filter(|link| groups.join(*link)).count() + 1 >= robots
}

/// The second smallest eigenvalue of the graph's Laplacian, every link of range `range_m` with weight 1; 0 for one.
pub(super) fn lambda2(at_w: &[Vec2], range_m: f64) -> f64 {
    let mut laplacian = DMatrix::zeros(at_w.len(), at_w.len());
    for (i, j) in within(at_w, range_m) {
        laplacian[(i, j)] = -1.0;
        laplacian[(j, i)] = -1.0;
        laplacian[(i, i)] += 1.0;
        laplacian[(j, j)] += 1.0;
    }
    let mut eigenvalues: Vec<f64> = laplacian.symmetric_eigenvalues().iter().copied().collect();
    eigenvalues.sort_by(f64::total_cmp);
    // Rounding may leave an eigenvalue of 0 a little below.
    eigenvalues.get(1).map_or(0.0, |lambda2| lambda2.max(0.0))
}

/// The spanning tree (forest, if they do not hang together) of least total cost; ties go to the lower indices.
pub(super) fn tree(robots: usize, links: &[Link], cost: impl Fn(Link) -> f64) -> Vec<Link> {
    let mut costs: Vec<(f64, Link)> = links.iter().map(|link| (cost(*link), *link)).collect();
    costs.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let mut groups = Groups::new(robots);
    costs.into_iter().map(|(_, link)| link).filter(|link| groups.join(*link)).collect()
}

/// Whether a swarm hangs together at every instant of straight moves that all begin and end together.
///
/// Distances are convex over time. So a link that is there at both ends is there all the time, and those mostly
/// suffice. Else each link's interval is computed, and the graph is looked at between all their ends.
pub(super) fn connected_throughout(from_w: &[Vec2], to_w: &[Vec2], range_m: f64) -> bool {
    let robots = from_w.len();
    let throughout = within(from_w, range_m).into_iter().filter(|(i, j)| (to_w[*i] - to_w[*j]).norm() <= range_m);
    if connect(robots, throughout) {
        return true;
    }
    let apart = |(i, j): Link| (from_w[i] - from_w[j], (to_w[i] - from_w[i]) - (to_w[j] - from_w[j]));
    let times = |link| {
        let (apart, change) = apart(link);
        linked_between(apart, change, range_m).map(|times| (link, times))
    };
    let linked: Vec<(Link, (f64, f64))> = pairs(robots).filter_map(times).collect();
    let mut ends: Vec<f64> = linked.iter().flat_map(|(_, (on, off))| [*on, *off]).chain([0.0, 1.0]).collect();
    ends.sort_by(f64::total_cmp);
    let at = |time: f64| linked.iter().filter(move |(_, (on, off))| *on <= time && time <= *off).map(|(link, _)| *link);
    let between = ends.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| f64::midpoint(pair[0], pair[1]));
    between.chain([0.0, 1.0]).all(|time| connect(robots, at(time)))
}

/// When in 0..=1 two points that are `apart` and move by `change` against each other are within `range_m`.
fn linked_between(apart: Vec2, change: Vec2, range_m: f64) -> Option<(f64, f64)> {
    let (square, half, rest) = (change.norm_squared(), apart.dot(&change), apart.norm_squared() - range_m * range_m);
    if square <= 0.0 {
        return (rest <= 0.0).then_some((0.0, 1.0));
    }
    let root2 = half * half - square * rest;
    if root2 < 0.0 {
        return None;
    }
    let (on, off) = ((-half - root2.sqrt()) / square, (-half + root2.sqrt()) / square);
    (on <= 1.0 && off >= 0.0).then(|| (on.max(0.0), off.min(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    #[test]
    fn the_shortest_tree_of_a_triangle_leaves_its_longest_side() {
        let at_w = [v(0.0, 0.0), v(3.0, 0.0), v(3.0, 4.0)];
        let links = within(&at_w, 7.0);
        assert_eq!(tree(3, &links, |(i, j)| (at_w[i] - at_w[j]).norm()), vec![(0, 1), (1, 2)]);
        assert!(connect(3, within(&at_w, 4.0)) && !connect(3, within(&at_w, 3.5)));
    }

    #[test]
    fn connectivity_is_that_of_the_books() {
        // A path of three has 1, a triangle 3, two that are apart 0.
        let chain = [v(0.0, 0.0), v(3.0, 0.0), v(6.0, 0.0)];
        assert!((lambda2(&chain, 4.0) - 1.0).abs() < 1e-12 && (lambda2(&chain, 7.0) - 3.0).abs() < 1e-12);
        assert!(lambda2(&chain, 2.0).abs() < 1e-12 && lambda2(&chain[..1], 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_messenger_between_two_keeps_or_loses_them_on_its_way() {
        // Two stand 10 m apart; the messenger goes from within range of both to there, or along a detour.
        let stay = [v(0.0, 0.0), v(10.0, 0.0)];
        let with = |messenger: Vec2| [stay[0], stay[1], messenger];
        assert!(connected_throughout(&with(v(4.0, 0.0)), &with(v(6.0, 0.0)), 7.0));
        assert!(!connected_throughout(&with(v(4.0, 0.0)), &with(v(2.0, 0.0)), 7.0));
        // Two pairs, linked at their lower ends before and at their upper ends after: in between by neither.
        let pairs = |lower_m: f64, upper_m: f64| [v(0.0, 0.0), v(0.0, 6.0), v(lower_m, 0.0), v(upper_m, 6.0)];
        assert!(connect(4, within(&pairs(6.9, 7.5), 7.0)) && connect(4, within(&pairs(7.5, 6.9), 7.0)));
        assert!(!connected_throughout(&pairs(6.9, 7.5), &pairs(7.5, 6.9), 7.0));
        assert!(connected_throughout(&pairs(6.8, 7.1), &pairs(7.1, 6.8), 7.0));
        // Passing one another: out of range at no time, though each link is new at the end.
        assert!(connected_throughout(&[v(-5.0, 0.0), v(0.0, 0.0)], &[v(5.0, 0.0), v(0.0, 0.0)], 7.0));
    }
}
