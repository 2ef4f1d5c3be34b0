use super::*;
use crate::geometry::CellBlocks;
use crate::walls::Walls;
use drover_config::{Circle, GridMap, Polygon, Polyline, UnknownCells, World};
use drover_contract::math::sin_cos;
use proptest::prelude::*;
use std::sync::Arc;

fn params(beams: u32) -> LidarParams {
    LidarParams {
        beams,
        fov_rad: TAU,
        mount: Mount::default(),
        range_m_min: 0.1,
        range_m_max: 10.0,
        range_noise_m: 0.0,
        range_step_m: 0.0,
        beam_dropout: 0.0,
        sweep: false,
    }
}

fn room(circles: Vec<Circle>, boxes: Vec<Polygon>) -> Walls {
    room_with(circles, boxes, vec![])
}

fn room_with(circles: Vec<Circle>, boxes: Vec<Polygon>, polylines: Vec<Polyline>) -> Walls {
    let outer = Polygon { enclosure: true, points_m: vec![[-8.0, -6.0], [8.0, -6.0], [8.0, 6.0], [-8.0, 6.0]] };
    let polygons = std::iter::once(outer).chain(boxes).collect();
    Walls::new(&World { name: "room".into(), polygons, circles, polylines, ..World::default() })
}

fn scan(lidar: &mut Lidar, walls: &Walls, pose_wb: Pose) -> Scan {
    lidar.scan(Stamp::ZERO, pose_wb, &Around { walls, bodies: &[] })
}

/// Walls and bodies around a lidar.
struct Around<'a> {
    walls: &'a Walls,
    bodies: &'a [Silhouette<'a>],
}

impl Scenery for Around<'_> {
    fn sight(&self) -> &Sight {
        self.walls.sight()
    }

    fn bodies_near(&self, _from_w: Vec2, _range_m: f64, see: &mut dyn FnMut(Silhouette<'_>)) {
        self.bodies.iter().for_each(|body| see(*body));
    }
}

fn range_m(beam: Beam) -> Option<f64> {
    match beam {
        Beam::Hit(range_m) => Some(range_m),
        Beam::Clear | Beam::Unknown => None,
    }
}

#[test]
fn beams_go_counter_clockwise_from_straight_ahead() {
    let mut lidar = Lidar::new(params(4), 1, 1);
    let seen = scan(&mut lidar, &room(vec![], vec![]), Pose::new(1.0, 2.0, 0.0));
    let ranges: Vec<f64> = seen.beams.iter().filter_map(|beam| range_m(*beam)).collect();
    let expected = [7.0, 4.0, 9.0, 8.0];
    assert!(ranges.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{ranges:?}");
    let seen = scan(&mut lidar, &room(vec![], vec![]), Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2));
    assert!((range_m(seen.beams[0]).unwrap() - 4.0).abs() < 1e-5, "it turns with the body");
}

#[test]
fn a_part_of_a_turn_sees_what_is_there() {
    let post = |n| Circle { centre_m: [3.0 * libm::cos(f64::from(n)), 3.0 * libm::sin(f64::from(n))], radius_m: 0.2 };
    let walls = room((0..12).map(post).collect(), vec![]);
    for (beams, yaw) in (2..60).flat_map(|beams| [0.0, 1.0, 2.0, -3.0].map(|yaw| (beams, yaw))) {
        let part = LidarParams { fov_rad: f64::from(beams) * 0.1, range_m_max: 30.0, ..params(beams) };
        let pose_wb = Pose::new(0.3, -0.2, yaw);
        let seen = scan(&mut Lidar::new(part, 1, 1), &walls, pose_wb);
        for (index, beam) in seen.beams.iter().enumerate() {
            // A beam that grazes a post may see it or not.
            let agrees = |nudge_rad: f64| {
                let (sin, cos) = libm::sincos(yaw + seen.angle_rad(index) + nudge_rad);
                let ray_m = walls.ray_m(pose_wb.position(), Vec2::new(cos, sin), 30.0).unwrap();
                range_m(*beam).is_some_and(|range_m| (range_m - ray_m).abs() < 1e-3)
            };
            assert!([0.0, 1e-5, -1e-5].into_iter().any(agrees), "beam {index} of {beams} at {yaw}: {beam:?}");
        }
    }
}

