//! A one-dimensional depth buffer: what all beams of a scan see, from one thing at a time.
//!
//! All beams of a scan share one origin, so the work is done per thing in range and not per ray: a wall or a disc
//! becomes an interval of beams (two angles), and each beam u of the interval keeps the nearest range that it was
//! offered. The same idea as a z-buffer, with one row. What is kept is not the range but its inverse, which both kinds
//! of thing offer without a division:
//!
//! - wall from a with edge e:     1 / r = (e x u) / (a x e), linear in u;
//! - disc at p with radius R:     1 / r = (u . p + sqrt(R^2 - (u x p)^2)) / (p^2 - R^2).
//!
//! Things, and beams, come side by side ([`Lanes`]) as f32 in the sensor's frame, and every step over them is without
//! a branch. f32 holds a range of 10 m to a micrometre; the frame of a place kilometres wide is left in f64 by the
//! caller. Angles come from a polynomial ([`angle`]), so no C library decides what is seen.
//!
//! Conditions: the origin lies in free space and outlines are closed, since walls that face away are skipped (what lies
//! behind a face is hidden by that face).

use crate::lanes::{LANES, Lanes};
use drover_contract::math::ATAN;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// An interval is widened by this, radians: two walls that share a corner see it at the same angle where differences of
/// places are exact ([`crate::sight`]), and this is for where they are not.
const EDGE_RAD: f32 = 5e-7;
/// Twice the area of the triangle of a wall and the sensor, square metres, from which on the wall is seen.
const FACING_MIN: f32 = 1e-9;
const PER_LANES: f32 = 1.0 / LANES as f32;

/// Where a block of beams look, sensor frame; beams that only fill up the last block look nowhere.
#[derive(Clone, Copy, Debug, Default)]
struct Rays {
    ux: Lanes,
    uy: Lanes,
}

/// What a scan sees so far.
#[derive(Clone, Debug)]
pub(crate) struct DepthBuffer {
    first_rad: f32,
    per_rad: f32,
    /// Beams of a full turn; a scan of part of one has fewer.
    turn_beams: f32,
    range_m: f32,
    edge_beams: f32,
    beams: usize,
    rays: Vec<Rays>,
    /// Inverse of the nearest range, 1/m; 0 where there is nothing.
    inverse: Vec<Lanes>,
    /// What was last asked for; kept for its memory only.
    ranges_m: Vec<f64>,
    /// Beams that are drawn, the first and the last: all, or those of one part of a sweep.
    drawn: (f32, f32),
}

/// Intervals of beams, as numbers that need not be whole: a beam belongs to it that lies between the two.
struct Intervals {
    from: Lanes,
    to: Lanes,
    /// The blocks that hold what is drawn of it, the first and the last.
    first: [i32; LANES],
    last: [i32; LANES],
}

impl DepthBuffer {
    /// A buffer of `beams` beams from `first_rad` on, `step_rad` apart, counter-clockwise, sensor frame.
    pub(crate) fn new(beams: usize, first_rad: f64, step_rad: f64, range_m: f64) -> Self {
        let mut rays = vec![Rays::default(); beams.div_ceil(LANES)];
        for beam in 0..beams {
            let (sin, cos) = drover_contract::math::sin_cos(first_rad + step_rad * beam as f64);
            rays[beam / LANES].ux.each_mut()[beam % LANES] = cos as f32;
            rays[beam / LANES].uy.each_mut()[beam % LANES] = sin as f32;
        }
        Self {
            first_rad: first_rad as f32,
            per_rad: (1.0 / step_rad) as f32,
            turn_beams: (std::f64::consts::TAU / step_rad) as f32,
            range_m: range_m as f32,
            edge_beams: EDGE_RAD / step_rad as f32,
            beams,
            inverse: vec![Lanes::default(); rays.len()],
            ranges_m: vec![0.0; LANES * rays.len()],
            rays,
            drawn: (0.0, beams as f32 - 1.0),
        }
    }

    /// Forget everything.
    pub(crate) fn clear(&mut self) {
        self.inverse.fill(Lanes::default());
    }

    /// From now on, draw only beams `first..end`.
    pub(crate) fn draw_only(&mut self, first: usize, end: usize) {
        self.drawn = (first as f32, end.min(self.beams) as f32 - 1.0);
    }

    /// How far this buffer sees, metres.
    pub(crate) fn range_m(&self) -> f32 {
        self.range_m
    }

    /// How many beams there are.
    pub(crate) fn beams(&self) -> usize {
        self.beams
    }

    /// The nearest range of each beam, metres; infinite where there is nothing.
    pub(crate) fn ranges(&mut self) -> &[f64] {
        for (ranges_m, inverse) in self.ranges_m.chunks_exact_mut(LANES).zip(&self.inverse) {
            // Which of 0 and -0 a beam keeps is not said.
            let block_m = Lanes::all(1.0) / inverse.abs();
            ranges_m.copy_from_slice(&block_m.each().map(f64::from));
        }
        &self.ranges_m[..self.beams]
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.rays.capacity() * size_of::<Rays>()
            + self.inverse.capacity() * size_of::<Lanes>()
            + self.ranges_m.capacity() * size_of::<f64>()
    }

