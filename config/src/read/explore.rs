//! Reads what a swarm that explores is to do.

use super::by_mode::among;
use crate::reader::Table;
use crate::{AffinityReading, CandidateValue, Explore, ExploreMethod, Finish, MapExchange, Suppression};

/// What a file calls the methods; the first is the default.
pub(crate) const METHODS: [(&str, ExploreMethod); 9] = [
    ("sweep", ExploreMethod::Sweep),
    ("inea", ExploreMethod::Inea),
    ("basic", ExploreMethod::Basic),
    ("greedy", ExploreMethod::Greedy),
    ("nearest", ExploreMethod::Nearest),
    ("burgard", ExploreMethod::Burgard),
    ("hungarian", ExploreMethod::Hungarian),
    ("min_pos", ExploreMethod::MinPos),
    ("market", ExploreMethod::Market),
];

/// Reads `[behaviour]` with `kind = "explore"`. Where a default is the paper's, `Explore::usual` has it.
pub(crate) fn explore(table: &mut Table<'_>) -> Option<Explore> {
    let method = among(table, false, "method", METHODS, 0);
    let usual = Explore::usual(ExploreMethod::Sweep);
    const VALUES: [(&str, CandidateValue); 2] =
        [("affinity", CandidateValue::Affinity), ("cost", CandidateValue::Cost)];
    let value = among(table, false, "value", VALUES, 0);
    let cell_m = table.number("cell_m", 0.02..=10.0, Some(usual.cell_m));
    let step_s = table.number("step_s", 0.05..=60.0, Some(usual.step_s));
    let reach_cells = table.integer_u8("reach_cells", 1..=10, usual.reach_cells);
    let area_m = table.optional_region("area_m", "the bounds of the world; a robot's own file must have it");
    const EXCHANGES: [(&str, MapExchange); 3] =
        [("ideal", MapExchange::Ideal), ("gossip", MapExchange::Gossip), ("points", MapExchange::Points)];
    let exchange = among(table, false, "exchange", EXCHANGES, 0);
    let speed_mps = table.number("speed_mps", 0.05..=10.0, Some(usual.speed_mps));
    let decide_s = table.number("decide_s", 0.1..=60.0, Some(usual.decide_s));
    let base = Explore { method: method?, value: value?, cell_m: cell_m?, step_s: step_s?, ..usual };
    let base = Explore { area_m: area_m?, exchange: exchange?, speed_mps: speed_mps?, decide_s: decide_s?, ..base };
    let papers = immune(table, Explore { reach_cells: reach_cells?, ..base })?;
    ours(table, papers)
}

/// The paper's numbers.
fn immune(table: &mut Table<'_>, usual: Explore) -> Option<Explore> {
    let mut weight = |key, default| table.number(key, 0.0..=100.0, Some(default));
    let obstacle_weight = weight("obstacle_weight", usual.obstacle_weight);
    let unknown_weight = weight("unknown_weight", usual.unknown_weight);
    let spread_weight = weight("spread_weight", usual.spread_weight);
    let direction_weight = weight("direction_weight", usual.direction_weight);
    let stimulation_rate = weight("stimulation_rate", usual.stimulation_rate);
    let antigen_rate = weight("antigen_rate", usual.antigen_rate);
    let death_rate = weight("death_rate", usual.death_rate);
    let t_cell_rate = weight("t_cell_rate", usual.t_cell_rate);
    let spread_best = table.number("spread_best", 0.0..=1.0, Some(usual.spread_best));
    let near_cells = table.number("near_cells", 0.0..=1000.0, Some(usual.near_cells));
    let far_cells = table.number("far_cells", 0.0..=1000.0, Some(usual.far_cells));
    let affinity_share = table.number("affinity_share", 0.0..=1.0, Some(usual.affinity_share));
    let global_steps = table.integer_u32("global_steps", 1..=100_000, Some(usual.global_steps));
    let population = table.integer_u32("population", 2..=1000, u32::try_from(usual.population).ok());
    let generations = table.integer_u32("generations", 1..=1000, Some(usual.generations));
    const READINGS: [(&str, AffinityReading); 3] = [
        ("normalised", AffinityReading::Normalised),
        ("clamped", AffinityReading::Clamped),
        ("raw", AffinityReading::Raw),
    ];
    let affinity = among(table, false, "affinity", READINGS, 0);
    const SUPPRESSIONS: [(&str, Suppression); 2] =
        [("repaired", Suppression::Repaired), ("printed", Suppression::Printed)];
    let suppression = among(table, false, "suppression", SUPPRESSIONS, 0);
    let closed_form = table.bool("closed_form", Some(usual.closed_form));
    Some(Explore {
        obstacle_weight: obstacle_weight?,
        unknown_weight: unknown_weight?,
        spread_weight: spread_weight?,
        direction_weight: direction_weight?,
        stimulation_rate: stimulation_rate?,
        antigen_rate: antigen_rate?,
        death_rate: death_rate?,
        t_cell_rate: t_cell_rate?,
        spread_best: spread_best?,
        near_cells: near_cells?,
        far_cells: far_cells?,
        affinity_share: affinity_share?,
        global_steps: global_steps?,
        population: population? as usize,
        generations: generations?,
        affinity: affinity?,
        suppression: suppression?,
        closed_form: closed_form?,
        ..usual
    })
}

/// What ships has of its own.
fn ours(table: &mut Table<'_>, usual: Explore) -> Option<Explore> {
    let hug_weight = table.number("hug_weight", 0.0..=100.0, Some(usual.hug_weight));
    let others_weight = table.number("others_weight", 0.0..=1.0, Some(usual.others_weight));
    let claimed_weight = table.number("claimed_weight", 0.0..=1.0, Some(usual.claimed_weight));
    let finish = among(table, false, "finish", [("fast", Finish::Fast), ("whole", Finish::Whole)], 0);
    Some(Explore {
        hug_weight: hug_weight?,
        others_weight: others_weight?,
        claimed_weight: claimed_weight?,
        finish: finish?,
        ..usual
    })
}
