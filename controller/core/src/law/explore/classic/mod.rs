//! Classical methods, each as a baseline: with the paper's eq. 9 as what a candidate is worth (a cost of steps over
//! worth), or with plain steps.
//!
//! | method | goes to the candidate |
//! |---|---|
//! | nearest | of the fewest steps, whatever `value` (Yamauchi 1997) |
//! | greedy | of the greatest affinity, whatever `value` and the others do |
//! | burgard | of the greatest utility over cost; utility falls near others' targets (Burgard 2005, as a quotient) |
//! | hungarian | that is its part of the cheapest assignment of all robots ([`hungarian`]) |
//! | min_pos | to which the fewest others are nearer, of those the cheapest (Bautin 2012) |
//! | market | for which nobody bids less ([`market`]) |
//!
//! Each robot works out everybody's part for itself and takes its own: nobody waits for a message. A target is kept
//! until it is reached or no frontier any more. **Cost**: the waves of all robots over the map.

mod hungarian;
mod market;

use super::value::{Candidate, Values, best_by, distance};
use super::view::{Choose, Mate, View};
use crate::map::{Field, Unknowns};
use drover_config::{CandidateValue, Explore, ExploreMethod};

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Classic {
    method: ExploreMethod,
    values: Values,
    value: CandidateValue,
    /// Utility falls within this of another's target, cells.
    apart_cells: f64,
    /// Others' ways; kept for their memory.
    fields: Vec<Field>,
}

impl Classic {
    pub(super) fn new(params: &Explore) -> Self {
        Self {
            method: params.method,
            values: Values::new(params),
            value: params.value,
            apart_cells: params.far_cells,
            fields: Vec::new(),
        }
    }

    /// What going there costs one to whom it is so many steps.
    fn cost(&self, candidate: &Candidate, steps: f64) -> f64 {
        match self.value {
            CandidateValue::Affinity => steps / candidate.worth,
            CandidateValue::Cost => steps,
        }
    }

    fn burgard(&self, view: &View<'_>, candidates: &[Candidate]) -> Option<usize> {
        let utility = |one: &Candidate| {
            let near = |target: usize| (1.0 - distance(view.board, one.cell, target) / self.apart_cells).max(0.0);
            let taken: f64 = view.others().filter_map(|(_, mate)| mate.target).map(near).sum();
            // Something is left of it, or one whom all stand around would go nowhere in particular.
            (1.0 - taken).max(1e-3)
        };
        best_by(candidates, |one| utility(one) / self.cost(one, one.steps)).map(|one| one.cell)
    }

    fn min_pos(&mut self, view: &View<'_>, candidates: &[Candidate]) -> Option<usize> {
        let others = self.spread_others(view, |mate| mate.at);
        let rank = |one: &Candidate| {
            let nearer = |field: &&Field| field.steps(one.cell).is_some_and(|steps| f64::from(steps) < one.steps);
            self.fields[..others].iter().filter(nearer).count()
        };
        let ranks: Vec<usize> = candidates.iter().map(rank).collect();
        let least = ranks.iter().min()?;
        let first = candidates.iter().zip(&ranks).filter(|(_, rank)| *rank == least);
        let first: Vec<Candidate> = first.map(|(one, _)| *one).collect();
        best_by(&first, |one| -self.cost(one, one.steps)).map(|one| one.cell)
    }

    /// Others' ways from a cell of each, into the first of `fields`; how many they are.
    fn spread_others(&mut self, view: &View<'_>, from: impl Fn(&Mate) -> usize) -> usize {
        let mut count = 0;
        for (_, mate) in view.others() {
            if self.fields.len() == count {
                self.fields.push(Field::default());
            }
            self.fields[count].spread(view.board, from(&mate), Unknowns::Solid);
            count += 1;
        }
        count
    }
}

impl Choose for Classic {
    fn reconsiders(&self, _view: &View<'_>) -> bool {
        false
    }

    fn choose(&mut self, view: &View<'_>, field: &Field) -> Option<usize> {
        let candidates = self.values.candidates(view, field, |_| true);
        match self.method {
            ExploreMethod::Nearest => best_by(&candidates, |one| -one.steps).map(|one| one.cell),
            ExploreMethod::Burgard => self.burgard(view, &candidates),
            ExploreMethod::Hungarian => self.hungarian(view, &candidates),
            ExploreMethod::MinPos => self.min_pos(view, &candidates),
            ExploreMethod::Market => self.market(view, &candidates),
            ExploreMethod::Greedy | ExploreMethod::Sweep | ExploreMethod::Inea | ExploreMethod::Basic => {
                best_by(&candidates, Candidate::affinity).map(|one| one.cell)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Board, Known, Sight};

    /// A corridor of which the middle is known; robots stand where `cells` says.
    fn choice(method: ExploreMethod, cells: [usize; 2], targets: [Option<usize>; 2]) -> [Option<usize>; 2] {
        let mut board = Board::new(21, 3);
        (0..63).filter(|cell| (5..16).contains(&(cell % 21))).for_each(|cell| {
            board.learn(cell, if cell / 21 == 1 { Known::Free } else { Known::Occupied });
        });
        let sight = Sight::new(2);
        let mates = [0, 1].map(|rank| Some(Mate { at: cells[rank], target: targets[rank] }));
        [0, 1].map(|own| {
            let view =
                View { board: &board, walls: &board, finders: &[0; 63], mates: &mates, own, sight: &sight, step: 1 };
            let mut field = Field::default();
            field.spread(&board, cells[own], Unknowns::Solid);
            Classic::new(&Explore::usual(method)).choose(&view, &field)
        })
    }

    const WEST: Option<usize> = Some(21 + 5);
    const EAST: Option<usize> = Some(21 + 15);

    #[test]
    fn those_who_coordinate_go_to_two_ends_where_others_go_to_one() {
        // Both are nearer to the west.
        let cells = [21 + 7, 21 + 9];
        assert_eq!(choice(ExploreMethod::Nearest, cells, [None; 2]), [WEST, WEST]);
        assert_eq!(choice(ExploreMethod::Greedy, cells, [None; 2]), [WEST, WEST]);
        for method in [ExploreMethod::MinPos, ExploreMethod::Hungarian] {
            assert_eq!(choice(method, cells, [None; 2]), [WEST, EAST], "{method:?}");
        }
        // One has said where it goes.
        for method in [ExploreMethod::Burgard, ExploreMethod::Market] {
            assert_eq!(choice(method, cells, [WEST, None])[1], EAST, "{method:?}");
        }
    }
}
