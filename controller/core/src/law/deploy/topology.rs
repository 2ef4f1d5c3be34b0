//! Which links of a radio graph are kept, and the tree of the kept ones towards the goal.
//!
//! - **RNG**: a link is left out if a third robot is nearer to both of its ends than they are to each other (the
//!   paper's "break the cycle" for triangles).
//! - **LMST_k**: each robot builds the minimum spanning tree of all robots within k hops and keeps its own links of it;
//!   what both ends keep is kept (N. Li, J. Hou, L. Sha, "Design and analysis of an MST-based topology control
//!   algorithm", INFOCOM 2003, there k = 1).
//!
//! Both contain the minimum spanning tree of the whole graph, hence keep it connected: the longest link of a cycle,
//! with ties broken by ids, is in no minimum spanning tree. So does the kept set of every robot's own view.

use drover_contract::Vec2;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// The disc graph of a snapshot: who hears whom. Robots are numbered; lists are sorted.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    at_w: Vec<Vec2>,
    neighbours: Vec<Vec<usize>>,
    /// What a link at a robot weighs beyond its length, metres; the larger of its ends' counts.
    extra_m: Vec<f64>,
}

impl Graph {
    /// Of robots at `at_w`, metres, that hear each other within `range_m`. One that is `None` is heard by nobody.
    #[must_use]
    pub fn new(at_w: &[Option<Vec2>], range_m: f64) -> Self {
        let cell = |at_w: Vec2| ((at_w.x / range_m).floor() as i64, (at_w.y / range_m).floor() as i64);
        let mut cells: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
        for (robot, at_w) in at_w.iter().enumerate() {
            if let Some(at_w) = at_w {
                cells.entry(cell(*at_w)).or_default().push(robot);
            }
        }
        let near = |robot: usize, here_w: Vec2| {
            let (x, y) = cell(here_w);
            let columns = (x - 1..=x + 1).flat_map(|x| cells.range((x, y - 1)..=(x, y + 1)));
            let within = |other: &usize| at_w[*other].is_some_and(|at_w| (at_w - here_w).norm() <= range_m);
            let mut near: Vec<usize> = columns.flat_map(|(_, robots)| robots).copied().filter(within).collect();
            near.retain(|other| *other != robot);
            near.sort_unstable();
            near
        };
        let neighbours = at_w.iter().enumerate().map(|(robot, at_w)| at_w.map_or_else(Vec::new, |at| near(robot, at)));
        Self {
            neighbours: neighbours.collect(),
            extra_m: vec![0.0; at_w.len()],
            at_w: at_w.iter().map(|at| at.unwrap_or_else(Vec2::zeros)).collect(),
        }
    }

    /// The same where trees prefer links near to a goal: `share` of the distance to it is added to a link's length.
    ///
    /// A ring around an obstacle then opens behind it, where nobody has to be dragged back around, and not where the
    /// robots in front happen to be far apart. Any weights that both ends agree on make trees that connect.
    #[must_use]
    pub fn goalward(mut self, share: f64, distance_m: impl Fn(Vec2) -> f64) -> Self {
        self.extra_m = self.at_w.iter().map(|at_w| share * distance_m(*at_w)).collect();
        self
    }

    /// Whom `robot` hears.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn neighbours(&self, robot: usize) -> &[usize] {
        &self.neighbours[robot]
    }

    /// How many robots there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.at_w.len()
    }

    /// All links.
    #[must_use]
    pub fn all(&self) -> KeptGraph {
        KeptGraph { links: self.neighbours.clone(), relayed: 0 }
    }

    /// The relative neighbourhood graph.
    #[must_use]
    pub fn rng(&self) -> KeptGraph {
        let closer = |a: usize, b: usize, third: usize| {
            let long = self.apart_m2(a, b);
            self.apart_m2(a, third) < long && self.apart_m2(b, third) < long
        };
        // Who is nearer to both ends than they are to each other hears both.
        let keeps = |a: usize, b: usize| !self.neighbours[a].iter().any(|third| *third != b && closer(a, b, *third));
        let of = |a: usize| self.neighbours[a].iter().copied().filter(move |b| keeps(a, *b)).collect();
        KeptGraph { links: (0..self.count()).map(of).collect(), relayed: 0 }
    }

    /// Links that both ends keep in the minimum spanning trees of their `hops`-hop neighbourhoods; 0: of the whole
    /// network, as far as it hangs together.
    #[must_use]
    pub fn lmst(&self, hops: u32) -> KeptGraph {
        let mut local = Local::new(self.count());
        if hops == 0 {
            return self.whole_tree(&mut local);
        }
        let own: Vec<Vec<usize>> = (0..self.count()).map(|robot| local.tree_links(self, robot, hops)).collect();
        let both = |a: usize| own[a].iter().copied().filter(|b| own[*b].contains(&a)).collect();
        KeptGraph { links: (0..self.count()).map(both).collect(), relayed: local.relayed }
    }

    /// One tree a part of the network: what each of its robots would find by itself.
    fn whole_tree(&self, local: &mut Local) -> KeptGraph {
        let mut links = vec![Vec::new(); self.count()];
        let mut seen = vec![false; self.count()];
        for robot in 0..self.count() {
            if seen[robot] {
                continue;
            }
            let tree = local.tree(self, robot, u32::MAX);
            local.members.iter().for_each(|member| seen[*member] = true);
            local.relayed += (local.members.len() * (local.members.len() - 1)) as u64;
            for (one, other) in tree {
                links[one].push(other);
                links[other].push(one);
            }
        }
        links.iter_mut().for_each(|links: &mut Vec<usize>| links.sort_unstable());
        KeptGraph { links, relayed: local.relayed }
    }

    fn apart_m2(&self, a: usize, b: usize) -> f64 {
        (self.at_w[a] - self.at_w[b]).norm_squared()
    }

    /// The order of links: by length, then by ids, the same at both ends.
    fn order(&self, (a, b): (usize, usize), (c, d): (usize, usize)) -> Ordering {
        let ids = |a: usize, b: usize| (a.min(b), a.max(b));
        let weight = |a: usize, b: usize| self.apart_m2(a, b).sqrt() + self.extra_m[a].max(self.extra_m[b]);
        weight(a, b).total_cmp(&weight(c, d)).then_with(|| ids(a, b).cmp(&ids(c, d)))
    }
}

