//! Grid maps as walls: the border between free and solid cells, in long straight pieces.

use crate::geometry::Segment;
use drover_config::{GridMap, UnknownCells};
use drover_contract::{Pose, Vec2};

/// Whether a point of the world lies in a solid cell, or outside of a map whose unknown is solid.
pub(crate) fn is_solid(map: &GridMap, point_w: Vec2) -> bool {
    let at = frame(map).inverse_transform(point_w) / map.resolution_m;
    let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < map.width as f64 && at.y < map.height as f64;
    let here = inside.then(|| cell(map, at.x as i64, at.y as i64));
    here.unwrap_or(map.unknown == UnknownCells::Solid)
}

/// The border, free side on the left: every straight run of cell sides is one piece.
pub(crate) fn outline(map: &GridMap) -> Vec<Segment> {
    let (width, height) = (map.width as i64, map.height as i64);
    let mut border = Border { map, frame: frame(map), pieces: Vec::new() };
    for y in 0..=height {
        // Free above a solid: to the east. Free below: to the west.
        border.run(width, |x| (cell(map, x, y - 1), cell(map, x, y)), |x| Vec2::new(x, y as f64));
    }
    for x in 0..=width {
        // Free to the west of a solid: to the north. Free to the east: to the south.
        border.run(height, |y| (cell(map, x, y), cell(map, x - 1, y)), |y| Vec2::new(x as f64, y));
    }
    border.pieces
}

struct Border<'a> {
    map: &'a GridMap,
    frame: Pose,
    pieces: Vec<Segment>,
}

impl Border<'_> {
    /// Walk along one grid line of `count` cell sides. `sides(i)` says whether the cells right and left of it are
    /// solid; `place(i)` is where the side begins, in cells.
    fn run(&mut self, count: i64, sides: impl Fn(i64) -> (bool, bool), place: impl Fn(f64) -> Vec2) {
        let kind = |i: i64| if i < count { sides(i) } else { (false, false) };
        let mut from = 0;
        for i in 1..=count {
            if kind(i) == kind(from) {
                continue;
            }
            let (right_solid, left_solid) = kind(from);
            if right_solid != left_solid {
                let (a, b) = (place(from as f64), place(i as f64));
                self.push(if right_solid { (a, b) } else { (b, a) });
            }
            from = i;
        }
    }

    fn push(&mut self, (from, to): (Vec2, Vec2)) {
        let world = |at: Vec2| self.frame.transform(at * self.map.resolution_m);
        self.pieces.push(Segment { from_w: world(from), to_w: world(to) });
    }
}

/// The map's south-west corner in the world.
fn frame(map: &GridMap) -> Pose {
    Pose::new(map.origin_m[0], map.origin_m[1], map.origin_yaw_rad)
}

fn cell(map: &GridMap, x: i64, y: i64) -> bool {
    let inside = x >= 0 && y >= 0 && x < map.width as i64 && y < map.height as i64;
    if inside { map.solid[y as usize * map.width + x as usize] } else { map.unknown == UnknownCells::Solid }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rooms of one cell each that touch at a corner, in a 4 x 4 map; `#` is solid, the north row first.
    fn map(unknown: UnknownCells, origin_yaw_rad: f64) -> GridMap {
        let rows = ["####", "##.#", "#.##", "####"];
        let solid = rows.iter().rev().flat_map(|row| row.bytes().map(|byte| byte == b'#')).collect();
        GridMap {
            file: String::new(),
            unknown,
            resolution_m: 0.5,
            origin_m: [10.0, 20.0],
            origin_yaw_rad,
            width: 4,
            height: 4,
            solid,
        }
    }

    #[test]
    fn cells_are_found_where_the_map_lies() {
        let here = map(UnknownCells::Solid, 0.0);
        assert!(!is_solid(&here, Vec2::new(10.75, 20.75)) && !is_solid(&here, Vec2::new(11.25, 21.25)));
        assert!(is_solid(&here, Vec2::new(10.75, 21.25)) && is_solid(&here, Vec2::new(9.0, 20.0)));
        assert!(!is_solid(&map(UnknownCells::Free, 0.0), Vec2::new(9.0, 20.0)), "outside is free if unknown is");
        let turned = map(UnknownCells::Solid, std::f64::consts::FRAC_PI_2);
        assert!(!is_solid(&turned, Vec2::new(9.25, 20.75)), "a quarter turn takes (x, y) to (-y, x)");
    }

    #[test]
    fn the_border_has_its_free_side_on_the_left_and_its_length() {
        let here = map(UnknownCells::Solid, 0.3);
        let pieces = outline(&here);
        assert_eq!(pieces.len(), 8, "two rooms of four sides, and nothing where solid meets solid");
        for piece in pieces {
            let along = piece.to_w - piece.from_w;
            assert!((along.norm() - 0.5).abs() < 1e-12);
            let middle = (piece.from_w + piece.to_w) / 2.0;
            let left = Vec2::new(-along.y, along.x) * 0.1;
            assert!(!is_solid(&here, middle + left) && is_solid(&here, middle - left));
        }
    }

    #[test]
    fn long_walls_are_one_piece() {
        let mut hall = map(UnknownCells::Solid, 0.0);
        (hall.width, hall.height, hall.solid) = (1_000, 1, vec![false; 1_000]);
        assert_eq!(outline(&hall).len(), 4);
        hall.unknown = UnknownCells::Free;
        assert!(outline(&hall).is_empty());
    }
}
