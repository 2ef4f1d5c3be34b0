//! The paper's method, INEA, and the basic immune network that it compares with (Wu 2008, section 3).
//!
//! **Local**, when a target is reached or no frontier any more: of the candidates that this robot saw first, those with
//! more than `affinity_share` of the best affinity (eq. 15, of which the upper bound is empty); one of them alone is
//! taken, of several the one of the greatest stimulation (eq. 14).
//!
//! **Global**, every `global_steps` steps: the `population` best candidates of all, whoever saw them, go through the
//! network ([`super::network`]).
//!
//! The basic network knows its own points alone and no direction (w4 = 0), and decides by the network both times.
//! Either takes all candidates if it has none of its own: the paper does not say what happens then, and a robot that
//! waits would be no exploration.

use super::network::{Antibody, Network, Restraint, closed_form};
use super::value::{Candidate, Values, best_by};
use super::view::{Choose, View};
use crate::map::{Field, Unknowns};
use drover_config::{AffinityReading, Explore, ExploreMethod};

/// Either of the two.
#[derive(Clone, Debug)]
pub(super) struct Immune {
    values: Values,
    network: Network,
    improved: bool,
    affinity_share: f64,
    global_steps: u32,
    population: usize,
    reading: AffinityReading,
    closed_form: bool,
}

impl Immune {
    pub(super) fn new(params: &Explore) -> Self {
        let improved = params.method == ExploreMethod::Inea;
        let direction_weight = if improved { params.direction_weight } else { 0.0 };
        Self {
            values: Values::new(&Explore { direction_weight, ..params.clone() }),
            network: Network::new(params, Restraint::of(params)),
            improved,
            affinity_share: params.affinity_share,
            global_steps: params.global_steps.max(1),
            population: params.population,
            reading: params.affinity,
            // What it stands for is the T cell's equilibrium.
            closed_form: params.closed_form && improved && params.t_cell_rate > 0.0,
        }
    }

    fn is_global(&self, view: &View<'_>) -> bool {
        view.step.is_multiple_of(self.global_steps)
    }

    fn local(&self, view: &View<'_>, candidates: &[Candidate]) -> Option<usize> {
        let best = best_by(candidates, Candidate::affinity)?;
        let enough = self.affinity_share * best.affinity();
        let good: Vec<Candidate> = candidates.iter().filter(|one| one.affinity() > enough).copied().collect();
        match good[..] {
            [] => Some(best.cell),
            [alone] => Some(alone.cell),
            _ => best_by(&good, |one| self.values.stimulation(view, one.cell)).map(|one| one.cell),
        }
    }

    /// The best candidates, and as what they are in the network.
    fn antibodies(&self, view: &View<'_>, mut candidates: Vec<Candidate>) -> (Vec<Candidate>, Vec<Antibody>) {
        candidates.sort_by(|a, b| b.affinity().total_cmp(&a.affinity()).then(a.cell.cmp(&b.cell)));
        candidates.truncate(self.population);
        let best = candidates.first().map_or(1.0, Candidate::affinity);
        let antibody = |one: &Candidate| Antibody {
            affinity: match self.reading {
                AffinityReading::Normalised => one.affinity() / best,
                AffinityReading::Clamped => one.affinity().min(1.0),
                AffinityReading::Raw => one.affinity(),
            },
            stimulation: self.values.stimulation(view, one.cell),
        };
        let antibodies = candidates.iter().map(antibody).collect();
        (candidates, antibodies)
    }

    fn by_network(&self, view: &View<'_>, candidates: Vec<Candidate>) -> Option<usize> {
        let (candidates, antibodies) = self.antibodies(view, candidates);
        let winner = if self.closed_form { closed_form(&antibodies) } else { self.network.winner(&antibodies) };
        winner.map(|index| candidates[index].cell)
    }
}

/// The antibodies of a robot's global decision, for who looks into the network: of each its affinity, as `params` reads
/// it, and its stimulation (eq. 14); the greatest affinity first.
#[must_use]
pub fn population(params: &Explore, view: &View<'_>) -> Vec<[f64; 2]> {
    let immune = Immune::new(params);
    let mut field = Field::default();
    field.spread(view.board, view.at(), Unknowns::Solid);
    let (_, antibodies) = immune.antibodies(view, immune.values.candidates(view, &field, |_| true));
    antibodies.iter().map(|body| [body.affinity, body.stimulation]).collect()
}

impl Choose for Immune {
    fn reconsiders(&self, view: &View<'_>) -> bool {
        self.is_global(view)
    }

    fn choose(&mut self, view: &View<'_>, field: &Field) -> Option<usize> {
        let of_all = || self.values.candidates(view, field, |_| true);
        let of_own = || {
            let own = self.values.candidates(view, field, |cell| usize::from(view.finders[cell]) == view.own);
            if own.is_empty() { of_all() } else { own }
        };
        match (self.improved, self.is_global(view)) {
            (true, true) => self.by_network(view, of_all()),
            (true, false) => self.local(view, &of_own()),
            (false, _) => self.by_network(view, of_own()),
        }
    }
}