/// What one robot's tree is built with; kept for its memory.
struct Local {
    /// The robots within reach, in the order of hops.
    members: Vec<usize>,
    /// Each robot's place among them.
    place: Vec<Option<usize>>,
    /// How many of them are a hop nearer: a neighbour's k hops are ours of one hop less, and ourselves.
    inner: usize,
    /// Places of others that each robot has to tell its neighbours, summed.
    relayed: u64,
}

impl Local {
    fn new(count: usize) -> Self {
        Self { members: Vec::new(), place: vec![None; count], inner: 1, relayed: 0 }
    }

    /// The links of `robot` in the minimum spanning tree of its `hops`-hop neighbourhood (Prim, from the robot).
    fn tree_links(&mut self, graph: &Graph, robot: usize, hops: u32) -> Vec<usize> {
        let tree = self.tree(graph, robot, hops);
        self.relayed += self.inner as u64 - 1;
        let mut links: Vec<usize> = tree.iter().filter(|(inner, _)| *inner == robot).map(|(_, outer)| *outer).collect();
        links.sort_unstable();
        links
    }

    /// All links of that tree, the end nearer to the robot first.
    fn tree(&mut self, graph: &Graph, robot: usize, hops: u32) -> Vec<(usize, usize)> {
        self.gather(graph, robot, hops);
        let count = self.members.len();
        // For each member outside of the tree, the member inside of it that is nearest.
        let mut via: Vec<Option<usize>> = vec![None; count];
        let mut outside: Vec<usize> = (1..count).collect();
        let mut links = Vec::new();
        let mut newest = 0;
        while !outside.is_empty() {
            self.relax(graph, newest, &mut via);
            let link = |member: usize| via[member].map(|inner| (self.members[inner], self.members[member]));
            let nearest = outside.iter().enumerate().filter_map(|(at, member)| Some((at, link(*member)?)));
            let Some((at, (inner, outer))) = nearest.min_by(|(_, a), (_, b)| graph.order(*a, *b)) else { break };
            newest = outside.swap_remove(at);
            links.push((inner, outer));
        }
        for member in &self.members {
            self.place[*member] = None;
        }
        links
    }

    fn gather(&mut self, graph: &Graph, robot: usize, hops: u32) {
        self.members.clear();
        self.members.push(robot);
        self.place[robot] = Some(0);
        let mut from = 0;
        let mut hop = 0;
        while hop < hops && from < self.members.len() {
            let until = self.members.len();
            self.inner = until;
            for at in from..until {
                for other in graph.neighbours(self.members[at]) {
                    if self.place[*other].is_none() {
                        self.place[*other] = Some(self.members.len());
                        self.members.push(*other);
                    }
                }
            }
            from = until;
            hop += 1;
        }
    }

    /// `newest` has come into the tree: who is nearer to it than to the tree before may be linked to it.
    fn relax(&self, graph: &Graph, newest: usize, via: &mut [Option<usize>]) {
        let inner = self.members[newest];
        for other in graph.neighbours(inner) {
            let Some(place) = self.place[*other] else { continue };
            let better = via[place]
                .is_none_or(|before| graph.order((inner, *other), (self.members[before], *other)) == Ordering::Less);
            if better {
                via[place] = Some(newest);
            }
        }
    }
}

/// Kept links: each robot's, sorted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeptGraph {
    links: Vec<Vec<usize>>,
    relayed: u64,
}

impl KeptGraph {
    /// Places of others that all robots together have to tell their neighbours, so that each can build its tree.
    #[must_use]
    pub fn relayed(&self) -> u64 {
        self.relayed
    }

    /// The kept links of `robot`.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn of(&self, robot: usize) -> &[usize] {
        &self.links[robot]
    }

    /// Each robot's parent: the next on the way of fewest links to the root of its part, whose `metric` is smallest.
    #[must_use]
    pub fn parents(&self, metric: impl Fn(usize) -> f64) -> Vec<Option<usize>> {
        let mut roots: Vec<usize> = (0..self.links.len()).collect();
        roots.sort_by(|a, b| metric(*a).total_cmp(&metric(*b)).then(a.cmp(b)));
        let mut parents = vec![None; self.links.len()];
        let mut seen = vec![false; self.links.len()];
        for root in roots {
            if std::mem::replace(&mut seen[root], true) {
                continue;
            }
            let mut queue = std::collections::VecDeque::from([root]);
            while let Some(robot) = queue.pop_front() {
                for other in &self.links[robot] {
                    if !std::mem::replace(&mut seen[*other], true) {
                        parents[*other] = Some(robot);
                        queue.push_back(*other);
                    }
                }
            }
        }
        parents
    }

    /// How many parts it has; robots for which `there` is false do not count.
    #[must_use]
    pub fn parts(&self, there: impl Fn(usize) -> bool) -> usize {
        let parents = self.parents(|_| 0.0);
        (0..self.links.len()).filter(|robot| there(*robot) && parents[*robot].is_none()).count()
    }
}