#[test]
fn too_near_is_unknown_and_too_far_is_clear() {
    let mut lidar = Lidar::new(LidarParams { range_m_min: 5.0, range_m_max: 7.5, ..params(4) }, 1, 1);
    let seen = scan(&mut lidar, &room(vec![], vec![]), Pose::new(1.0, 2.0, 0.0));
    assert!(matches!(seen.beams[..], [Beam::Hit(_), Beam::Unknown, Beam::Clear, Beam::Clear]), "{seen:?}");
}

#[test]
fn another_body_hides_the_wall_behind_it() {
    let walls = room(vec![], vec![]);
    let other = Disc { centre_w: Vec2::new(3.0, 0.0), radius_m: 0.5 };
    let mut lidar = Lidar::new(params(360), 1, 1);
    let seen = lidar.scan(Stamp::ZERO, Pose::default(), &Around { walls: &walls, bodies: &[Silhouette::Disc(other)] });
    assert!((range_m(seen.beams[0]).unwrap() - 2.5).abs() < 1e-5);
    let hidden = seen.beams.iter().filter(|beam| range_m(**beam).is_some_and(|range| range < 3.1)).count();
    assert_eq!(hidden, 19, "asin(0.5 / 3) = 9.6 degrees to each side");
}

#[test]
fn dropout_and_noise_are_as_wide_as_asked() {
    let noisy = LidarParams { range_noise_m: 0.02, beam_dropout: 0.1, ..params(3600) };
    let walls = room(vec![], vec![]);
    let exact = scan(&mut Lidar::new(params(3600), 1, 1), &walls, Pose::default());
    let seen = scan(&mut Lidar::new(noisy, 1, 1), &walls, Pose::default());
    assert!((seen.unknown_share() - 0.1).abs() < 0.02, "{}", seen.unknown_share());
    let pairs = exact.beams.iter().zip(&seen.beams).filter_map(|(a, b)| Some(range_m(*a)? - range_m(*b)?));
    let squares: Vec<f64> = pairs.map(|error| error * error).collect();
    let deviation = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((deviation - 0.02).abs() < 0.002, "{deviation}");
}

#[test]
fn a_robots_noise_depends_on_its_seed_and_id_only() {
    let noisy = LidarParams { range_noise_m: 0.02, beam_dropout: 0.1, ..params(72) };
    let walls = room(vec![], vec![]);
    let of = |seed, key| scan(&mut Lidar::new(noisy, seed, key), &walls, Pose::default());
    assert_eq!(of(1, 1), of(1, 1));
    assert_ne!(of(1, 1), of(1, 2));
    assert_ne!(of(1, 1), of(2, 1));
}

/// A convex obstacle around a centre, by its corners' angles.
fn convex() -> impl Strategy<Value = Polygon> {
    let shape = (-7.0..7.0f64, -5.0..5.0f64, 0.1..1.5f64, prop::collection::vec(0.0..TAU, 3..8));
    shape.prop_map(|(x, y, radius_m, mut angles)| {
        angles.sort_by(f64::total_cmp);
        let corner = |angle_rad: &f64| {
            let (sin, cos) = sin_cos(*angle_rad);
            [x + radius_m * cos, y + radius_m * sin]
        };
        let points_m = angles.iter().map(corner).collect();
        Polygon { enclosure: false, points_m }
    })
}

fn round() -> impl Strategy<Value = Circle> {
    (-7.0..7.0f64, -5.0..5.0f64, 0.05..1.0f64).prop_map(|(x, y, radius_m)| Circle { centre_m: [x, y], radius_m })
}

/// Thin walls: seen from both sides.
fn thin() -> impl Strategy<Value = Polyline> {
    let corners = prop::collection::vec((-7.0..7.0f64, -5.0..5.0f64), 2..5);
    corners.prop_map(|corners| Polyline { points_m: corners.into_iter().map(|(x, y)| [x, y]).collect() })
}

