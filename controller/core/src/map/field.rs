//! Ways over cells: one wave from a start gives the steps to every cell, one from all robots who is nearest to each.
//!
//! A step goes to one of the eight neighbours, and takes as long to a corner as to a side; it cuts no corner of an
//! occupied cell. Cost: a queue over the cells that are reached, nothing else (Moore's algorithm).

use super::{Board, Known};

/// How unknown cells count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknowns {
    /// Nobody goes there.
    Solid,
    /// They are free until something is seen there.
    Free,
}

const FAR: u32 = u32::MAX;

fn passes(board: &Board, unknowns: Unknowns, cell: usize) -> bool {
    match board.at(cell) {
        Known::Free => true,
        Known::Occupied => false,
        Known::Unknown => unknowns == Unknowns::Free,
    }
}

/// What a step to a side and to a corner needs to be free.
pub(crate) fn steps_from(board: &Board, unknowns: Unknowns, cell: usize, mut to: impl FnMut(usize)) {
    let (columns, rows) = (board.columns(), board.rows());
    let (column, row) = (cell % columns, cell / columns);
    let free = |there: bool, other: usize| there && passes(board, unknowns, other);
    let (has_west, has_east) = (column > 0, column + 1 < columns);
    let (has_south, has_north) = (row > 0, row + 1 < rows);
    let west = free(has_west, cell.wrapping_sub(1));
    let east = free(has_east, cell + 1);
    let south = free(has_south, cell.wrapping_sub(columns));
    let north = free(has_north, cell + columns);
    for (goes, other) in
        [(west, cell.wrapping_sub(1)), (east, cell + 1), (south, cell.wrapping_sub(columns)), (north, cell + columns)]
    {
        if goes {
            to(other);
        }
    }
    for (sides, other) in [
        (west && south, cell.wrapping_sub(columns + 1)),
        (east && south, (cell + 1).wrapping_sub(columns)),
        (west && north, (cell + columns).wrapping_sub(1)),
        (east && north, cell + columns + 1),
    ] {
        if sides && passes(board, unknowns, other) {
            to(other);
        }
    }
}

/// Steps from one cell to all that can be reached.
#[derive(Clone, Debug, Default)]
pub struct Field {
    steps: Vec<u32>,
    /// The cells that are reached, the nearest first.
    reached: Vec<usize>,
    /// Those of them whose neighbours are reached as well.
    done: usize,
    /// Where the way to a cell begins, if it has been said.
    lead: Option<[usize; 2]>,
}

impl Field {
    /// Find the ways from `start`. Whatever it held before is gone; its memory is used again.
    pub fn spread(&mut self, board: &Board, start: usize, unknowns: Unknowns) {
        self.begin(board, start);
        self.extend(board, unknowns, FAR);
    }

    /// Find for every cell the steps to the nearest of several starts.
    pub fn spread_from(&mut self, board: &Board, starts: impl IntoIterator<Item = usize>, unknowns: Unknowns) {
        self.steps.clear();
        self.steps.resize(board.count(), FAR);
        self.reached.clear();
        (self.done, self.lead) = (0, None);
        for start in starts {
            if self.steps[start] == FAR {
                self.steps[start] = 0;
                self.reached.push(start);
            }
        }
        self.extend(board, unknowns, FAR);
    }

    /// Nothing but `start` is reached yet.
    pub fn begin(&mut self, board: &Board, start: usize) {
        self.steps.clear();
        self.steps.resize(board.count(), FAR);
        self.reached.clear();
        self.done = 0;
        self.lead = None;
        self.steps[start] = 0;
        self.reached.push(start);
    }

    /// Reach all that is up to `steps_max` steps away.
    pub fn extend(&mut self, board: &Board, unknowns: Unknowns, steps_max: u32) {
        while let Some(cell) = self.reached.get(self.done).copied() {
            let steps = self.steps[cell] + 1;
            if steps > steps_max {
                break;
            }
            self.done += 1;
            let (all, reached) = (&mut self.steps, &mut self.reached);
            steps_from(board, unknowns, cell, |other| {
                if all[other] == FAR {
                    all[other] = steps;
                    reached.push(other);
                }
            });
        }
    }

    /// Steps to a cell; none if it cannot be reached.
    #[must_use]
    pub fn steps(&self, cell: usize) -> Option<u32> {
        self.steps.get(cell).copied().filter(|steps| *steps != FAR)
    }

    /// The cells that can be reached, the nearest first, the start before all.
    #[must_use]
    pub fn reached(&self) -> &[usize] {
        &self.reached
    }

    /// The way to a cell begins with a step to `first`, whatever else is as near or nearer.
    pub fn lead(&mut self, to: usize, first: usize) {
        self.lead = Some([to, first]);
    }

