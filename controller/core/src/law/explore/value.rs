//! What a candidate is worth by itself (eq. 9) and beside the others (eq. 10 to 14). Wu 2008, section 3.
//!
//! Candidates are frontier cells that can be reached. Distances are in cells between middles, bearings from a robot to
//! a point counter-clockwise from the east. Departures from print, with reasons in our reading of the paper: r_t for
//! r_i in eq. 10, the absolute difference in eq. 12, sums over j in eq. 13.

use super::view::View;
use crate::map::{Board, Field};
use drover_config::Explore;
use drover_contract::math::atan2;
use std::f64::consts::TAU;

/// Obstacles near a candidate count up to this many more than none (eq. 9: 1 to 10).
const OBSTACLES_MAX: usize = 9;
/// What eq. 11 adds to the squared distance from the best, so that nothing is divided by nought.
const SPREAD_FLOOR: f64 = 0.1;

/// A cell to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) cell: usize,
    /// From where the robot stands, at least one.
    pub(super) steps: f64,
    /// The numerator of eq. 9.
    pub(super) worth: f64,
}

impl Candidate {
    /// g (eq. 9), before anything makes it lie within 0 and 1.
    pub(super) fn affinity(&self) -> f64 {
        self.worth / self.steps
    }
}

/// The parameters of value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values {
    obstacle_weight: f64,
    unknown_weight: f64,
    spread_weight: f64,
    direction_weight: f64,
    spread_best: f64,
    near_cells: f64,
    far_cells: f64,
}

impl Values {
    pub(super) fn new(params: &Explore) -> Self {
        Self {
            obstacle_weight: params.obstacle_weight,
            unknown_weight: params.unknown_weight,
            spread_weight: params.spread_weight,
            direction_weight: params.direction_weight,
            spread_best: params.spread_best,
            near_cells: params.near_cells,
            far_cells: params.far_cells,
        }
    }

    /// All candidates that `field` reaches and `counts` lets count, the lowest cell first.
    pub(super) fn candidates(&self, view: &View<'_>, field: &Field, counts: impl Fn(usize) -> bool) -> Vec<Candidate> {
        let there = |cell: usize| field.steps(cell).filter(|steps| *steps > 0).map(|steps| (cell, f64::from(steps)));
        let reached = view.board.frontier().filter(|cell| counts(*cell)).filter_map(there);
        reached.map(|(cell, steps)| Candidate { cell, steps, worth: self.worth(view, cell) }).collect()
    }

    /// w1 obstacle + w2 benefit (eq. 9).
    pub(super) fn worth(&self, view: &View<'_>, cell: usize) -> f64 {
        let [unknown, occupied] = view.counts(cell);
        let obstacle = 1 + occupied.min(OBSTACLES_MAX);
        self.obstacle_weight * obstacle as f64 + self.unknown_weight * unknown as f64
    }

    /// m (eq. 14).
    pub(super) fn stimulation(&self, view: &View<'_>, cell: usize) -> f64 {
        self.spread_weight / self.spread(view, cell) + self.direction_weight * self.direction(view, cell)
    }

    /// tau (eq. 10): a robot's effect at a distance.
    pub(super) fn effect(&self, distance_cells: f64) -> f64 {
        if distance_cells <= self.near_cells {
            1.0
        } else if distance_cells <= self.far_cells {
            libm::exp(-(distance_cells - self.near_cells) / (self.far_cells - self.near_cells))
        } else {
            0.0
        }
    }

    /// T (eq. 11); the robot's own effect counts as 1.
    fn spread(&self, view: &View<'_>, cell: usize) -> f64 {
        let others: f64 = view.others().map(|(_, mate)| self.effect(distance(view.board, cell, mate.at))).sum();
        let mean = (1.0 + others) / view.team().max(1) as f64;
        (mean - self.spread_best) * (mean - self.spread_best) + SPREAD_FLOOR
    }

    /// F (eq. 13): how far its bearing is from those to where the others go, or stand.
    fn direction(&self, view: &View<'_>, cell: usize) -> f64 {
        let own = bearing(view.board, view.at(), cell);
        let apart = |target: usize, at: usize| turn_apart(own, bearing(view.board, at, target));
        let sum: f64 = view.others().map(|(_, mate)| apart(mate.target.unwrap_or(mate.at), mate.at)).sum();
        sum / view.team().max(1) as f64
    }
}

/// f (eq. 12) of two bearings: 0 if they are the same, 1 if they are opposite.
fn turn_apart(a_rad: f64, b_rad: f64) -> f64 {
    let share = (a_rad - b_rad).abs() / TAU - 0.5;
    1.0 - 4.0 * share * share
}

/// Between the middles of two cells, cells.
pub(super) fn distance(board: &Board, a: usize, b: usize) -> f64 {
    let [[ax, ay], [bx, by]] = [board.place(a), board.place(b)];
    libm::hypot(f64::from(ax - bx), f64::from(ay - by))
}

/// 0..TAU.
fn bearing(board: &Board, from: usize, to: usize) -> f64 {
    let [[ax, ay], [bx, by]] = [board.place(from), board.place(to)];
    atan2(f64::from(by - ay), f64::from(bx - ax)).rem_euclid(TAU)
}

