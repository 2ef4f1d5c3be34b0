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
//! Things come in lanes of [`LANES`] as plain arrays of f32 in the sensor's frame, and every step over them is a loop
//! without a branch, which the compiler turns into vector instructions of whatever machine it builds for. f32 holds a
//! range of 10 m to a micrometre; the frame of a place kilometres wide is left in f64 by the caller. Angles come from
//! a polynomial ([`angle`]), so no C library decides what is seen.
//!
//! Conditions: the origin lies in free space and outlines are closed, since walls that face away are skipped (what lies
//! behind a face is hidden by that face).

use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Things that are handled side by side.
pub(crate) const LANES: usize = 8;
/// An interval is widened by this, radians, so that two walls that share a corner leave no hole: several times the
/// rounding of an angle.
const EDGE_RAD: f32 = 2e-6;

/// One number of each of [`LANES`] things.
pub(crate) type Lanes = [f32; LANES];

/// What a scan sees so far.
#[derive(Clone, Debug)]
pub(crate) struct DepthBuffer {
    first_rad: f32,
    per_rad: f32,
    /// Beams of a full turn; a scan of part of one has fewer.
    turn_beams: f32,
    range_m: f32,
    edge_beams: f32,
    ux: Vec<f32>,
    uy: Vec<f32>,
    /// Inverse of the nearest range, 1/m; 0 where there is nothing.
    inverse: Vec<f32>,
    /// Beams that are drawn: all, or those of one part of a sweep.
    drawn: (i32, i32),
}

impl DepthBuffer {
    /// A buffer of `beams` beams from `first_rad` on, `step_rad` apart, counter-clockwise, sensor frame.
    pub(crate) fn new(beams: usize, first_rad: f64, step_rad: f64, range_m: f64) -> Self {
        let direction = |index: usize| drover_contract::math::sin_cos(first_rad + step_rad * index as f64);
        Self {
            first_rad: first_rad as f32,
            per_rad: (1.0 / step_rad) as f32,
            turn_beams: (std::f64::consts::TAU / step_rad) as f32,
            range_m: range_m as f32,
            edge_beams: EDGE_RAD / step_rad as f32,
            ux: (0..beams).map(|index| direction(index).1 as f32).collect(),
            uy: (0..beams).map(|index| direction(index).0 as f32).collect(),
            inverse: vec![0.0; beams],
            drawn: (0, beams as i32 - 1),
        }
    }

    /// Forget everything.
    pub(crate) fn clear(&mut self) {
        self.inverse.fill(0.0);
    }

    /// From now on, draw only beams `first..end`.
    pub(crate) fn draw_only(&mut self, first: usize, end: usize) {
        self.drawn = (first as i32, end.min(self.inverse.len()) as i32 - 1);
    }

    /// How far this buffer sees, metres.
    pub(crate) fn range_m(&self) -> f32 {
        self.range_m
    }

    /// How many beams there are.
    pub(crate) fn beams(&self) -> usize {
        self.inverse.len()
    }

    /// The nearest range of a beam, metres; infinite where there is nothing.
    pub(crate) fn range_of(&self, beam: usize) -> f64 {
        f64::from(1.0 / self.inverse[beam])
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        3 * self.inverse.capacity() * size_of::<f32>()
    }

    /// Draw walls from (ax, ay) along (ex, ey), sensor frame, metres. An edge of length 0 is nothing.
    #[inline]
    pub(crate) fn draw_walls(&mut self, [ax, ay, ex, ey]: [&Lanes; 4]) {
        let (mut gx, mut gy) = ([0.0; LANES], [0.0; LANES]);
        let (mut from_rad, mut span_rad, mut keep) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let reach2 = self.range_m * self.range_m;
        for i in 0..LANES {
            let facing = ax[i] * ey[i] - ay[i] * ex[i];
            let length2 = ex[i] * ex[i] + ey[i] * ey[i];
            // The line's distance is facing / length: facing away, edge-on or too far is not seen.
            let seen = facing > 1e-9 && facing * facing < reach2 * length2;
            let scale = 1.0 / if seen { facing } else { 1.0 };
            gx[i] = ey[i] * scale;
            gy[i] = -ex[i] * scale;
            from_rad[i] = angle(ay[i], ax[i]);
            let turn = angle(ay[i] + ey[i], ax[i] + ex[i]) - from_rad[i];
            let turn = if turn < -PI { turn + TAU } else { turn };
            span_rad[i] = if turn > 0.0 { turn } else { 0.0 };
            keep[i] = if seen { 1.0 } else { 0.0 };
        }
        let (first, last) = self.intervals(&from_rad, &span_rad);
        for i in 0..LANES {
            if keep[i] > 0.0 {
                self.each_run(first[i], last[i], |nearest, ux, uy| {
                    for ((nearest, ux), uy) in nearest.iter_mut().zip(ux).zip(uy) {
                        let offered = gx[i] * ux + gy[i] * uy;
                        *nearest = if offered > *nearest { offered } else { *nearest };
                    }
                });
            }
        }
    }

