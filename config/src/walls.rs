//! Where a disc may stand: the sound shapes of a world, found quickly.

use crate::boxes::{Bounds, Boxes, bounds};
use crate::geometry::{Point, crosses_ray, distance, edges, segment_distance};
use crate::read::world::{WorldParts, polygon_name};
use crate::{Circle, GridMap, UnknownCells};

/// The walls of a world.
pub(crate) struct Walls<'w> {
    world: &'w WorldParts,
    outlines: Vec<Outline>,
    pieces: Boxes<Piece>,
}

/// A polygon, with its index in the file.
struct Outline {
    index: usize,
    enclosure: bool,
    bounds: Bounds,
    edges: Boxes<(Point, Point)>,
}

/// A part of a wall, with its shape's index in the file.
enum Piece {
    /// The inside of an obstacle, by its place among the outlines.
    Inside(usize),
    /// One edge of an outline.
    Edge(usize, Point, Point),
    Circle(usize, Circle),
    /// One segment of a thin wall.
    Segment(usize, Point, Point),
}

/// What a disc touches. Of several, the first in this order is said.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
enum Touch {
    InsidePolygon(usize),
    Polygon(usize, f64),
    InsideCircle(usize),
    Circle(usize, f64),
    Polyline(usize, f64),
}

impl<'w> Walls<'w> {
    /// The walls of `world`, whose shapes are sound.
    pub(crate) fn new(world: &'w WorldParts) -> Self {
        let (mut pieces, mut outlines) = (Vec::new(), Vec::new());
        let segment_bounds = |(a, b): (Point, Point)| bounds([a, b]).unwrap_or([a, b]);
        for (index, polygon) in &world.polygons {
            let points = polygon.points_m.as_slice();
            let Some(whole) = bounds(points.iter().copied()) else { continue };
            if !polygon.enclosure {
                pieces.push((whole, Piece::Inside(outlines.len())));
            }
            pieces.extend(edges(points).map(|edge| (segment_bounds(edge), Piece::Edge(*index, edge.0, edge.1))));
            let edges = Boxes::new(edges(points).map(|edge| (segment_bounds(edge), edge)).collect());
            outlines.push(Outline { index: *index, enclosure: polygon.enclosure, bounds: whole, edges });
        }
        for (index, circle) in &world.circles {
            let ([x_m, y_m], radius_m) = (circle.centre_m, circle.radius_m);
            let square = [[x_m - radius_m, y_m - radius_m], [x_m + radius_m, y_m + radius_m]];
            pieces.push((square, Piece::Circle(*index, *circle)));
        }
        for (index, polyline) in &world.polylines {
            let points = &polyline.points_m;
            let segments = points.iter().copied().zip(points.iter().copied().skip(1));
            pieces.extend(segments.map(|(a, b)| (segment_bounds((a, b)), Piece::Segment(*index, a, b))));
        }
        Self { world, outlines, pieces: Boxes::new(pieces) }
    }

    /// Which wall a disc touches, in words, if any.
    pub(crate) fn at(&self, point: Point, radius_m: f64) -> Option<String> {
        if let Some(outline) = self.enclosures().find(|outline| !outline.contains(point)) {
            return Some(format!("outside of the enclosure {}", polygon_name(outline.index)));
        }
        self.touch(point, radius_m).map(words).or_else(|| map_at(self.world.map.as_deref()?, point, radius_m))
    }

    /// Whether a disc touches no wall.
    pub(crate) fn is_clear(&self, point: Point, radius_m: f64) -> bool {
        self.enclosures().all(|outline| outline.contains(point))
            && self.touch(point, radius_m).is_none()
            && self.world.map.as_deref().is_none_or(|map| map_is_clear(map, point, radius_m))
    }

    /// The rectangle that the world's enclosure or, without one, its map fills.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        let enclosure = self.enclosures().next().map(|outline| outline.bounds);
        enclosure.or_else(|| self.world.map.as_deref().and_then(map_bounds))
    }

    fn enclosures(&self) -> impl Iterator<Item = &Outline> {
        self.outlines.iter().filter(|outline| outline.enclosure)
    }

    fn touch(&self, point: Point, radius_m: f64) -> Option<Touch> {
        let area = [[point[0] - radius_m, point[1] - radius_m], [point[0] + radius_m, point[1] + radius_m]];
        let mut first: Option<Touch> = None;
        self.pieces.overlapping(area, &mut |piece| {
            let touch = piece.touch(&self.outlines, point, radius_m);
            if let Some(touch) = touch.filter(|touch| first.is_none_or(|first| *touch < first)) {
                first = Some(touch);
            }
        });
        first
    }
}

impl Outline {
    /// Whether `point` is inside: a ray to the east crosses the outline an odd number of times.
    fn contains(&self, point: Point) -> bool {
        let mut crossings = 0_usize;
        let ray = [point, [f64::INFINITY, point[1]]];
        self.edges.overlapping(ray, &mut |edge| crossings += usize::from(crosses_ray(*edge, point)));
        crossings % 2 == 1
    }
}

