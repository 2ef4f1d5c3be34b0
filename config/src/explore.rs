//! Exploration: robots map a place that nobody knows, together, and stop when nothing reachable is left unknown.

use serde::Serialize;

/// Parameters of exploration. Symbols are the paper's (Wu 2008), whose values are the defaults; lengths are in cells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explore {
    /// How robots choose where to go.
    pub method: ExploreMethod,
    /// What a classical method weighs against the way to a candidate.
    pub value: CandidateValue,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// A simulated point takes one step, to one of the eight neighbours, in this time, s.
    pub step_s: f64,
    /// A robot on a cell sees this many cells to each side, as far as nothing stands in between (r_c = 4: 2). Bodies
    /// choose where to go as if they saw so far.
    pub reach_cells: u8,
    /// What is to be mapped: south-west and north-east corner, metres; none: the bounds of the world, which a robot in
    /// the field does not have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_m: Option<[[f64; 2]; 2]>,
    /// How simulated points on cells share what they see. Bodies gossip.
    pub exchange: MapExchange,
    /// A body drives at most this fast while it explores, m/s.
    pub speed_mps: f64,
    /// A body thinks about where to go this often, s, or as soon as it has arrived or its way is closed.
    pub decide_s: f64,

    /// w1: weight of obstacles near a candidate (eq. 9).
    pub obstacle_weight: f64,
    /// w2: weight of unknown cells near a candidate (eq. 9).
    pub unknown_weight: f64,
    /// w3: weight of keeping a distance (eq. 14).
    pub spread_weight: f64,
    /// w4: weight of going another way than the others (eq. 14).
    pub direction_weight: f64,
    /// mu: where the distance is best (eq. 11).
    pub spread_best: f64,
    /// r_c: where a neighbour's effect begins to fall (eq. 10), cells.
    pub near_cells: f64,
    /// r_t: where it ends, cells.
    pub far_cells: f64,
    /// A candidate counts in a local decision if its affinity is more than this share of the best (eq. 15).
    pub affinity_share: f64,
    /// ST: every so many steps all decide together.
    pub global_steps: u32,
    /// Most antibodies (candidates) of a robot in a global decision.
    pub population: usize,
    /// Generations of the immune network (eq. 6 to 8).
    pub generations: u32,
    /// alpha: rate of stimulation (eq. 6).
    pub stimulation_rate: f64,
    /// beta: rate of the antigen (eq. 6).
    pub antigen_rate: f64,
    /// k: rate of dying (eq. 6).
    pub death_rate: f64,
    /// delta: rate of the T cell (eq. 8); 0: without it.
    pub t_cell_rate: f64,
    /// How the network's affinity is made to lie within 0 and 1 (eq. 8 needs it; the paper does not say).
    pub affinity: AffinityReading,
    /// How the suppression of eq. 4 is read, for the method "basic".
    pub suppression: Suppression,
    /// Whether the network's fixed point is taken instead of running its generations.
    pub closed_form: bool,

    /// lambda: an unknown cell counts 1, and this much more if all around it is known.
    pub hug_weight: f64,
    /// rho: what is nearer to another robot counts this much.
    pub others_weight: f64,
    /// What another robot is about to see counts this much.
    pub claimed_weight: f64,
    /// What is early: most of the map, or all of it.
    pub finish: Finish,
}

/// How robots choose where to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ExploreMethod {
    /// What ships.
    Sweep,
    /// The paper's improved immune network.
    Inea,
    /// The basic immune network that the paper compares with.
    Basic,
    /// The best affinity for itself, whatever others do.
    Greedy,
    /// The nearest frontier cell (Yamauchi 1997).
    Nearest,
    /// Utility less cost, utility falling near others' targets (Burgard 2005).
    Burgard,
    /// The assignment of least cost (Kuhn 1955; Wurm 2008 without segments).
    Hungarian,
    /// The frontier to which fewest others are nearer (Bautin 2012).
    MinPos,
    /// Auctions of candidates (Zlot 2002).
    Market,
}

/// What a classical method weighs against the way to a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CandidateValue {
    /// The affinity's numerator (eq. 9): cost is steps over value.
    Affinity,
    /// Nothing: cost is steps.
    Cost,
}

/// How affinity is brought within 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AffinityReading {
    /// Over the best one.
    Normalised,
    /// What is more than 1 is 1.
    Clamped,
    /// Not at all.
    Raw,
}

/// Whose stimulations are subtracted in eq. 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Suppression {
    /// m_ki: what others are stimulated by it.
    Repaired,
    /// m_ik, as printed: both sums are the same and cancel.
    Printed,
}

/// How simulated points share what they see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MapExchange {
    /// One map that all have at every moment; the radio takes no part.
    Ideal,
    /// Logs of what was seen, by gossip over the radio.
    Gossip,
    /// The paper's: every `global_steps` steps, over the radio, the places from where one has looked, and one's
    /// candidates; who hears of a place takes the square around it for seen.
    Points,
}

/// What is early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// Most of the map: what is left in corners comes last.
    Fast,
    /// All of it: pockets are emptied while one is there.
    Whole,
}

impl Explore {
    /// The paper's values, and ours where it has none.
    #[must_use]
    pub fn usual(method: ExploreMethod) -> Self {
        Self {
            method,
            value: CandidateValue::Affinity,
            cell_m: 1.0,
            step_s: 1.0,
            reach_cells: 2,
            area_m: None,
            exchange: MapExchange::Ideal,
            speed_mps: 0.6,
            decide_s: 1.0,
            obstacle_weight: 0.5,
            unknown_weight: 0.1,
            spread_weight: 1.0,
            direction_weight: 0.8,
            spread_best: 0.4,
            near_cells: 4.0,
            far_cells: 10.0,
            affinity_share: 0.75,
            global_steps: 15,
            population: 100,
            generations: 40,
            stimulation_rate: 0.3,
            antigen_rate: 0.05,
            death_rate: 0.002,
            t_cell_rate: 1.0,
            affinity: AffinityReading::Normalised,
            suppression: Suppression::Repaired,
            closed_form: false,
            hug_weight: 1.0,
            others_weight: 0.3,
            claimed_weight: 0.3,
            finish: Finish::Fast,
        }
    }
}
