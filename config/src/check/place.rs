//! The place: sound shapes, and nothing that starts or is to go inside them.

use super::Checker;
use crate::geometry::{Point, area, distance, self_intersection};
use crate::path::join;
use crate::read::world::{WorldParts, is_generated};
use crate::report::Words;
use crate::walls::Walls;

/// Most corners of all polygons and polylines together: simulated beams are held against each.
const CORNERS_MAX: usize = 20_000;
/// A polygon smaller than this is a slip of the pen, m^2: a square of 1 mm.
const AREA_M2_MIN: f64 = 1e-6;

impl Checker<'_> {
    /// The shapes of the world whose table is at `prefix`. What comes back are those that are sound: a robot is not
    /// told that it stands outside of a wall that is itself wrong.
    pub(crate) fn world(&mut self, prefix: &str, world: &WorldParts) -> WorldParts {
        let mut sound = WorldParts {
            circles: world.circles.clone(),
            map: world.map.clone(),
            movers: world.movers.clone(),
            ..WorldParts::default()
        };
        let mut enclosed = false;
        // Of too many corners none is looked at: that would take long.
        let few = self.corners(prefix, world);
        for (index, polygon) in &world.polygons {
            let (generated, path) = (is_generated(*index), join(prefix, &format!("polygons[{index}]")));
            let simple = generated || few && self.polygon(&join(&path, "points_m"), &polygon.points_m);
            if generated && polygon.enclosure && enclosed {
                let words = Words::new("an enclosure beside another one", "at most one", "make the other an obstacle");
                self.report.push_path(self.root, &join(prefix, "generate"), words);
            } else if polygon.enclosure && enclosed {
                let words = Words::new("another enclosure", "at most one", "make it an obstacle: enclosure = false");
                self.report.push_path(self.root, &join(&path, "enclosure"), words);
            } else if simple {
                sound.polygons.push((*index, polygon.clone()));
            }
            enclosed |= polygon.enclosure;
        }
        for (index, polyline) in &world.polylines {
            let path = join(prefix, &format!("polylines[{index}].points_m"));
            if self.polyline(&path, &polyline.points_m) {
                sound.polylines.push((*index, polyline.clone()));
            }
        }
        sound
    }

    /// Whether there are few enough corners.
    fn corners(&mut self, prefix: &str, world: &WorldParts) -> bool {
        let outlines: usize = world.polygons.iter().map(|(_, polygon)| polygon.points_m.len()).sum();
        let lines: usize = world.polylines.iter().map(|(_, polyline)| polyline.points_m.len()).sum();
        let corners = outlines + lines;
        if corners > CORNERS_MAX {
            let words = Words::new(format!("{corners} corners"), format!("at most {CORNERS_MAX}"), "simplify outlines");
            let key = if outlines >= lines { "polygons" } else { "polylines" };
            self.report.push_path(self.root, &join(prefix, key), words);
        }
        corners <= CORNERS_MAX
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

    /// A thin wall goes somewhere: no corner follows on itself.
    fn polyline(&mut self, path: &str, points: &[Point]) -> bool {
        let Some(corner) = points.iter().zip(points.iter().skip(1)).position(|(a, b)| distance(*a, *b) <= 0.0) else {
            return true;
        };
        let found = format!("corners {corner} and {} at the same place", corner + 1);
        let words = Words::new(found, "corners each at another place than the one before", "leave one of them out");
        self.report.push_path(self.root, path, words);
        false
    }

    /// A body of `radius_m` at `point` must be clear of walls.
    pub(crate) fn clear_of_walls(&mut self, path: &str, point: Point, radius_m: f64, walls: &Walls<'_>) {
        if let Some(wall) = walls.at(point, radius_m) {
            let found = format!("[{}, {}], {wall}", point[0], point[1]);
            let expected = format!("a place with {radius_m} m of free floor around it");
            self.report.push_path(self.root, path, Words::new(found, expected, "move it away from the wall"));
        }
    }
}