    /// Draw discs at (px, py) with radius `radius`, sensor frame, metres. A disc around the origin, or of radius 0, is
    /// nothing.
    #[inline]
    pub(crate) fn draw_discs(&mut self, [px, py, radius]: [&Lanes; 3]) {
        let (mut middle_rad, mut half_rad) = ([0.0; LANES], [0.0; LANES]);
        let (mut scale, mut from_rad, mut span_rad) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let tangent2 = px[i] * px[i] + py[i] * py[i] - radius[i] * radius[i];
            let far = self.range_m + radius[i];
            let seen = tangent2 > 0.0 && radius[i] > 0.0 && tangent2 + radius[i] * radius[i] < far * far;
            scale[i] = if seen { 1.0 / tangent2 } else { 0.0 };
            middle_rad[i] = angle(py[i], px[i]);
            half_rad[i] = angle(radius[i], if seen { tangent2 } else { 1.0 }.sqrt());
            from_rad[i] = middle_rad[i] - half_rad[i];
            span_rad[i] = 2.0 * half_rad[i];
        }
        let (first, last) = self.intervals(&from_rad, &span_rad);
        for i in 0..LANES {
            if scale[i] > 0.0 {
                let (x, y, radius2, scale) = (px[i], py[i], radius[i] * radius[i], scale[i]);
                self.each_run(first[i], last[i], |nearest, ux, uy| {
                    for ((nearest, ux), uy) in nearest.iter_mut().zip(ux).zip(uy) {
                        let aside = ux * y - uy * x;
                        let depth2 = radius2 - aside * aside;
                        let depth = if depth2 > 0.0 { depth2 } else { 0.0 }.sqrt();
                        let offered = (ux * x + uy * y + depth) * scale;
                        *nearest = if offered > *nearest { offered } else { *nearest };
                    }
                });
            }
        }
    }

    /// First and last beam of intervals of angles. They may lie a turn too far; `each_run` looks for them there.
    #[inline]
    fn intervals(&self, from_rad: &Lanes, span_rad: &Lanes) -> ([i32; LANES], [i32; LANES]) {
        let (mut first, mut last) = ([0; LANES], [0; LANES]);
        for i in 0..LANES {
            let from = from_rad[i] - self.first_rad;
            let from = (if from < 0.0 { from + TAU } else { from }) * self.per_rad;
            let to = from + span_rad[i] * self.per_rad + self.edge_beams;
            let from = from - self.edge_beams;
            // Rounding up by hand: a call per lane would break the loop into pieces. Below 0 the cut rounds up.
            let whole = from as i32;
            first[i] = whole + i32::from(from > whole as f32);
            last[i] = to as i32;
        }
        (first, last)
    }

    /// Call `draw` with the beams of an interval, in at most two runs.
    #[inline]
    fn each_run(&mut self, first: i32, last: i32, mut draw: impl FnMut(&mut [f32], &[f32], &[f32])) {
        let (lowest, highest) = self.drawn;
        let mut run = |from: i32, to: i32| {
            let (from, to) = (from.max(lowest), to.min(highest));
            if from <= to {
                let beams = from as usize..to as usize + 1;
                draw(&mut self.inverse[beams.clone()], &self.ux[beams.clone()], &self.uy[beams]);
            }
        };
        run(first, last);
        if last as f32 >= self.turn_beams {
            // What reaches beyond the end of the turn goes on at its beginning. A turn that is no whole number of
            // beams (part of one) has its beams at the same angles a turn later.
            let turn = self.turn_beams;
            let first = (first as f32 - turn).ceil() as i32;
            run(first, (last as f32 - turn + 1e-3).floor() as i32);
        }
    }
}