/// The candidate of the greatest score; of several the first.
pub(super) fn best_by(candidates: &[Candidate], score: impl Fn(&Candidate) -> f64) -> Option<&Candidate> {
    let mut best: Option<(&Candidate, f64)> = None;
    for candidate in candidates {
        let score = score(candidate);
        if best.is_none_or(|(_, best)| score > best) {
            best = Some((candidate, score));
        }
    }
    best.map(|(candidate, _)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::explore::view::Mate;
    use crate::map::{Known, Sight};
    use drover_config::ExploreMethod;
    use std::f64::consts::PI;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn effect_and_direction_are_the_paper_s() {
        let values = Values::new(&Explore::usual(ExploreMethod::Inea));
        assert!(close(values.effect(4.0), 1.0) && close(values.effect(10.1), 0.0));
        assert!(close(values.effect(10.0), libm::exp(-1.0)) && close(values.effect(7.0), libm::exp(-0.5)));
        assert!(close(turn_apart(1.0, 1.0), 0.0) && close(turn_apart(0.0, PI), 1.0));
        assert!(close(turn_apart(0.0, PI / 2.0), 0.75) && close(turn_apart(0.0, 3.0 * PI / 2.0), 0.75));
    }

    #[test]
    fn worth_counts_the_square_and_stimulation_the_others() {
        let mut board = Board::new(9, 9);
        let sight = Sight::new(2);
        // Around the middle: two occupied cells, three unknown, the rest free.
        (0..81).filter(|cell| ![22, 23, 24].contains(cell)).for_each(|cell| {
            board.learn(cell, if [40 + 2, 40 - 2].contains(&cell) { Known::Occupied } else { Known::Free });
        });
        let mates = [Some(Mate { at: 40, target: None }), Some(Mate { at: 36, target: Some(44) }), None];
        let view =
            View { board: &board, walls: &board, finders: &[0; 81], mates: &mates, own: 0, sight: &sight, step: 0 };
        let values = Values::new(&Explore::usual(ExploreMethod::Inea));
        assert!(close(values.worth(&view, 40), 0.5 * 3.0 + 0.1 * 3.0));
        // Two are known: the other's effect at 4 cells is 1, the mean 1; it goes east, this would go west.
        let spread = (1.0_f64 - 0.4) * (1.0 - 0.4) + 0.1;
        let at_west = 37;
        assert!(close(values.effect(distance(&board, at_west, 36)), 1.0));
        assert!(close(values.stimulation(&view, at_west), 1.0 / spread + 0.8 * 0.5));
    }

    #[test]
    fn obstacles_count_ten_at_most_and_a_step_at_least_is_the_cost() {
        let mut board = Board::new(9, 9);
        let sight = Sight::new(2);
        // The east is unknown, the west is a wall but for a corridor.
        (0..81).filter(|cell| cell % 9 < 5).for_each(|cell| {
            board.learn(cell, if cell / 9 == 4 { Known::Free } else { Known::Occupied });
        });
        let mates = [Some(Mate { at: 38, target: None })];
        let view =
            View { board: &board, walls: &board, finders: &[0; 81], mates: &mates, own: 0, sight: &sight, step: 0 };
        let values = Values::new(&Explore::usual(ExploreMethod::Inea));
        // Around 40: twelve occupied cells count as nine and one; ten cells are unknown.
        assert_eq!(view.counts(40), [10, 12]);
        assert!(close(values.worth(&view, 40), 0.5 * 10.0 + 0.1 * 10.0));
        let mut field = Field::default();
        field.spread(&board, 38, crate::map::Unknowns::Solid);
        let candidates = values.candidates(&view, &field, |_| true);
        assert_eq!(candidates.iter().map(|one| one.cell).collect::<Vec<_>>(), [40]);
        assert!(close(candidates[0].affinity(), 6.0 / 2.0));
        // One stands on it: it is no candidate.
        field.spread(&board, 40, crate::map::Unknowns::Solid);
        assert!(values.candidates(&view, &field, |_| true).is_empty());
    }

    #[test]
    fn one_neighbour_at_seven_cells_is_best_and_none_near_is_worse() {
        let board = Board::new(60, 3);
        let sight = Sight::new(2);
        let values = Values::new(&Explore::usual(ExploreMethod::Inea));
        let spread = |others: [usize; 3]| {
            let mate = |at: usize| Some(Mate { at, target: None });
            let mates = [mate(0), mate(others[0]), mate(others[1]), mate(others[2])];
            let view = View {
                board: &board,
                walls: &board,
                finders: &[0; 180],
                mates: &mates,
                own: 0,
                sight: &sight,
                step: 0,
            };
            values.spread(&view, 0)
        };
        // Sum of effects n mu = 1.6: one neighbour, at 4 - 6 ln 0.6 = 7.06 cells; 8.16 for being alone (section 2).
        let (alone, near, crowd) = (spread([40, 50, 59]), spread([7, 50, 59]), spread([1, 2, 3]));
        assert!((1.0 / near - 10.0).abs() < 0.01, "{near}");
        assert!(close(alone, (0.25_f64 - 0.4) * (0.25 - 0.4) + 0.1) && (1.0 / alone - 8.16).abs() < 0.01);
        assert!(close(crowd, 0.6 * 0.6 + 0.1));
    }
}