    /// The first step of a shortest way to a cell; the start itself if it is that. Of several ways the one that keeps
    /// to the straight line from the end: it is the same whatever was learnt elsewhere.
    #[must_use]
    pub fn first_step(&self, board: &Board, unknowns: Unknowns, to: usize) -> Option<usize> {
        if let Some([_, first]) = self.lead.filter(|lead| lead[0] == to) {
            return Some(first);
        }
        let mut cell = to;
        let mut steps = self.steps(to)?;
        while steps > 1 {
            let mut before = None;
            steps_from(board, unknowns, cell, |other| {
                if before.is_none() && self.steps[other] == steps - 1 {
                    before = Some(other);
                }
            });
            (cell, steps) = (before?, steps - 1);
        }
        Some(cell)
    }
}

/// Whose each cell is: of the robot that needs the fewest steps to it, the first of several.
#[derive(Clone, Debug, Default)]
pub struct Owners {
    owner: Vec<u32>,
    queue: Vec<usize>,
    done: usize,
    /// How many steps the wave has gone.
    steps: u32,
}

impl Owners {
    /// Robots stand on `starts`; nothing else is anybody's yet.
    pub fn begin(&mut self, board: &Board, starts: impl IntoIterator<Item = usize>) {
        self.owner.clear();
        self.owner.resize(board.count(), FAR);
        self.queue.clear();
        (self.done, self.steps) = (0, 0);
        for (robot, start) in starts.into_iter().enumerate() {
            if self.owner[start] == FAR {
                self.owner[start] = robot as u32;
                self.queue.push(start);
            }
        }
    }

    /// Find whose all that is up to `steps_max` steps away from somebody is.
    pub fn extend(&mut self, board: &Board, unknowns: Unknowns, steps_max: u32) {
        while self.steps < steps_max && self.done < self.queue.len() {
            self.steps += 1;
            for next in self.done..self.queue.len() {
                let cell = self.queue[next];
                let own = self.owner[cell];
                let (owner, queue) = (&mut self.owner, &mut self.queue);
                steps_from(board, unknowns, cell, |other| {
                    if owner[other] == FAR {
                        owner[other] = own;
                        queue.push(other);
                    }
                });
                self.done = next + 1;
            }
        }
    }

    /// Whose a cell is; nobody's if nobody can reach it.
    #[must_use]
    pub fn of(&self, cell: usize) -> Option<usize> {
        self.owner.get(cell).copied().filter(|owner| *owner != FAR).map(|owner| owner as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::{Field, Owners, Unknowns};
    use crate::map::{Board, Known};

    /// `.` free, `#` occupied, `?` unknown; the last row is the south.
    fn board(rows: &[&str]) -> Board {
        let mut board = Board::new(rows[0].len(), rows.len());
        for (row, line) in rows.iter().rev().enumerate() {
            for (column, sign) in line.chars().enumerate() {
                let known = match sign {
                    '.' => Known::Free,
                    '#' => Known::Occupied,
                    _ => Known::Unknown,
                };
                board.learn(row * line.len() + column, known);
            }
        }
        board
    }

    #[test]
    fn a_corner_is_not_cut_and_the_unknown_is_as_one_says() {
        let board = board(&["..?", ".#.", "..."]);
        let mut field = Field::default();
        field.spread(&board, 0, Unknowns::Solid);
        assert_eq!(field.steps(5), Some(3), "around the occupied cell, not past its corner");
        assert_eq!(field.steps(8), None);
        field.spread(&board, 0, Unknowns::Free);
        assert_eq!(field.steps(8), Some(4));
        assert_eq!(field.first_step(&board, Unknowns::Free, 5), Some(1));
        assert_eq!(field.first_step(&board, Unknowns::Free, 0), Some(0));
    }

    #[test]
    fn a_wave_from_several_starts_has_the_steps_to_the_nearest_and_a_way_may_begin_as_one_says() {
        let board = board(&[".....", ".....", "....."]);
        let mut field = Field::default();
        field.spread_from(&board, [0, 4, 4], Unknowns::Solid);
        assert_eq!([0, 1, 2, 3, 12].map(|cell| field.steps(cell)), [0, 1, 2, 1, 2].map(Some));
        field.spread(&board, 5, Unknowns::Solid);
        field.lead(9, 11);
        assert_eq!(field.first_step(&board, Unknowns::Solid, 9), Some(11), "as it was said");
        assert_eq!(field.first_step(&board, Unknowns::Solid, 8), Some(6), "another end");
        field.spread(&board, 5, Unknowns::Solid);
        assert_eq!(field.first_step(&board, Unknowns::Solid, 9), Some(6), "a new wave forgets it");
    }

    #[test]
    fn a_cell_is_the_nearest_robot_s_and_the_first_one_s_of_two() {
        let board = board(&[".....", "#####", "....."]);
        let mut owners = Owners::default();
        owners.begin(&board, [0, 4]);
        owners.extend(&board, Unknowns::Solid, 1);
        assert_eq!([1, 2, 3].map(|cell| owners.of(cell)), [Some(0), None, Some(1)]);
        owners.extend(&board, Unknowns::Solid, 9);
        assert_eq!([0, 1, 2, 3, 4].map(|cell| owners.of(cell)), [0, 0, 0, 1, 1].map(Some));
        assert_eq!(owners.of(12), None);
    }
}