/// The direction of (x, y), radians, to 2e-7: atan of a ratio up to 1 as a polynomial (fitted here, minimax over 0..=1,
/// error 7e-9 before rounding), and the octants by symmetry. (0, 0) gives 0.
#[inline]
pub(crate) fn angle(y: f32, x: f32) -> f32 {
    const C: [f32; 8] = [
        -0.333_329_86,
        0.199_903_95,
        -0.141_859_64,
        0.105_738_886,
        -0.073_666_2,
        0.041_120_894,
        -0.015_131_967,
        0.002_622_107_5,
    ];
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (small, large) = if steep { (along, across) } else { (across, along) };
    let ratio = small / if large > 0.0 { large } else { 1.0 };
    let s = ratio * ratio;
    let mut sum = C[7];
    for c in [C[6], C[5], C[4], C[3], C[2], C[1], C[0]] {
        sum = sum * s + c;
    }
    let octant = ratio + ratio * s * sum;
    let quarter = if steep { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_is_right_all_around() {
        for step in 0..100_000 {
            let true_rad = (f64::from(step) / 100_000.0 - 0.5) * std::f64::consts::TAU;
            let (sin, cos) = true_rad.sin_cos();
            let got = f64::from(angle((3.0 * sin) as f32, (3.0 * cos) as f32));
            let off = drover_contract::wrap(got - true_rad).abs();
            assert!(off < 4e-7, "{true_rad}: {got}");
        }
        assert!(angle(0.0, 0.0) == 0.0 && (angle(0.0, -1.0) - PI).abs() < 1e-6);
    }

    #[test]
    fn mirrored_points_have_mirrored_angles() {
        for step in 1..1_000 {
            let (y, x) = (step as f32 * 0.01, 3.0 - step as f32 * 0.006);
            assert!(angle(-y, x) == -angle(y, x));
        }
    }

    fn lanes(value: f32) -> Lanes {
        let mut lanes = [0.0; LANES];
        lanes[0] = value;
        lanes
    }

    #[test]
    fn a_wall_across_the_back_wraps_around_the_end_of_the_turn() {
        let mut depth = DepthBuffer::new(8, 0.0, f64::from(TAU) / 8.0, 10.0);
        // From south-east to north-east of us, 2 m ahead: seen by beams 7, 0 and 1.
        depth.draw_walls([&lanes(2.0), &lanes(-2.5), &lanes(0.0), &lanes(5.0)]);
        let seen: Vec<usize> = (0..8).filter(|beam| depth.range_of(*beam).is_finite()).collect();
        assert_eq!(seen, [0, 1, 7]);
        assert!((depth.range_of(0) - 2.0).abs() < 1e-6 && (depth.range_of(7) - 8.0_f64.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn a_part_of_a_turn_sees_a_wall_behind_its_seam() {
        // 11 beams over half a turn, from -90 to +90 degrees.
        let mut depth = DepthBuffer::new(11, -std::f64::consts::FRAC_PI_2, std::f64::consts::PI / 10.0, 10.0);
        depth.draw_walls([&lanes(2.0), &lanes(-1.0), &lanes(0.0), &lanes(2.0)]);
        let seen: Vec<usize> = (0..11).filter(|beam| depth.range_of(*beam).is_finite()).collect();
        assert_eq!(seen, [4, 5, 6], "26.6 degrees to either side of the middle");
        // From the left behind us across the back to the right, a little beyond the seam.
        depth.clear();
        depth.draw_walls([&lanes(-3.0), &lanes(2.0), &lanes(3.1), &lanes(-4.5)]);
        let seen: Vec<usize> = (0..11).filter(|beam| depth.range_of(*beam).is_finite()).collect();
        assert_eq!(seen, [0], "it ends just to the right of straight right");
    }

    #[test]
    fn a_disc_is_as_near_as_its_surface() {
        let mut depth = DepthBuffer::new(360, 0.0, f64::from(TAU) / 360.0, 10.0);
        depth.draw_discs([&lanes(3.0), &lanes(0.0), &lanes(0.5)]);
        assert!((depth.range_of(0) - 2.5).abs() < 1e-6);
        let seen = (0..360).filter(|beam| depth.range_of(*beam).is_finite()).count();
        assert_eq!(seen, 19, "asin(0.5 / 3) is 9.59 degrees");
    }
}
