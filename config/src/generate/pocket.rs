//! Pockets that a robot runs into when it goes straight: a U, as it is or by chance, a T, a comb.

use super::chance::Chance;
use super::fault::Room;
use super::floor::Floor;
use super::{Misfit, Mm, Outline, Size, bays, metres, mm};

/// A U in the middle of the place that opens to the west, where robots start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct U {
    /// Free width between its arms, metres.
    pub(crate) opening_m: f64,
    /// Free depth from the arms' ends to the bottom, metres.
    pub(crate) depth_m: f64,
    /// Thickness of its walls, metres.
    pub(crate) wall_m: f64,
    /// Least free floor around it, metres.
    pub(crate) passage_m: f64,
}

impl U {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (opening, depth, wall) = (mm(self.opening_m), mm(self.depth_m), mm(self.wall_m));
        Room { key: "opening_m", found: opening, least: mm(self.passage_m) }.check("passage_m")?;
        let [x, y] = in_the_middle(size, [depth + wall, opening + 2 * wall], mm(self.passage_m))?;
        let mut floor = Floor::open(size);
        floor.fill(x, (y.0, y.0 + wall));
        floor.fill(x, (y.1 - wall, y.1));
        floor.fill((x.1 - wall, x.1), y);
        Ok(floor)
    }
}

/// A U as chance makes it, near the middle of the place: of any width and depth between bounds, turned and moved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pocket {
    /// Least and greatest free width between its arms, metres.
    pub(crate) opening_m: [f64; 2],
    /// Least and greatest free depth from the arms' ends to the bottom, metres.
    pub(crate) depth_m: [f64; 2],
    /// Thickness of its walls, metres.
    pub(crate) wall_m: f64,
    /// How far it is turned at most from opening to the west, either way, radians.
    pub(crate) turn_rad_max: f64,
    /// How far its middle is moved at most, along either axis and either way, metres.
    pub(crate) offset_m_max: f64,
    /// Least free floor around it, metres.
    pub(crate) passage_m: f64,
}

impl Pocket {
    pub(super) fn outlines(&self, size: Size, chance: &mut Chance) -> Result<Vec<Outline>, Misfit> {
        self.check(size)?;
        let wall = mm(self.wall_m);
        let [opening, depth] = [self.opening_m, self.depth_m].map(|[low, high]| chance.between(mm(low), mm(high)));
        let turn_rad = (2.0 * chance.share() - 1.0) * self.turn_rad_max;
        let offset = mm(self.offset_m_max);
        let middle = [size.width, size.height].map(|side| side / 2 + chance.between(-offset, offset));
        // Around its own middle, counter-clockwise, before it is turned.
        let (length, breadth) = (depth + wall, opening + 2 * wall);
        let (west, east, bottom) = (-length / 2, length - length / 2, length - length / 2 - wall);
        let (south, north) = (-breadth / 2, breadth - breadth / 2);
        let corners = [
            [west, south],
            [east, south],
            [east, north],
            [west, north],
            [west, north - wall],
            [bottom, north - wall],
            [bottom, south + wall],
            [west, south + wall],
        ];
        let (sin, cos) = (libm::sin(turn_rad), libm::cos(turn_rad));
        let turned = |[x, y]: [Mm; 2]| {
            let (x_m, y_m) = (metres(x), metres(y));
            [middle[0] + mm(cos * x_m - sin * y_m), middle[1] + mm(sin * x_m + cos * y_m)]
        };
        let enclosure = vec![[0, 0], [size.width, 0], [size.width, size.height], [0, size.height]];
        Ok(vec![enclosure, corners.map(turned).to_vec()])
    }

    /// Whether it fits whatever chance makes of it.
    fn check(&self, size: Size) -> Result<(), Misfit> {
        let bounds = [("opening_max_m", "opening_min_m", self.opening_m), ("depth_max_m", "depth_min_m", self.depth_m)];
        for (key, other, [low_m, high_m]) in bounds {
            if high_m < low_m {
                let expected = format!("at least {other}, {low_m} m");
                return Err(Misfit::new(key, format!("{high_m} m"), expected, "swap them"));
            }
        }
        let passage = mm(self.passage_m);
        Room { key: "opening_min_m", found: mm(self.opening_m[0]), least: passage }.check("passage_m")?;
        // A circle around it, and what rounding adds.
        let diameter_m = libm::hypot(self.depth_m[1] + self.wall_m, self.opening_m[1] + 2.0 * self.wall_m) + metres(4);
        let least = mm(diameter_m) + 2 * (mm(self.offset_m_max) + passage);
        let sum = "the greatest pocket, however turned, and offset_m_max and passage_m on both sides of it";
        Room { key: "width_m", found: size.width, least }.check(sum)?;
        Room { key: "height_m", found: size.height, least }.check(sum)
    }
}

/// A T in the middle of the place, its stem to the west, where robots start: a dead end on either side of the stem.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tee {
    /// Length of the bar, metres.
    pub(crate) bar_m: f64,
    /// Length of the stem, metres.
    pub(crate) stem_m: f64,
    /// Thickness of bar and stem, metres.
    pub(crate) wall_m: f64,
    /// Least free floor around it, metres.
    pub(crate) passage_m: f64,
}

impl Tee {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (bar, stem, wall) = (mm(self.bar_m), mm(self.stem_m), mm(self.wall_m));
        Room { key: "bar_m", found: bar, least: 3 * wall }.check("three times wall_m, or it is no T")?;
        let [x, y] = in_the_middle(size, [stem + wall, bar], mm(self.passage_m))?;
        let mut floor = Floor::open(size);
        floor.fill((x.1 - wall, x.1), y);
        let low = y.0 + (bar - wall) / 2;
        floor.fill(x, (low, low + wall));
        Ok(floor)
    }
}

/// Where something of that size stands in the middle, with `passage` around it.
fn in_the_middle(size: Size, [width, height]: [Mm; 2], passage: Mm) -> Result<[(Mm, Mm); 2], Misfit> {
    let sum = "what stands in the middle, and passage_m on both sides of it";
    Room { key: "width_m", found: size.width, least: width + 2 * passage + 1 }.check(sum)?;
    Room { key: "height_m", found: size.height, least: height + 2 * passage + 1 }.check(sum)?;
    let (west, south) = ((size.width - width) / 2, (size.height - height) / 2);
    Ok([(west, west + width), (south, south + height)])
}

/// Pockets side by side along the north wall, all open to one corridor in the south.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Comb {
    /// How many there are.
    pub(crate) pockets: usize,
    /// Their depth, metres.
    pub(crate) depth_m: f64,
    /// Thickness of the walls between them, metres.
    pub(crate) wall_m: f64,
    /// Least width of a pocket and of the corridor, metres.
    pub(crate) passage_m: f64,
}

impl Comb {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (depth, wall, passage) = (mm(self.depth_m), mm(self.wall_m), mm(self.passage_m));
        let least = self.pockets as Mm * (passage + wall) - wall;
        Room { key: "width_m", found: size.width, least }
            .check("the pockets, each passage_m wide, and walls between")?;
        Room { key: "height_m", found: size.height, least: depth + passage }.check("depth_m and passage_m")?;
        let mut floor = Floor::open(size);
        let pockets = bays(size.width, self.pockets, wall);
        for (left, right) in pockets.iter().zip(pockets.iter().skip(1)) {
            floor.fill((left.1, right.0), (size.height - depth, size.height));
        }
        Ok(floor)
    }
}
