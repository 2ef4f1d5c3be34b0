//! How well a swarm hangs together: who hears whom both ways, and the Laplacian of that graph.

use crate::{Moment, RobotMoment, Setting};
use nalgebra::DMatrix;
use std::collections::{BTreeMap, BTreeSet};

/// How well a swarm hangs together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Connectivity {
    /// Algebraic connectivity: the second smallest eigenvalue of the graph's Laplacian, links of weight 1. 0 if the
    /// graph falls apart; the number of robots if everybody hears everybody; `None` for fewer than two robots.
    pub lambda2: Option<f64>,
    /// Into how many parts the graph falls.
    pub components: usize,
}

/// Pairs of robots that hear each other both ways, as indices into the moment's robots, the smaller first, in order.
///
/// A robot hears a peer if the newest beacon is not older than the `peer_ms` of the one that hears.
#[must_use]
pub fn hearing(setting: &Setting, moment: &Moment) -> Vec<(usize, usize)> {
    let patience: BTreeMap<u32, u32> = setting.robots.iter().map(|robot| (robot.id, robot.peer_ms)).collect();
    let index: BTreeMap<u32, usize> = moment.robots.iter().enumerate().map(|(at, robot)| (robot.id, at)).collect();
    let heard_by = |(at, robot): (usize, &RobotMoment)| {
        let patience_ms = u64::from(patience.get(&robot.id).copied().unwrap_or(0));
        let fresh = robot.heard.iter().filter(move |heard| heard.age_ms <= patience_ms);
        fresh.filter_map(|heard| index.get(&heard.id).map(|peer| (at, *peer))).collect::<Vec<_>>()
    };
    let one_way: BTreeSet<(usize, usize)> = moment.robots.iter().enumerate().flat_map(heard_by).collect();
    one_way.iter().copied().filter(|(one, other)| one < other && one_way.contains(&(*other, *one))).collect()
}

/// How well a graph of `robots` nodes with these links hangs together. Links to nodes that are not there are left out.
///
/// The eigenvalues of a dense matrix: the time grows with the cube of the number of robots (about a millisecond for
/// 100), unless the graph falls apart, which is found out first.
#[must_use]
pub fn connectivity(robots: usize, links: &[(usize, usize)]) -> Connectivity {
    let links: BTreeSet<(usize, usize)> = links
        .iter()
        .filter(|(one, other)| one != other && *one < robots && *other < robots)
        .map(|(one, other)| (*one.min(other), *one.max(other)))
        .collect();
    let components = parts(robots, &links);
    let lambda2 = match components {
        _ if robots < 2 => None,
        1 => second_eigenvalue(robots, &links),
        _ => Some(0.0),
    };
    Connectivity { lambda2, components }
}

fn second_eigenvalue(robots: usize, links: &BTreeSet<(usize, usize)>) -> Option<f64> {
    let mut laplacian = DMatrix::<f64>::zeros(robots, robots);
    for (one, other) in links.iter().copied() {
        laplacian[(one, one)] += 1.0;
        laplacian[(other, other)] += 1.0;
        laplacian[(one, other)] -= 1.0;
        laplacian[(other, one)] -= 1.0;
    }
    let mut eigenvalues: Vec<f64> = laplacian.symmetric_eigenvalues().iter().copied().collect();
    eigenvalues.sort_by(f64::total_cmp);
    eigenvalues.get(1).map(|value| value.max(0.0))
}

/// Parts by joining the roots of what is linked.
fn parts(robots: usize, links: &BTreeSet<(usize, usize)>) -> usize {
    let mut parent: Vec<usize> = (0..robots).collect();
    let mut parts = robots;
    for (one, other) in links {
        let (one, other) = (root(&mut parent, *one), root(&mut parent, *other));
        if one != other {
            parent[one] = other;
            parts -= 1;
        }
    }
    parts
}

fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}