    /// Draw walls from (ax, ay) to (bx, by), sensor frame, metres. A wall of length 0 is nothing.
    #[inline]
    pub(crate) fn draw_walls(&mut self, [ax, ay]: [Lanes; 2], [bx, by]: [Lanes; 2]) {
        let (zero, one) = (Lanes::default(), Lanes::all(1.0));
        let (ex, ey) = (bx - ax, by - ay);
        let facing = ax * ey - ay * ex;
        // Facing away or edge-on is not seen: it offers nothing, which no beam prefers.
        let least = Lanes::all(FACING_MIN);
        let scale = least.if_less(facing, one, zero) / least.max(facing);
        let (gx, gy) = (ey * scale, -ex * scale);
        let intervals = self.intervals(angle(ay, ax), angle(by, bx));
        for i in 0..LANES {
            let (gx, gy) = (Lanes::all(gx.each()[i]), Lanes::all(gy.each()[i]));
            self.fill(&intervals, i, |rays| gx * rays.ux + gy * rays.uy);
        }
    }

    /// Draw discs at (px, py) with radius `radius`, sensor frame, metres. A disc around the origin, or of radius 0, is
    /// nothing.
    #[inline]
    pub(crate) fn draw_discs(&mut self, [px, py]: [Lanes; 2], radius: Lanes) {
        let (zero, one) = (Lanes::default(), Lanes::all(1.0));
        let (centre2, radius2) = (px * px + py * py, radius * radius);
        let tangent2 = centre2 - radius2;
        let far = Lanes::all(self.range_m) + radius;
        let in_range = centre2.if_less(far * far, one, zero);
        let seen = zero.if_less(tangent2, zero.if_less(radius, in_range, zero), zero);
        let tangent2 = zero.if_less(seen, tangent2, one);
        let scale = seen / tangent2;
        let half_rad = angle(radius, tangent2.sqrt());
        let middle_rad = angle(py, px);
        let intervals = self.intervals(middle_rad - half_rad, middle_rad + half_rad);
        for i in 0..LANES {
            if scale.each()[i] > 0.0 {
                let (x, y) = (Lanes::all(px.each()[i]), Lanes::all(py.each()[i]));
                let (radius2, scale) = (Lanes::all(radius2.each()[i]), Lanes::all(scale.each()[i]));
                self.fill(&intervals, i, |rays| {
                    let aside = rays.ux * y - rays.uy * x;
                    let depth2 = radius2 - aside * aside;
                    let offered = (rays.ux * x + rays.uy * y + depth2.max(zero).sqrt()) * scale;
                    // What misses a disc by less than the interval's rounding misses it.
                    depth2.if_less(zero, zero, offered)
                });
            }
        }
    }

    /// The beams of intervals of angles, up to half a turn. They may reach beyond the end of the turn; `fill` goes on
    /// at its beginning.
    #[inline]
    fn intervals(&self, from_rad: Lanes, to_rad: Lanes) -> Intervals {
        let [from, to] = [from_rad, to_rad].map(|angle_rad| {
            let on_rad = angle_rad - Lanes::all(self.first_rad);
            on_rad.if_less(Lanes::default(), on_rad + Lanes::all(TAU), on_rad) * self.per_rad
        });
        // A span that is negative by far ends behind the end of the turn, and one that is so by rounding is empty.
        let behind = (to - from).if_less(Lanes::all(-0.25 * self.turn_beams), to + Lanes::all(self.turn_beams), to);
        let edge = Lanes::all(self.edge_beams);
        let to = behind.max(from) + edge;
        let from = (from - edge).max(Lanes::all(self.drawn.0));
        let last = to.min(Lanes::all(self.drawn.1));
        Intervals { from, to, first: (from * PER_LANES).whole(), last: (last * PER_LANES).whole() }
    }

    /// Offer beams of interval `i` the inverse of a range, in at most two runs.
    #[inline]
    fn fill(&mut self, intervals: &Intervals, i: usize, offer: impl Fn(&Rays) -> Lanes) {
        let (from, to) = (intervals.from.each()[i], intervals.to.each()[i]);
        self.run([from, to], [intervals.first[i], intervals.last[i]], &offer);
        if to >= self.turn_beams {
            // What reaches beyond the end of the turn goes on at its beginning. A turn that is no whole number of
            // beams (part of one) has its beams at the same angles a turn later.
            let (from, to) = ((from - self.turn_beams).max(self.drawn.0), to - self.turn_beams);
            let blocks = [from, to.min(self.drawn.1)].map(|beam| (beam * PER_LANES) as i32);
            self.run([from, to], blocks, &offer);
        }
    }

