//! Parts of a place for robots that cannot talk while they work: everybody works them out for itself, from what all
//! know.
//!
//! **In**: cells that are to be shared out (all of a place that nobody knows, or what is left of it), and a seed a
//! robot.
//! **Out**: whose every cell is. **Idea**: a power diagram, a Voronoi diagram whose seeds have weights; weights are
//! raised where the share is too small and lowered where it is too large, until all have about the same (F.
//! Aurenhammer, F. Hoffmann, B. Aronov, "Minkowski-type theorems and least-squares clustering", Algorithmica 20,
//! 1998). The same input gives the same parts to everybody.
//!
//! **Cost**: rounds times cells times robots; now and then, not at every step.

use crate::map::Board;

/// Rounds in which weights are changed.
const ROUNDS: u32 = 60;
/// More cells than this are thinned out for the weights.
const CELLS_MAX: usize = 2_000;

/// Whose each cell of the board is, by the index of its seed.
#[must_use]
pub fn parts(board: &Board, cells: &[usize], seeds: &[[f64; 2]]) -> Vec<u16> {
    let place = |cell: usize| board.place(cell).map(f64::from);
    let thin = cells.len().div_ceil(CELLS_MAX).max(1);
    let sample: Vec<[f64; 2]> = cells.iter().step_by(thin).map(|cell| place(*cell)).collect();
    let mut weights = vec![0.0; seeds.len()];
    let share = sample.len() as f64 / seeds.len().max(1) as f64;
    // A cell more is worth about as much weight as makes a border move by it; less and less from round to round.
    let step = (board.count() as f64 / seeds.len().max(1) as f64) / share.max(1.0);
    for round in 0..ROUNDS {
        let mut counts = vec![0.0; seeds.len()];
        sample.iter().for_each(|at| counts[nearest(*at, seeds, &weights)] += 1.0);
        let gain = step / f64::from(1 + round / 6);
        for (weight, count) in weights.iter_mut().zip(&counts) {
            *weight += gain * (share - count);
        }
    }
    (0..board.count()).map(|cell| nearest(place(cell), seeds, &weights) as u16).collect()
}

fn nearest([x, y]: [f64; 2], seeds: &[[f64; 2]], weights: &[f64]) -> usize {
    let power = |at: usize| {
        let [dx, dy] = [seeds[at][0] - x, seeds[at][1] - y];
        dx * dx + dy * dy - weights[at]
    };
    (0..seeds.len()).min_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap_or(0)
}

/// Seeds for `count` robots that stand at one place: the means of what lies around it in `count` equal sectors.
#[must_use]
pub fn sectors(board: &Board, cells: &[usize], around: usize, count: usize) -> Vec<[f64; 2]> {
    let [x0, y0] = board.place(around).map(f64::from);
    let mut all: Vec<([f64; 2], f64)> = cells
        .iter()
        .map(|cell| {
            let [x, y] = board.place(*cell).map(f64::from);
            ([x, y], libm::atan2(y - y0, x - x0))
        })
        .collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mean = |part: &[([f64; 2], f64)]| {
        let sum = part.iter().fold([0.0, 0.0], |sum, (at, _)| [sum[0] + at[0], sum[1] + at[1]]);
        sum.map(|sum| sum / part.len().max(1) as f64)
    };
    let bound = |rank: usize| rank * all.len() / count.max(1);
    let sector = |rank: usize| &all[bound(rank)..bound(rank + 1)];
    (0..count).map(|rank| if sector(rank).is_empty() { [x0, y0] } else { mean(sector(rank)) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_have_about_as_much_wherever_they_start() {
        let board = Board::new(60, 40);
        let all: Vec<usize> = (0..2_400).collect();
        let owners = parts(&board, &all, &[[1.0, 1.0], [5.0, 1.0], [3.0, 6.0], [55.0, 30.0]]);
        for rank in 0..4 {
            let count = owners.iter().filter(|owner| **owner == rank).count();
            assert!((540..=660).contains(&count), "{rank}: {count}");
        }
        assert_eq!(owners[board.cell([55, 35]).unwrap()], 3);
    }

    #[test]
    fn what_is_left_around_a_place_goes_to_all_directions() {
        let board = Board::new(40, 40);
        let left: Vec<usize> = [[2, 20], [38, 20], [20, 2], [20, 38]].map(|at| board.cell(at).unwrap()).to_vec();
        let seeds = sectors(&board, &left, board.cell([20, 20]).unwrap(), 4);
        let owners = parts(&board, &left, &seeds);
        let mut of: Vec<u16> = left.iter().map(|cell| owners[*cell]).collect();
        of.sort_unstable();
        assert_eq!(of, [0, 1, 2, 3]);
    }
}
