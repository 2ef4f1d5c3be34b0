//! What ships: each robot takes the walk that sees most in the next steps, and if little is near, goes to where most is
//! left for the way.
//!
//! **In**: the map, everybody's cell and target. **Out**: the cell to go to, known or not, anew at every step.
//!
//! **Idea**: an unknown cell has a weight. The best of all short walks ([`ahead`]) is worth the weights that it sees a
//! step; a part of the place that is farther ([`afar`]) is worth the unknown cells that it brings a step, with the way
//! there and without what others see until then. Whichever is more is done.
//!
//! - *Hug what is known*: a cell counts 1 + lambda times the known part of its eight neighbours, so that lanes lie side
//!   by side and no sliver is left between them.
//! - *Keep apart*: what another robot is nearer to counts `others_weight`, what another is about to see
//!   `claimed_weight`. Nobody negotiates; a robot that says nothing has no part.
//! - *Nobody stares at stone*: unknown cells that nobody can reach count nothing.
//! - *Finish* (`finish = "whole"`): cells of small unknown pockets count up to five times, so that one is emptied while
//!   a robot is near, and not by a journey at the end.
//! - *It ends*: whose map has not grown for long, because two things are worth as much and it turns from one to the
//!   other, goes to the nearest frontier cell until something is learnt.
//!
//! **Cost**: walks of a few steps; and waves over the known cells if little is near.
//!
//! **Cannot solve**: a tour of all that is left, as one would make it on a map: the last corners come in the order in
//! which each is worth the way. `None` if no frontier cell can be reached: that is the end.

mod afar;
mod ahead;
mod weights;

use super::view::{Choose, View};
use crate::map::{Board, Field, Owners, Unknowns};
use afar::Afar;
use ahead::{Ahead, Plan};
use drover_config::{Explore, Finish};
use weights::{Pockets, Weights};

/// What is near counts this much more than what is far: to come back for it would be a journey, too. Less leaves more
/// for the end, more keeps robots at crumbs.
const NEAR_WEIGHT: f64 = 2.0;
/// Whose a cell is, is found up to this far, steps: as far as short walks see.
const OWNED_STEPS: u32 = 20;
/// The ways to ends of short walks are known this far.
const WALK_STEPS: u32 = 16;
/// Whose map has not grown in as many steps as its sides are long together, over this, goes to what is nearest: longer
/// than most journeys, so that it is for none but who turns to and fro.
const PATIENCE_SHARE: usize = 2;

/// The method.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    hug_weight: f64,
    others_weight: f64,
    claimed_weight: f64,
    whole: bool,
    field: Field,
    owners: Owners,
    weights: Weights,
    pockets: Pockets,
    ahead: Ahead,
    afar: Afar,
    patience: Patience,
}

impl Sweep {
    pub(super) fn new(params: &Explore) -> Self {
        Self {
            hug_weight: params.hug_weight,
            others_weight: params.others_weight,
            claimed_weight: params.claimed_weight,
            whole: params.finish == Finish::Whole,
            field: Field::default(),
            owners: Owners::default(),
            weights: Weights::default(),
            pockets: Pockets::default(),
            ahead: Ahead::default(),
            afar: Afar::default(),
            patience: Patience::default(),
        }
    }

    /// Everybody's part of what is near, and what others are about to see.
    fn prepare(&mut self, view: &View<'_>) {
        let own = view.mates[view.own].into_iter();
        // Itself first: what two are as near to is worth looking at to both.
        let cells = own.map(|mate| mate.at).chain(view.others().map(|(_, mate)| mate.at));
        self.owners.begin(view.board, cells);
        self.owners.extend(view.board, Unknowns::Free, OWNED_STEPS);
        self.weights.begin(view.board.count());
        self.pockets.begin(view.board.count());
        for target in view.others().filter_map(|(_, mate)| mate.target) {
            let weights = &mut self.weights;
            view.sight.look(view.board, target, |cell| view.blocks(cell), |cell| weights.claim(cell));
        }
    }

    fn weight(&mut self, board: &Board, cell: usize) -> f64 {
        if let Some(weight) = self.weights.get(cell) {
            return weight;
        }
        let weight = match self.owners.of(cell) {
            None => 0.0,
            Some(owner) => {
                let hug = 1.0 + self.hug_weight * f64::from(board.known_around(cell)) / 8.0;
                let others = if owner == 0 { 1.0 } else { self.others_weight };
                let claimed = if self.weights.is_claimed(cell) { self.claimed_weight } else { 1.0 };
                let pocket = if self.whole { self.pockets.factor(board, cell) } else { 1.0 };
                hug * others * claimed * pocket
            }
        };
        self.weights.put(cell, weight);
        weight
    }

    /// The best short walk.
    fn near(&mut self, view: &View<'_>) -> Option<Plan> {
        self.prepare(view);
        let mut ahead = core::mem::take(&mut self.ahead);
        let plan = ahead.plan(view, |cell| self.weight(view.board, cell));
        self.ahead = ahead;
        plan
    }

    fn follow(&mut self, view: &View<'_>, plan: Plan) -> usize {
        self.field.begin(view.board, view.at());
        self.field.extend(view.board, Unknowns::Free, WALK_STEPS);
        self.field.lead(plan.end, plan.first);
        plan.end
    }

    /// A frontier cell, over known cells all the way.
    fn lead_to(&mut self, view: &View<'_>, cell: usize) -> usize {
        if let Some(first) = self.field.first_step(view.board, Unknowns::Solid, cell) {
            self.field.lead(cell, first);
        }
        cell
    }
}

impl Choose for Sweep {
    fn reconsiders(&self, _view: &View<'_>) -> bool {
        true
    }

    fn unknowns(&self) -> Unknowns {
        Unknowns::Free
    }

    fn ways(&self) -> Option<&Field> {
        Some(&self.field)
    }

    fn choose(&mut self, view: &View<'_>, _: &Field) -> Option<usize> {
        if self.patience.is_lost(view) {
            self.field.spread(view.board, view.at(), Unknowns::Solid);
            let nearest = nearest_frontier(view.board, &self.field)?;
            return Some(self.lead_to(view, nearest));
        }
        let plan = self.near(view);
        let near = plan.map_or(0.0, |plan| plan.rate * NEAR_WEIGHT);
        if let Some(plan) = plan.filter(|_| near >= afar::RATE) {
            return Some(self.follow(view, plan)); // nothing far brings more
        }
        let (cell, far) = self.afar.best(view, &mut self.field)?;
        match plan.filter(|_| near >= far) {
            Some(plan) => Some(self.follow(view, plan)),
            None => Some(self.lead_to(view, cell)),
        }
    }
}

fn nearest_frontier(board: &Board, field: &Field) -> Option<usize> {
    field.reached().iter().skip(1).find(|cell| board.is_frontier(**cell)).copied()
}

/// Since when nothing was learnt.
#[derive(Clone, Debug, Default)]
struct Patience {
    known: usize,
    step: u32,
}

impl Patience {
    fn is_lost(&mut self, view: &View<'_>) -> bool {
        let board = view.board;
        if board.known_count() != self.known {
            (self.known, self.step) = (board.known_count(), view.step);
        }
        view.step.saturating_sub(self.step) as usize > (board.columns() + board.rows()) / PATIENCE_SHARE
    }
}
