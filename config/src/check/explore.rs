//! Exploration must be one that these robots can do in this place: points, on a board that is closed and not too large.

use super::Checker;
use crate::boxes::bounds;
use crate::path::join;
use crate::read::world::WorldParts;
use crate::report::Words;
use crate::{Explore, Kind, SimMotion};

/// Most cells, 500 x 500: a decision may look at all of them.
const CELLS_MAX: f64 = 250_000.0;

impl Checker<'_> {
    /// Whatever does not hang on a place.
    pub(crate) fn exploration<'k>(&mut self, explore: &Explore, mut kinds: impl Iterator<Item = &'k Kind>) {
        if let Some(kind) = kinds.find(|kind| kind.sim.motion != SimMotion::Point) {
            let found = format!("\"explore\" with {:?}, a kind that is no point", kind.name);
            let expected =
                "simulated points (sim.motion = \"point\"): exploration is on cells, bodies do not do it yet";
            let advice = "set sim.motion = \"point\" in the kind, or choose another behaviour";
            self.explore_problem("kind", Words::new(found, expected, advice));
        }
        if explore.far_cells <= explore.near_cells {
            let expected = format!("more than near_cells, {}", explore.near_cells);
            self.explore_problem("far_cells", Words::new(explore.far_cells.to_string(), expected, "raise it"));
        }
    }

    /// The place is closed, and has not too many cells.
    pub(crate) fn board(&mut self, explore: &Explore, world: &WorldParts) {
        let enclosure = world.polygons.iter().find(|(_, polygon)| polygon.enclosure);
        let size_m = match (enclosure, &world.map) {
            (Some((_, enclosure)), _) => bounds(enclosure.points_m.iter().copied())
                .map(|[low, high]| [high[0] - low[0], high[1] - low[1]])
                .unwrap_or_default(),
            (None, Some(map)) => [map.width, map.height].map(|cells| cells as f64 * map.resolution_m),
            (None, None) => {
                let words = Words::new(
                    "\"explore\" in a world without an enclosure and without a map",
                    "a world that ends somewhere",
                    "add a polygon with enclosure = true: nobody could ever have seen everything",
                );
                return self.explore_problem("kind", words);
            }
        };
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
