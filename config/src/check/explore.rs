//! Exploration must be one that these robots can do in this place: on a board that ends somewhere and is not too large,
//! with cells that are small beside bodies.

use super::Checker;
use crate::boxes::bounds;
use crate::geometry::Point;
use crate::path::join;
use crate::read::robot::RobotParts;
use crate::read::world::WorldParts;
use crate::report::Words;
use crate::{Explore, Kind, SimMotion};

/// Most cells, 500 x 500: a decision may look at all of them.
const CELLS_MAX: f64 = 250_000.0;

impl Checker<'_> {
    /// Whatever does not hang on a place.
    pub(crate) fn exploration<'k>(&mut self, explore: &Explore, kinds: impl Iterator<Item = &'k Kind>) {
        // A point is as large as a cell; a body on cells of its own size would not know whether it fits through a door.
        let bodies = kinds.filter(|kind| kind.sim.motion != SimMotion::Point);
        let smallest = bodies.min_by(|a, b| a.body.radius_m.total_cmp(&b.body.radius_m));
        if let Some(kind) = smallest.filter(|kind| explore.cell_m > kind.body.radius_m) {
            let radius_m = kind.body.radius_m;
            let expected = format!("at most the radius of the smallest body, {radius_m} (kind {:?})", kind.name);
            let advice = "choose smaller cells: 0.2 m suits robots of half a metre";
            self.explore_problem("cell_m", Words::new(explore.cell_m.to_string(), expected, advice));
        }
        if explore.far_cells <= explore.near_cells {
            let expected = format!("more than near_cells, {}", explore.near_cells);
            self.explore_problem("far_cells", Words::new(explore.far_cells.to_string(), expected, "raise it"));
        }
    }

    /// What is to be mapped ends somewhere, and has not too many cells.
    pub(crate) fn board(&mut self, explore: &Explore, world: &WorldParts) {
        let enclosure = world.polygons.iter().find(|(_, polygon)| polygon.enclosure);
        let size_m = match (explore.area_m, enclosure, &world.map) {
            (Some(area_m), _, _) => size_m(area_m),
            (None, Some((_, enclosure)), _) => {
                bounds(enclosure.points_m.iter().copied()).map(size_m).unwrap_or_default()
            }
            (None, None, Some(map)) => [map.width, map.height].map(|cells| cells as f64 * map.resolution_m),
            (None, None, None) => {
                let words = Words::new(
                    "\"explore\" in a world without an enclosure and without a map",
                    "a world that ends somewhere, or area_m",
                    "add a polygon with enclosure = true: nobody could ever have seen everything",
                );
                return self.explore_problem("kind", words);
            }
        };
        self.cells(explore, size_m);
    }

    /// A robot in the field has no world: its file says what is to be mapped.
    pub(crate) fn area(&mut self, explore: &Explore) {
        match explore.area_m {
            Some(area_m) => self.cells(explore, size_m(area_m)),
            None => {
                let allowed = "two points [[x_min, y_min], [x_max, y_max]]";
                let advice = "say what is to be mapped: a robot in the field has no world to look it up in";
                self.explore_problem("area_m", Words::new("nothing", allowed, advice));
            }
        }
    }

    /// Nobody starts where there is no map: such a robot could never plan a way.
    pub(crate) fn starts_in_area<'r>(&mut self, explore: &Explore, robots: impl Iterator<Item = &'r RobotParts>) {
        let Some([low, high]) = explore.area_m else { return };
        for robot in robots {
            let Some(start) = robot.start else { continue };
            let at = [start.x_m, start.y_m];
            if (0..2).all(|axis| (low[axis]..=high[axis]).contains(&at[axis])) {
                continue;
            }
            let path = if robot.of_fleet { robot.path.clone() } else { join(&robot.path, "start") };
            let expected = format!("within behaviour.area_m, [{low:?}, {high:?}]");
            let words = Words::new(format!("a start at {at:?}"), expected, "move the start, or widen area_m");
            return self.report.push_path(self.root, &path, words);
        }
    }

    fn cells(&mut self, explore: &Explore, size_m: [f64; 2]) {
        let cells = (size_m[0] / explore.cell_m) * (size_m[1] / explore.cell_m);
        if cells > CELLS_MAX {
            let found =
                format!("{} m, which makes {:.0} cells of {} m x {} m", explore.cell_m, cells, size_m[0], size_m[1]);
            self.explore_problem("cell_m", Words::new(found, format!("at most {CELLS_MAX} cells"), "raise it"));
        }
    }

    fn explore_problem(&mut self, key: &str, words: Words) {
        self.report.push_path(self.root, &join("behaviour", key), words);
    }
}

fn size_m([low, high]: [Point; 2]) -> [f64; 2] {
    [high[0] - low[0], high[1] - low[1]]
}
