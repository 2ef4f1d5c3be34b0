//! Auctions of candidates (after Zlot 2002): a robot takes the cheapest candidate for which nobody bids less.
//!
//! One that is on its way to a target bids what it costs to go there first; what lies within the sensor's reach of
//! another's target is sold already. If it wins nothing, it takes the cheapest that is not sold, or the cheapest of
//! all.

use super::super::value::Candidate;
use super::super::view::View;
use super::Classic;

impl Classic {
    /// What this robot wins.
    pub(super) fn market(&mut self, view: &View<'_>, candidates: &[Candidate]) -> Option<usize> {
        let others = self.spread_others(view, |mate| mate.target.unwrap_or(mate.at));
        let fields = &self.fields[..others];
        // A wave from the target, for steps there and back are the same.
        let ahead: Vec<u32> =
            fields.iter().zip(view.others()).map(|(field, (_, mate))| field.steps(mate.at).unwrap_or(0)).collect();
        let outbid = |one: &Candidate| {
            fields.iter().zip(&ahead).any(|(field, ahead)| {
                field.steps(one.cell).is_some_and(|steps| f64::from(steps.saturating_add(*ahead)) < one.steps)
            })
        };
        let reach = view.sight.reach();
        let sold = |one: &Candidate| {
            let near = |target: usize| {
                let [[ax, ay], [bx, by]] = [view.board.place(one.cell), view.board.place(target)];
                (ax - bx).abs() <= reach && (ay - by).abs() <= reach
            };
            view.others().filter_map(|(_, mate)| mate.target).any(near)
        };
        let mut order: Vec<&Candidate> = candidates.iter().collect();
        order.sort_by(|a, b| self.cost(a, a.steps).total_cmp(&self.cost(b, b.steps)).then(a.cell.cmp(&b.cell)));
        let won = order.iter().find(|one| !sold(one) && !outbid(one));
        won.or_else(|| order.iter().find(|one| !sold(one))).or(order.first()).map(|one| one.cell)
    }
}
