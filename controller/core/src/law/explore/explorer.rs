//! One robot that explores: it keeps a target until it is reached, seen through or worth less than another, and goes
//! one step at a time.

use super::view::{Chooser, View};
use crate::map::{Field, Unknowns};
use drover_config::Explore;

/// What a robot does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Move {
    /// Where it goes in the end; none if nothing is left.
    pub target: Option<usize>,
    /// The neighbour to which it goes now; none if it stays.
    pub next: Option<usize>,
    /// Whether the target was chosen now.
    pub chosen: bool,
}

/// A robot that explores.
#[derive(Clone, Debug)]
pub struct Explorer {
    chooser: Chooser,
    target: Option<usize>,
    field: Field,
}

impl Explorer {
    /// A robot without a target.
    #[must_use]
    pub fn new(params: &Explore) -> Self {
        Self { chooser: Chooser::new(params), target: None, field: Field::default() }
    }

    /// One step. Deterministic: the same views lead to the same moves.
    pub fn step(&mut self, view: &View<'_>) -> Move {
        let at = view.at();
        let unknowns = self.unknowns();
        let chooser = self.chooser.get_mut();
        if chooser.ways().is_none() {
            self.field.spread(view.board, at, unknowns);
        }
        let good =
            |target: &usize| *target != at && chooser.still_good(view, *target) && self.field.steps(*target).is_some();
        let kept = self.target.filter(|_| !chooser.reconsiders(view)).filter(good);
        let target = kept.or_else(|| chooser.choose(view, &self.field));
        let chosen = kept.is_none() && target.is_some();
        self.target = target;
        Move { target, next: target.and_then(|target| self.next(view, unknowns, target)), chosen }
    }

    fn next(&self, view: &View<'_>, unknowns: Unknowns, target: usize) -> Option<usize> {
        let field = self.chooser.get().ways().unwrap_or(&self.field);
        field.first_step(view.board, unknowns, target).filter(|next| *next != view.at())
    }

    /// How its ways lead through what is unknown.
    #[must_use]
    pub fn unknowns(&self) -> Unknowns {
        self.chooser.get().unknowns()
    }

    /// Forget the target: the way to it is taken by somebody who does not move.
    pub fn forget(&mut self) {
        self.target = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Board, Known, Sight};
    use drover_config::ExploreMethod;

    #[test]
    fn nothing_left_is_no_target_and_a_frontier_is_gone_to() {
        let mut board = Board::new(9, 3);
        let sight = Sight::new(2);
        let finders = vec![0; board.count()];
        (0..27).filter(|cell| cell % 9 < 6).for_each(|cell| {
            board.learn(cell, Known::Free);
        });
        let mates = [Some(super::super::view::Mate { at: 9, target: None })];
        let methods = [ExploreMethod::Nearest, ExploreMethod::Inea, ExploreMethod::Basic, ExploreMethod::Sweep];
        for method in methods {
            let mut explorer = Explorer::new(&Explore::usual(method));
            let view =
                View { board: &board, walls: &board, finders: &finders, mates: &mates, own: 0, sight: &sight, step: 1 };
            let moved = explorer.step(&view);
            assert!(moved.target.is_some() && moved.chosen, "{method:?}");
            assert_eq!(moved.next.map(|next| next % 9), Some(1), "{method:?}");
        }
        (0..27).for_each(|cell| {
            board.learn(cell, Known::Free);
        });
        for method in methods {
            let mut explorer = Explorer::new(&Explore::usual(method));
            let view =
                View { board: &board, walls: &board, finders: &finders, mates: &mates, own: 0, sight: &sight, step: 1 };
            assert_eq!(explorer.step(&view), Move { target: None, next: None, chosen: false }, "{method:?}");
        }
    }
}
