//! The cheapest assignment of robots to candidates (Kuhn 1955, by the `pathfinding` crate).
//!
//! Each robot brings its [`KEPT`] cheapest candidates: more would cost the square of their number, and one that is not
//! among anybody's cheapest is nobody's part. Neighbouring cells are candidates of their own, as in the paper; nothing
//! keeps two robots from going to two of them (Wurm 2008 groups them for that).

use super::super::value::Candidate;
use super::super::view::View;
use super::Classic;
use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// Candidates that each robot brings.
const KEPT: usize = 24;
/// Costs as whole numbers.
const SCALE: f64 = 1e4;
/// What a robot cannot reach, and having no candidate.
const NEVER: i64 = 1 << 40;

impl Classic {
    /// The own part.
    pub(super) fn hungarian(&mut self, view: &View<'_>, candidates: &[Candidate]) -> Option<usize> {
        let others = self.spread_others(view, |mate| mate.at);
        let own = candidates.iter().map(|one| self.price(one, Some(one.steps))).collect::<Vec<i64>>();
        let of_other = |other: usize| {
            let steps = |one: &Candidate| self.fields[other].steps(one.cell).map(|steps| f64::from(steps.max(1)));
            candidates.iter().map(|one| self.price(one, steps(one))).collect()
        };
        // By rank: of several cheapest assignments all must work out the same, so all must solve the same matrix.
        let mut rows: Vec<Vec<i64>> = (0..others).map(of_other).collect();
        let me = view.others().take_while(|(rank, _)| *rank < view.own).count();
        rows.insert(me, own);
        let kept = kept(&rows);
        let columns = kept.len().max(rows.len());
        let cost = |row: usize, column: usize| kept.get(column).map_or(NEVER, |index| rows[row][*index]);
        let all = (0..rows.len()).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let costs: Vec<i64> = all.map(|(row, column)| cost(row, column)).collect();
        let matrix = Matrix::from_vec(rows.len(), columns, costs).ok()?;
        let (_, columns_of) = kuhn_munkres_min(&matrix);
        let part = kept.get(columns_of[me]).filter(|index| rows[me][**index] < NEVER);
        // Fewer candidates than robots: who has no part goes where it would alone.
        let cheapest = || (0..candidates.len()).min_by_key(|index| rows[me][*index]);
        part.copied().or_else(cheapest).map(|index| candidates[index].cell)
    }

    fn price(&self, candidate: &Candidate, steps: Option<f64>) -> i64 {
        steps.map_or(NEVER, |steps| (self.cost(candidate, steps) * SCALE).min(1e11) as i64)
    }
}

/// Everybody's cheapest candidates.
fn kept(rows: &[Vec<i64>]) -> Vec<usize> {
    let mut kept = Vec::new();
    for row in rows {
        let mut order: Vec<usize> = (0..row.len()).collect();
        let count = KEPT.min(order.len());
        if count > 0 {
            order.select_nth_unstable_by_key(count - 1, |index| (row[*index], *index));
        }
        kept.extend(&order[..count]);
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::super::Classic;
    use crate::law::explore::view::{Choose, Mate, View};
    use crate::map::{Board, Field, Known, Sight, Unknowns};
    use drover_config::{CandidateValue, Explore, ExploreMethod};

    const SIDE: usize = 9;

    /// A free room in the middle with a few obstacles; its rim is the frontier.
    fn room(seed: usize) -> Board {
        let mut board = Board::new(SIDE, SIDE);
        for cell in 0..SIDE * SIDE {
            let within = [cell % SIDE, cell / SIDE].iter().all(|at| (2..7).contains(at));
            let solid = (cell * 31 + seed * 17).is_multiple_of(7);
            if within {
                board.learn(cell, if solid { Known::Occupied } else { Known::Free });
            }
        }
        board
    }

    fn waves(board: &Board, cells: &[usize]) -> Vec<Field> {
        let wave = |cell: &usize| {
            let mut field = Field::default();
            field.spread(board, *cell, Unknowns::Solid);
            field
        };
        cells.iter().map(wave).collect()
    }

    /// What each robot works out to be its own part.
    fn parts(board: &Board, cells: &[usize], fields: &[Field]) -> Vec<usize> {
        let params = Explore { value: CandidateValue::Cost, ..Explore::usual(ExploreMethod::Hungarian) };
        let mates: Vec<Option<Mate>> = cells.iter().map(|at| Some(Mate { at: *at, target: None })).collect();
        let (sight, finders) = (Sight::new(2), vec![0; board.count()]);
        let part = |own: usize| {
            let view = View { board, walls: board, finders: &finders, mates: &mates, own, sight: &sight, step: 1 };
            Classic::new(&params).choose(&view, &fields[own])
        };
        (0..cells.len()).filter_map(part).collect()
    }

    /// The least sum of steps of three robots to three cells, by trying all.
    fn least(candidates: &[usize], fields: &[Field]) -> u32 {
        let steps = |robot: usize, cell: usize| fields[robot].steps(cell).unwrap_or(1000);
        let mut least = u32::MAX;
        for (a, b) in candidates.iter().flat_map(|a| candidates.iter().map(move |b| (*a, *b))) {
            for c in candidates.iter().copied().filter(|c| a != b && *c != a && *c != b) {
                least = least.min(steps(0, a) + steps(1, b) + steps(2, c));
            }
        }
        least
    }

    #[test]
    fn all_work_out_the_same_assignment_and_none_is_cheaper() {
        let mut tried = 0;
        for seed in 0..60 {
            let board = room(seed);
            let free = |cell: &usize| board.at(*cell) == Known::Free && !board.is_frontier(*cell);
            let inside: Vec<usize> = (0..board.count()).filter(free).collect();
            let candidates: Vec<usize> = board.frontier().collect();
            if inside.len() < 3 || candidates.len() < 3 {
                continue;
            }
            let cells = [0, 1, 2].map(|rank| inside[(seed * 5 + rank) % inside.len()]);
            let fields = waves(&board, &cells);
            let reached = |cell: &usize| fields.iter().all(|field| field.steps(*cell).is_some());
            if !candidates.iter().all(reached) {
                continue;
            }
            let parts = parts(&board, &cells, &fields);
            let sum: u32 = (0..3).filter_map(|robot| fields[robot].steps(parts[robot])).sum();
            assert!(parts[0] != parts[1] && parts[0] != parts[2] && parts[1] != parts[2], "seed {seed}: {parts:?}");
            assert_eq!(sum, least(&candidates, &fields), "seed {seed}: {parts:?}");
            tried += 1;
        }
        assert!(tried >= 20, "only {tried} rooms were of use");
    }
}
