//! Convex obstacles, scattered.

use super::chance::Chance;
use super::fault::Room;
use super::{Misfit, Mm, Outline, Size, metres, mm};
use std::f64::consts::TAU;

/// Tries to place one obstacle before the field is begun anew.
const TRIES_MAX: usize = 200;
/// Fields that are begun before the obstacles count as too many.
const FIELDS_MAX: usize = 4;
/// Fewest and most corners of an obstacle.
const CORNERS: (Mm, Mm) = (3, 8);
/// What rounding corners to millimetres may add to a radius.
const ROUNDING: Mm = 1;

/// Random convex polygons. Circles around them stay `passage_m` apart, so that a disc of that diameter gets from
/// anywhere to anywhere between them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConvexField {
    /// How few there are.
    pub(crate) count: usize,
    /// How many there are.
    pub(crate) count_max: usize,
    /// Smallest diameter of the circle through an obstacle's corners, metres.
    pub(crate) size_min_m: f64,
    /// Largest diameter, metres.
    pub(crate) size_max_m: f64,
    /// Least gap between two obstacles, metres.
    pub(crate) passage_m: f64,
    /// Free floor along the walls, metres: where a swarm starts and arrives.
    pub(crate) margin_m: f64,
    /// The same along the west wall.
    pub(crate) west_m: f64,
    /// The same along the east wall.
    pub(crate) east_m: f64,
}

/// The circle through an obstacle's corners, millimetres.
struct Circle {
    centre: [Mm; 2],
    radius: Mm,
}

impl ConvexField {
    pub(super) fn outlines(&self, size: Size, chance: &mut Chance) -> Result<Vec<Outline>, Misfit> {
        self.check(size)?;
        let count = match self.count_max > self.count {
            true => self.count + chance.below(self.count_max - self.count + 1),
            false => self.count,
        };
        let mut most = 0;
        for _ in 0..FIELDS_MAX {
            let circles = self.scatter(size, count, chance);
            if circles.len() == count {
                let enclosure = vec![[0, 0], [size.width, 0], [size.width, size.height], [0, size.height]];
                let obstacles = circles.iter().map(|circle| polygon(circle, chance));
                return Ok(std::iter::once(enclosure).chain(obstacles).collect());
            }
            most = most.max(circles.len());
        }
        let (gap_m, found) = (self.passage_m, format!("{count} obstacles, of which {most} found a place"));
        let expected = format!("as many as fit at random with {gap_m} m between and {} m around", self.margin_m);
        Err(Misfit::new(
            if self.count_max > self.count { "count_max" } else { "count" },
            found,
            expected,
            "lower it, size_max_m, passage_m or margins, or enlarge the place",
        ))
    }

    fn check(&self, size: Size) -> Result<(), Misfit> {
        if self.size_max_m < self.size_min_m {
            let expected = format!("at least size_min_m, {} m", self.size_min_m);
            return Err(Misfit::new("size_max_m", format!("{} m", self.size_max_m), expected, "swap them"));
        }
        if self.count_max < self.count {
            let expected = format!("at least count, {}", self.count);
            return Err(Misfit::new("count_max", self.count_max.to_string(), expected, "swap them"));
        }
        let largest = mm(self.size_max_m) + 4 * ROUNDING;
        let margins = [("margin_m", self.margin_m), ("margin_west_m", self.west_m), ("margin_east_m", self.east_m)];
        for (key, margin_m) in margins {
            let margin = Room { key, found: mm(margin_m), least: mm(self.passage_m) };
            margin.check("passage_m; robots go around")?;
        }
        let [margin, west, east] = margins.map(|(_, margin_m)| mm(margin_m));
        Room { key: "width_m", found: size.width, least: west + east + largest }
            .check("size_max_m, margin_west_m and margin_east_m (margin_m unless they are given)")?;
        Room { key: "height_m", found: size.height, least: 2 * margin + largest }.check("size_max_m and twice margin_m")
    }

    /// Circles with room between: all of them, or as many as found a place. The largest come first, which find it
    /// hardest.
    fn scatter(&self, size: Size, count: usize, chance: &mut Chance) -> Vec<Circle> {
        let [margin, west, east] = [self.margin_m, self.west_m, self.east_m].map(mm);
        let passage = mm(self.passage_m);
        let (low, high) = (mm(self.size_min_m / 2.0), mm(self.size_max_m / 2.0));
        let mut radii: Vec<Mm> = (0..count).map(|_| chance.between(low, high)).collect();
        radii.sort_unstable_by_key(|radius| -radius);
        let mut circles: Vec<Circle> = Vec::with_capacity(count);
        for radius in radii {
            let rim = radius + ROUNDING;
            let place = (0..TRIES_MAX).find_map(|_| {
                let x = chance.between(west + rim, size.width - east - rim);
                let centre = [x, chance.between(margin + rim, size.height - margin - rim)];
                let clear = |other: &Circle| {
                    let apart = radius + other.radius + passage + 2 * ROUNDING;
                    let [x, y] = [centre[0] - other.centre[0], centre[1] - other.centre[1]];
                    x * x + y * y >= apart * apart
                };
                circles.iter().all(clear).then_some(centre)
            });
            let Some(centre) = place else { break };
            circles.push(Circle { centre, radius });
        }
        circles
    }
}

/// A polygon with its corners on the circle, counter-clockwise: one anywhere in the first four fifths of each equal
/// share of the circle, so that no two are so near that rounding could fold them.
fn polygon(circle: &Circle, chance: &mut Chance) -> Outline {
    let count = chance.between(CORNERS.0, CORNERS.1);
    let turn = chance.share();
    let corner = |index: Mm, chance: &mut Chance| {
        let angle_rad = TAU * (turn + (index as f64 + 0.8 * chance.share()) / count as f64);
        let radius_m = metres(circle.radius);
        [circle.centre[0] + mm(radius_m * libm::cos(angle_rad)), circle.centre[1] + mm(radius_m * libm::sin(angle_rad))]
    };
    (0..count).map(|index| corner(index, chance)).collect()
}
