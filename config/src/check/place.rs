//! The place: sound shapes, and nothing that starts or is to go inside them.

use super::Checker;
use crate::geometry::{Point, area, contains, distance, outline_distance, self_intersection};
use crate::path::join;
use crate::read::world::WorldParts;
use crate::report::Words;

/// Most corners of all polygons together: every robot's start is held against each.
const CORNERS_MAX: usize = 20_000;
/// A polygon smaller than this is a slip of the pen, m^2: a square of 1 mm.
const AREA_M2_MIN: f64 = 1e-6;

impl Checker<'_> {
    /// The shapes of the world whose table is at `prefix`. What comes back are those that are sound: a robot is not
    /// told that it stands outside of a wall that is itself wrong.
    pub(crate) fn world(&mut self, prefix: &str, world: &WorldParts) -> WorldParts {
        let mut sound = WorldParts { circles: world.circles.clone(), ..WorldParts::default() };
        let mut enclosed = false;
        for (index, polygon) in &world.polygons {
            let path = join(prefix, &format!("polygons[{index}]"));
            let simple = self.polygon(&join(&path, "points_m"), &polygon.points_m);
            if polygon.enclosure && enclosed {
                let words = Words::new("another enclosure", "at most one", "make it an obstacle: enclosure = false");
                self.report.push_path(self.root, &join(&path, "enclosure"), words);
            } else if simple {
                sound.polygons.push((*index, polygon.clone()));
            }
            enclosed |= polygon.enclosure;
        }
        self.corners(prefix, world);
        sound
    }

    fn corners(&mut self, prefix: &str, world: &WorldParts) {
        let corners: usize = world.polygons.iter().map(|(_, polygon)| polygon.points_m.len()).sum();
        if corners > CORNERS_MAX {
            let words = Words::new(format!("{corners} corners"), format!("at most {CORNERS_MAX}"), "simplify outlines");
            self.report.push_path(self.root, &join(prefix, "polygons"), words);
        }
    }

    /// Whether a polygon is simple and has an area.
    fn polygon(&mut self, path: &str, points: &[Point]) -> bool {
        let words = if let Some((first, second)) = self_intersection(points) {
            let found = format!("edges {first} and {second} (from corner {first} and {second}) that touch or cross");
            Words::new(found, "a simple polygon", "list the corners in order, each once, without crossing")
        } else if area(points) < AREA_M2_MIN {
            Words::new(format!("an area of {} m^2", area(points)), "corners around an area", "check the corners")
        } else {
            return true;
        };
        self.report.push_path(self.root, path, words);
        false
    }

    /// A body of `radius_m` at `point` must be clear of walls.
    pub(crate) fn clear_of_walls(&mut self, path: &str, point: Point, radius_m: f64, world: &WorldParts) {
        if let Some(wall) = wall_at(point, radius_m, world) {
            let found = format!("[{}, {}], {wall}", point[0], point[1]);
            let expected = format!("a place with {radius_m} m of free floor around it");
            self.report.push_path(self.root, path, Words::new(found, expected, "move it away from the wall"));
        }
    }
}

/// Which wall a disc touches, if any.
fn wall_at(point: Point, radius_m: f64, world: &WorldParts) -> Option<String> {
    let polygon = world.polygons.iter().find_map(|(index, polygon)| {
        let inside = contains(&polygon.points_m, point);
        let gap_m = outline_distance(point, &polygon.points_m);
        match (polygon.enclosure, inside) {
            (true, false) => Some(format!("outside of the enclosure polygons[{index}]")),
            (false, true) => Some(format!("inside polygons[{index}]")),
            (true, true) | (false, false) if gap_m < radius_m => Some(format!("{gap_m:.3} m from polygons[{index}]")),
            (true, true) | (false, false) => None,
        }
    });
    polygon.or_else(|| {
        world.circles.iter().find_map(|(index, circle)| {
            let gap_m = distance(point, circle.centre_m) - circle.radius_m;
            if gap_m < 0.0 {
                Some(format!("inside circles[{index}]"))
            } else {
                (gap_m < radius_m).then(|| format!("{gap_m:.3} m from circles[{index}]"))
            }
        })
    })
}