    #[inline]
    fn run(&mut self, [from, to]: [f32; 2], [first, last]: [i32; 2], offer: &impl Fn(&Rays) -> Lanes) {
        // An interval outside of a part of a turn begins beyond the last beam: it is empty wherever it begins.
        let blocks = first.min(last + 1).max(0) as usize..(last + 1).max(0) as usize;
        let (from, to) = (Lanes::all(from), Lanes::all(to.min(self.drawn.1)));
        let mut nth = Lanes::all((blocks.start * LANES) as f32) + Lanes::COUNT;
        for (nearest, rays) in self.inverse[blocks.clone()].iter_mut().zip(&self.rays[blocks]) {
            *nearest = nearest.max(offer(rays).within(nth, from, to));
            nth = nth + Lanes::all(LANES as f32);
        }
    }
}

/// The directions of (x, y), radians, to 2e-7: `drover_contract::math::quick_angle` of many at once. (0, 0) gives 0.
#[inline]
pub(crate) fn angle(y: Lanes, x: Lanes) -> Lanes {
    let zero = Lanes::default();
    let (across, along) = (y.abs(), x.abs());
    let large = along.max(across);
    let ratio = along.min(across) / zero.if_less(large, large, Lanes::all(1.0));
    let s = ratio * ratio;
    let sum = ATAN.iter().rev().fold(Lanes::default(), |sum, c| sum * s + Lanes::all(*c));
    let octant = ratio + ratio * s * sum;
    let quarter = along.if_less(across, Lanes::all(FRAC_PI_2) - octant, octant);
    let half = x.if_less(zero, Lanes::all(PI) - quarter, quarter);
    y.if_less(zero, -half, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angle_of(y: f32, x: f32) -> f32 {
        angle(Lanes::all(y), Lanes::all(x)).each()[3]
    }

    #[test]
    fn the_angle_is_right_all_around() {
        for step in 0..100_000 {
            let true_rad = (f64::from(step) / 100_000.0 - 0.5) * std::f64::consts::TAU;
            let (sin, cos) = drover_contract::math::sin_cos(true_rad);
            let got = f64::from(angle_of((3.0 * sin) as f32, (3.0 * cos) as f32));
            let off = drover_contract::wrap(got - true_rad).abs();
            assert!(off < 4e-7, "{true_rad}: {got}");
        }
        assert!(angle_of(0.0, 0.0) == 0.0 && (angle_of(0.0, -1.0) - PI).abs() < 1e-6);
    }

    #[test]
    fn mirrored_points_have_mirrored_angles() {
        for step in 1..1_000 {
            let (y, x) = (step as f32 * 0.01, 3.0 - step as f32 * 0.006);
            assert_eq!(angle_of(-y, x).to_bits(), (-angle_of(y, x)).to_bits());
        }
    }

    fn lanes(value: f32) -> Lanes {
        let mut lanes = Lanes::default();
        lanes.each_mut()[0] = value;
        lanes
    }

    #[test]
    fn a_wall_across_the_back_wraps_around_the_end_of_the_turn() {
        let mut depth = DepthBuffer::new(8, 0.0, f64::from(TAU) / 8.0, 10.0);
        // From south-east to north-east of us, 2 m ahead: seen by beams 7, 0 and 1.
        depth.draw_walls([lanes(2.0), lanes(-2.5)], [lanes(2.0), lanes(2.5)]);
        let seen: Vec<usize> = (0..8).filter(|beam| depth.ranges()[*beam].is_finite()).collect();
        assert_eq!(seen, [0, 1, 7]);
        assert!((depth.ranges()[0] - 2.0).abs() < 1e-6 && (depth.ranges()[7] - 8.0_f64.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn a_part_of_a_turn_sees_a_wall_behind_its_seam() {
        // 11 beams over half a turn, from -90 to +90 degrees.
        let mut depth = DepthBuffer::new(11, -std::f64::consts::FRAC_PI_2, std::f64::consts::PI / 10.0, 10.0);
        depth.draw_walls([lanes(2.0), lanes(-1.0)], [lanes(2.0), lanes(1.0)]);
        let seen: Vec<usize> = (0..11).filter(|beam| depth.ranges()[*beam].is_finite()).collect();
        assert_eq!(seen, [4, 5, 6], "26.6 degrees to either side of the middle");
        // From the left behind us across the back to the right, a little beyond the seam.
        depth.clear();
        depth.draw_walls([lanes(-3.0), lanes(2.0)], [lanes(0.1), lanes(-2.5)]);
        let seen: Vec<usize> = (0..11).filter(|beam| depth.ranges()[*beam].is_finite()).collect();
        assert_eq!(seen, [0], "it ends just to the right of straight right");
    }

    #[test]
    fn a_disc_is_as_near_as_its_surface() {
        let mut depth = DepthBuffer::new(360, 0.0, f64::from(TAU) / 360.0, 10.0);
        depth.draw_discs([lanes(3.0), lanes(0.0)], lanes(0.5));
        assert!((depth.ranges()[0] - 2.5).abs() < 1e-6);
        let seen = (0..360).filter(|beam| depth.ranges()[*beam].is_finite()).count();
        assert_eq!(seen, 19, "asin(0.5 / 3) is 9.59 degrees");
    }
}
