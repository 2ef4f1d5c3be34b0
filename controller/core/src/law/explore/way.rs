//! The way of a body to where it wants to look: the cheapest over cells, by A* (Hart, Nilsson, Raphael 1968).
//!
//! A step to a side costs 10 and to a corner 14; more where walls are near, so that a way keeps away from them where
//! there is room, and a little more where nothing is known, so that of two ways the known one is taken.

use crate::map::{Board, Known, Space, Unknowns, steps_from};
use pathfinding::directed::astar::astar;

const SIDE_COST: u32 = 10;
const CORNER_COST: u32 = 14;
/// More for every step to a cell near walls, or unknown.
const NEAR_COST: u32 = 20;
const UNKNOWN_COST: u32 = 4;

/// The cells from `from` to `to`, both ends among them; none if there is no way. `board`: where the body may go now.
pub(super) fn plan(space: &Space, board: &Board, unknowns: Unknowns, ends: (usize, usize)) -> Option<Vec<usize>> {
    let (from, to) = ends;
    let [to_column, to_row] = board.place(to);
    let octile = |cell: &usize| {
        let [column, row] = board.place(*cell);
        let (dx, dy) = (column.abs_diff(to_column), row.abs_diff(to_row));
        SIDE_COST * dx.max(dy) + (CORNER_COST - SIDE_COST) * dx.min(dy)
    };
    let steps = |cell: &usize| {
        let mut next = Vec::with_capacity(8);
        let here = board.place(*cell);
        steps_from(board, unknowns, *cell, |other| {
            let there = board.place(other);
            let straight = here[0] == there[0] || here[1] == there[1];
            let near = if space.is_near(other) { NEAR_COST } else { 0 };
            let unknown = if board.at(other) == Known::Unknown { UNKNOWN_COST } else { 0 };
            next.push((other, if straight { SIDE_COST } else { CORNER_COST } + near + unknown));
        });
        next
    };
    astar(&from, steps, octile, |cell| *cell == to).map(|(way, _)| way)
}

#[cfg(test)]
mod tests {
    use super::plan;
    use crate::map::{Known, Lattice, Space, Unknowns};
    use drover_contract::Vec2;

    #[test]
    fn a_way_goes_through_a_door_in_its_middle_and_around_what_is_closed() {
        let lattice = Lattice::over(Vec2::zeros(), Vec2::new(4.2, 4.2), 0.2);
        let mut map = crate::map::Board::new(21, 21);
        let mut space = Space::new(&lattice, 0.45, 0.65);
        for cell in 0..map.count() {
            let [column, row] = map.place(cell);
            // A wall from the south to the north with a door of 1.8 m.
            let wall = column == 10 && !(6..15).contains(&row);
            map.learn(cell, if wall { Known::Occupied } else { Known::Free });
            space.learn(&map, cell);
        }
        let (from, to) = (21 + 2, 21 + 18);
        let way = plan(&space, space.board(), Unknowns::Solid, (from, to)).expect("a way");
        let at_door = way.iter().find(|cell| map.place(**cell)[0] == 10).expect("through the door");
        assert!((9..12).contains(&map.place(*at_door)[1]), "{:?}", map.place(*at_door));
        let mut closed = space.board().clone();
        (6..15).for_each(|row| {
            closed.learn(row * 21 + 10, Known::Occupied);
        });
        assert_eq!(plan(&space, &closed, Unknowns::Solid, (from, to)), None);
    }
}
