//! Which of the robots nearby to be linked with: the neighbours in the minimum spanning tree of what is in range.
//!
//! Whatever each robot hears, the links that both ends choose keep a connected swarm connected, and nobody has more
//! than six of them (N. Li, J. Hou, L. Sha, "Design and analysis of an MST-based topology control algorithm", INFOCOM
//! 2003). Cost: the square of the robots in range.

use drover_contract::{RobotId, Vec2};
use std::cmp::Ordering;

/// A robot and where it is.
pub(super) type Site = (RobotId, Vec2);

/// The neighbours of `own` in the tree of all robots within `range_m` of it, over links within `range_m`.
pub(super) fn local_mst(own: Site, others: impl Iterator<Item = Site>, range_m: f64) -> Vec<RobotId> {
    let range2_m2 = range_m * range_m;
    let near = others.filter(|(id, at_w)| *id != own.0 && (at_w - own.1).norm_squared() <= range2_m2);
    let mut outside: Vec<Branch> = near.map(|site| Branch { site, from: own }).collect();
    let mut chosen = Vec::new();
    // Prim's algorithm: all of them are in range of `own`, so the tree reaches them all.
    while let Some(next) = (0..outside.len()).min_by(|a, b| outside[*a].cmp(&outside[*b])) {
        let Branch { site, from } = outside.swap_remove(next);
        if from.0 == own.0 {
            chosen.push(site.0);
        }
        for other in &mut outside {
            let shorter = Branch { site: other.site, from: site };
            if shorter.length2_m2() <= range2_m2 && shorter.cmp(other) == Ordering::Less {
                *other = shorter;
            }
        }
    }
    chosen.sort_unstable();
    chosen
}

/// The shortest link known from the tree to a robot outside of it.
#[derive(Clone, Copy, Debug)]
struct Branch {
    site: Site,
    from: Site,
}

impl Branch {
    fn length2_m2(&self) -> f64 {
        (self.site.1 - self.from.1).norm_squared()
    }

    fn ends(&self) -> (RobotId, RobotId) {
        (self.site.0.min(self.from.0), self.site.0.max(self.from.0))
    }

    /// By length, then by ids: one order for all robots.
    fn cmp(&self, other: &Self) -> Ordering {
        self.length2_m2().total_cmp(&other.length2_m2()).then(self.ends().cmp(&other.ends()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sites(places: &[(f64, f64)]) -> Vec<Site> {
        (1..).zip(places).map(|(id, (x, y))| (RobotId(id), Vec2::new(*x, *y))).collect()
    }

    #[test]
    fn the_longest_side_of_a_triangle_is_left_out_and_what_is_out_of_range_is_not_seen() {
        let sites = sites(&[(0.0, 0.0), (3.0, 0.0), (1.5, 1.0), (9.0, 0.0)]);
        let mst = |own: usize| local_mst(sites[own], sites.iter().copied(), 5.0);
        assert_eq!([mst(0), mst(1), mst(3)], [vec![RobotId(3)], vec![RobotId(3)], Vec::new()]);
        assert_eq!(mst(2), [RobotId(1), RobotId(2)]);
    }

    #[test]
    fn equal_lengths_are_told_apart_by_ids() {
        let sites = sites(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let mst = |own: usize| local_mst(sites[own], sites.iter().copied(), 5.0);
        assert_eq!(mst(0), [RobotId(2), RobotId(4)], "1-2, 1-4 and 2-3 come before 3-4");
        assert_eq!([mst(2), mst(3)], [[RobotId(2)], [RobotId(1)]]);
    }
}