/// A map of 24 x 16 cells of half a metre around the origin: a rim, and some cells within.
fn cells() -> impl Strategy<Value = GridMap> {
    let (width, height) = (24, 16);
    prop::collection::vec(0.0..1.0f64, width * height).prop_map(move |draws| {
        let rim = |index: usize| {
            let (x, y) = (index % width, index / width);
            x == 0 || y == 0 || x == width - 1 || y == height - 1
        };
        GridMap {
            file: String::new(),
            unknown: UnknownCells::Solid,
            resolution_m: 0.5,
            origin_m: [-6.0, -4.0],
            origin_yaw_rad: 0.0,
            width,
            height,
            solid: draws.iter().enumerate().map(|(index, draw)| rim(index) || *draw < 0.15).collect(),
        }
    })
}

/// Every beam of a scan agrees with a ray of parry's.
///
/// A beam that grazes an edge may see either side of it: it then agrees with a ray turned by up to a hair. By less,
/// too, since the range to a disc's rim goes by the square root of the angle.
fn assert_agrees(seen: &Scan, pose_wb: Pose, ray_m: impl Fn(Vec2) -> Option<f64>) -> Result<(), TestCaseError> {
    let differ = |nudge_rad: f64| {
        let off = |index: &usize| {
            let (sin, cos) = sin_cos(seen.angle_rad(*index) + nudge_rad);
            let (ours, parrys) = (range_m(seen.beams[*index]), ray_m(pose_wb.rotate(Vec2::new(cos, sin))));
            !matches!((ours, parrys), (Some(a), Some(b)) if (a - b).abs() < 1e-3)
        };
        (0..seen.beams.len()).filter(off).collect::<Vec<_>>()
    };
    let plain = differ(0.0);
    let mut wrong = plain.clone();
    for step in (0..32).filter(|_| !plain.is_empty()) {
        let hair_rad = 1e-5 * 0.75_f64.powi(step);
        let (left, right) = (differ(hair_rad), differ(-hair_rad));
        wrong.retain(|index| left.contains(index) && right.contains(index));
    }
    prop_assert_eq!(wrong, Vec::<usize>::new());
    // An interval's ends are good to some millionths of a radian: one beam in thousands lies so close to one.
    prop_assert!(plain.len() <= 3, "{} grazing beams of {}", plain.len(), seen.beams.len());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_scan_of_a_random_world_equals_parrys_rays(
        boxes in prop::collection::vec(convex(), 0..8),
        circles in prop::collection::vec(round(), 0..8),
        lines in prop::collection::vec(thin(), 0..4),
        (x, y, yaw) in (-7.0..7.0f64, -5.0..5.0f64, -3.1..3.1f64),
        beams in 8..720u32,
    ) {
        let walls = room_with(circles, boxes, lines);
        let pose_wb = Pose::new(x, y, yaw);
        prop_assume!(!walls.is_solid(pose_wb.position()) && walls.distance_m(pose_wb.position()).unwrap() > 0.02);
        let mut lidar = Lidar::new(LidarParams { range_m_min: 0.0, range_m_max: 30.0, ..params(beams) }, 1, 1);
        let seen = scan(&mut lidar, &walls, pose_wb);
        assert_agrees(&seen, pose_wb, |along_w| walls.ray_m(pose_wb.position(), along_w, 30.0))?;
    }

    #[test]
    fn a_scan_of_a_random_map_equals_parrys_rays_at_its_cells(
        map in cells(), (x, y, yaw) in (-5.5..5.5f64, -3.5..3.5f64, -3.1..3.1f64), beams in 8..720u32,
    ) {
        let parrys = CellBlocks::new(&map);
        let walls = Walls::new(&World { name: "map".into(), map: Some(Arc::new(map)), ..World::default() });
        let pose_wb = Pose::new(x, y, yaw);
        prop_assume!(!walls.is_solid(pose_wb.position()) && walls.distance_m(pose_wb.position()).unwrap() > 0.02);
        let mut lidar = Lidar::new(LidarParams { range_m_min: 0.0, range_m_max: 30.0, ..params(beams) }, 1, 1);
        let seen = scan(&mut lidar, &walls, pose_wb);
        assert_agrees(&seen, pose_wb, |along_w| parrys.ray_m(pose_wb.position(), along_w, 30.0))?;
    }
}