impl Piece {
    fn touch(&self, outlines: &[Outline], point: Point, radius_m: f64) -> Option<Touch> {
        let near = |a: Point, b: Point| Some(segment_distance(point, (a, b))).filter(|gap_m| *gap_m < radius_m);
        match self {
            Self::Inside(at) => {
                let outline = outlines.get(*at).filter(|outline| outline.contains(point));
                outline.map(|outline| Touch::InsidePolygon(outline.index))
            }
            Self::Edge(index, a, b) => near(*a, *b).map(|gap_m| Touch::Polygon(*index, gap_m)),
            Self::Segment(index, a, b) => near(*a, *b).map(|gap_m| Touch::Polyline(*index, gap_m)),
            Self::Circle(index, circle) => {
                let gap_m = distance(point, circle.centre_m) - circle.radius_m;
                match gap_m < 0.0 {
                    true => Some(Touch::InsideCircle(*index)),
                    false => (gap_m < radius_m).then_some(Touch::Circle(*index, gap_m)),
                }
            }
        }
    }
}

fn words(touch: Touch) -> String {
    match touch {
        Touch::InsidePolygon(index) => format!("inside {}", polygon_name(index)),
        Touch::Polygon(index, gap_m) => format!("{gap_m:.3} m from {}", polygon_name(index)),
        Touch::InsideCircle(index) => format!("inside circles[{index}]"),
        Touch::Circle(index, gap_m) => format!("{gap_m:.3} m from circles[{index}]"),
        Touch::Polyline(index, gap_m) => format!("{gap_m:.3} m from polylines[{index}]"),
    }
}

/// `point` in the map's own frame: from its south-west corner, along its rows, metres.
fn in_map(map: &GridMap, point: Point) -> Point {
    let (sin, cos) = (libm::sin(map.origin_yaw_rad), libm::cos(map.origin_yaw_rad));
    let [x_m, y_m] = [point[0] - map.origin_m[0], point[1] - map.origin_m[1]];
    [cos * x_m + sin * y_m, cos * y_m - sin * x_m]
}

/// Width and height of a map, metres.
fn map_size_m(map: &GridMap) -> Point {
    [map.width as f64 * map.resolution_m, map.height as f64 * map.resolution_m]
}

fn map_bounds(map: &GridMap) -> Option<Bounds> {
    let (sin, cos) = (libm::sin(map.origin_yaw_rad), libm::cos(map.origin_yaw_rad));
    let [width_m, height_m] = map_size_m(map);
    let corners = [[0.0, 0.0], [width_m, 0.0], [width_m, height_m], [0.0, height_m]];
    let turned = |[x_m, y_m]: Point| [map.origin_m[0] + cos * x_m - sin * y_m, map.origin_m[1] + sin * x_m + cos * y_m];
    bounds(corners.map(turned))
}

/// Which part of a map a disc touches, in words.
fn map_at(map: &GridMap, point: Point, radius_m: f64) -> Option<String> {
    let place = in_map(map, point);
    if let Some(edge_m) = map_edge_m(map, place, radius_m) {
        return Some(match edge_m < 0.0 {
            true => "outside of the map".to_owned(),
            false => format!("{edge_m:.3} m from the edge of the map"),
        });
    }
    let gap_m = solid_gaps_m(map, place, radius_m).reduce(f64::min)?;
    Some(match gap_m <= 0.0 {
        true => "inside a solid cell of the map".to_owned(),
        false => format!("{gap_m:.3} m from a solid cell of the map"),
    })
}

/// Whether a disc touches nothing of a map.
fn map_is_clear(map: &GridMap, point: Point, radius_m: f64) -> bool {
    let place = in_map(map, point);
    map_edge_m(map, place, radius_m).is_none() && solid_gaps_m(map, place, radius_m).next().is_none()
}

/// How far inside of a map's edge `place` (in the map's frame) is, if that is less than `radius_m`. Only if what lies
/// beyond, of which the map knows nothing, is solid.
fn map_edge_m(map: &GridMap, place: Point, radius_m: f64) -> Option<f64> {
    let size_m = map_size_m(map);
    let edge_m = (0..2).map(|axis| place[axis].min(size_m[axis] - place[axis])).fold(f64::INFINITY, f64::min);
    (map.unknown == UnknownCells::Solid && edge_m < radius_m).then_some(edge_m)
}

/// Distances from `place` (in the map's frame) to the solid cells that are nearer than `radius_m`, or hold it.
fn solid_gaps_m(map: &GridMap, place: Point, radius_m: f64) -> impl Iterator<Item = f64> {
    // `as` saturates: what is beyond the map's edges has no cells.
    let cell = |along_m: f64| (along_m / map.resolution_m).floor().max(0.0) as usize;
    let [columns, rows] = [(0, map.width), (1, map.height)]
        .map(|(axis, count)| cell(place[axis] - radius_m)..cell(place[axis] + radius_m + map.resolution_m).min(count));
    let away = |index: usize, along_m: f64| {
        let low_m = index as f64 * map.resolution_m;
        (low_m - along_m).max(along_m - low_m - map.resolution_m).max(0.0)
    };
    let in_row = move |row: usize| {
        let cells = map.solid.get(row * map.width..(row + 1) * map.width).unwrap_or_default();
        let cells = cells.get(columns.clone()).unwrap_or_default();
        let solid = columns.clone().zip(cells).filter(|(_, solid)| **solid);
        let row_m = away(row, place[1]);
        solid.map(move |(column, _)| libm::hypot(away(column, place[0]), row_m))
    };
    rows.flat_map(in_row).filter(move |gap_m| *gap_m < radius_m || *gap_m <= 0.0)
}
