//! What is drawn: the place, the robots, and who hears whom.

use super::frames::{WORLD, body_frame, mover_frame, robot_frame};
use super::{color, point, pose, timestamp};
use crate::{Moment, MoverSetting, PlaceSetting, RobotSetting, Setting, Source};
use foxglove::messages::line_primitive::Type as Line;
use foxglove::messages::{
    ArrowPrimitive, Color, CylinderPrimitive, Duration, LinePrimitive, Point3, SceneEntity, SceneUpdate,
    SpherePrimitive, TextPrimitive, TriangleListPrimitive, Vector3,
};
use std::collections::BTreeMap;

/// Walls and obstacles are drawn this high, metres.
const WALL_M: f64 = 0.3;
/// Bodies are drawn this high, metres.
const BODY_M: f64 = 0.2;
/// What lies on the ground is drawn this far above it, metres.
const GROUND_M: f64 = 0.01;
/// Diameter of a target's sphere, metres.
const TARGET_M: f64 = 0.12;
/// What moves without a frame of its own is seen this long, s: longer than it takes until it is told anew.
const LIFETIME_S: i32 = 1;

const WALL: [f64; 4] = [0.55, 0.58, 0.62, 1.0];
const OBSTACLE: [f64; 4] = [0.45, 0.40, 0.36, 1.0];
const ROUTE: [f64; 4] = [0.25, 0.55, 0.95, 0.8];
const GOAL: [f64; 4] = [0.20, 0.75, 0.35, 0.4];
const KEPT: [f64; 4] = [0.95, 0.60, 0.10, 1.0];
const HEARD: [f64; 4] = [0.60, 0.65, 0.70, 0.5];
const TEXT: [f64; 4] = [1.0, 1.0, 1.0, 1.0];

/// The place, the ways of what moves in it, the leader's way and the goal, in the frame `world`; and each mover in the
/// frame that moves with it. It stays: it is sent once.
#[must_use]
pub fn scene_place(unix_us: u64, setting: &Setting) -> SceneUpdate {
    let route = SceneEntity {
        lines: line(Line::LineStrip, points(&setting.route_m, 2.0 * GROUND_M), 2.0, ROUTE).into_iter().collect(),
        ..entity(unix_us, WORLD.into(), "route")
    };
    let goal = setting.goal.map(|goal| cylinder(goal.at_m, goal.within_m, GROUND_M, color(GOAL)));
    let goal = SceneEntity { cylinders: goal.into_iter().collect(), ..entity(unix_us, WORLD.into(), "goal") };
    let mut entities = vec![place(unix_us, &setting.place), route, goal];
    entities.extend((1..).zip(&setting.place.movers).map(|(number, it)| mover(unix_us, number, it)));
    SceneUpdate { deletions: Vec::new(), entities }
}

fn place(unix_us: u64, place: &PlaceSetting) -> SceneEntity {
    let mut drawn = entity(unix_us, WORLD.into(), "place");
    let closed = std::iter::once((&place.enclosure_m, WALL));
    let closed = closed.chain(place.polygons_m.iter().map(|outline| (outline, OBSTACLE)));
    for (outline_m, paint) in closed {
        drawn.triangles.extend(walls(outline_m, true, WALL_M, color(paint)));
        drawn.lines.extend(line(Line::LineLoop, points(outline_m, WALL_M), 2.0, paint));
    }
    for chain_m in &place.polylines_m {
        drawn.triangles.extend(walls(chain_m, false, WALL_M, color(WALL)));
        drawn.lines.extend(line(Line::LineStrip, points(chain_m, WALL_M), 2.0, WALL));
    }
    let circles = place.circles_m.iter();
    drawn.cylinders.extend(circles.map(|[x, y, radius_m]| cylinder([*x, *y], *radius_m, WALL_M, color(OBSTACLE))));
    for mover in &place.movers {
        drawn.lines.extend(line(Line::LineLoop, points(&mover.round_m, 2.0 * GROUND_M), 1.0, OBSTACLE));
    }
    drawn
}

fn mover(unix_us: u64, number: usize, mover: &MoverSetting) -> SceneEntity {
    let body = cylinder([0.0, 0.0], mover.radius_m, WALL_M, color(OBSTACLE));
    SceneEntity { cylinders: vec![body], ..entity(unix_us, mover_frame(number), &mover_frame(number)) }
}

/// The robots, each in the frame that moves with it: `body-N` in simulation, `robot-N` in the field. They are sent once
/// and follow their frames.
#[must_use]
pub fn scene_robots(unix_us: u64, setting: &Setting) -> SceneUpdate {
    let entities = setting.robots.iter().map(|robot| body(unix_us, setting.source, robot)).collect();
    SceneUpdate { deletions: Vec::new(), entities }
}

fn body(unix_us: u64, source: Source, robot: &RobotSetting) -> SceneEntity {
    let frame_id = match source {
        Source::Simulation => body_frame(robot.id),
        Source::Field => robot_frame(robot.id),
    };
    let paint = paint(robot.id);
    let mut drawn = entity(unix_us, frame_id, &robot_frame(robot.id));
    if robot.footprint_m.is_empty() {
        drawn.cylinders.push(cylinder([0.0, 0.0], robot.radius_m, BODY_M, paint));
    } else {
        drawn.triangles.extend(walls(&robot.footprint_m, true, BODY_M, paint));
        drawn.triangles.extend(lid(&robot.footprint_m, BODY_M, paint));
    }
    drawn.arrows.push(ArrowPrimitive {
        pose: Some(pose([0.0, 0.0], BODY_M + GROUND_M, 0.0)),
        shaft_length: 0.6 * robot.radius_m,
        shaft_diameter: 0.2 * robot.radius_m,
        head_length: 0.6 * robot.radius_m,
        head_diameter: 0.5 * robot.radius_m,
        color: Some(color(TEXT)),
    });
    drawn.texts.push(TextPrimitive {
        pose: Some(pose([0.0, 0.0], 2.0 * BODY_M, 0.0)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(color(TEXT)),
        text: robot.id.to_string(),
    });
    drawn
}

/// Who hears whom (thick where the law relies on it) and where everybody is heading for. It fades within a second.
#[must_use]
pub fn scene_links(unix_us: u64, setting: &Setting, moment: &Moment) -> SceneUpdate {
    let lifetime = Some(Duration::new(LIFETIME_S, 0));
    let at_m: BTreeMap<u32, [f64; 2]> = moment
        .robots
        .iter()
        .filter_map(|robot| robot.place().map(|place| (robot.id, [place.x_m, place.y_m])))
        .collect();
    let (mut kept, mut heard) = (Vec::new(), Vec::new());
    for ((one, other), relied_on) in pairs(moment) {
        if let Some((one_m, other_m)) = at_m.get(&one).zip(at_m.get(&other)) {
            let list = if relied_on { &mut kept } else { &mut heard };
            list.extend([point(*one_m, BODY_M), point(*other_m, BODY_M)]);
        }
    }
    let thin = line(Line::LineList, heard, 1.0, HEARD);
    let lines = thin.into_iter().chain(line(Line::LineList, kept, 3.0, KEPT)).collect();
    let links = SceneEntity { lifetime, lines, ..entity(unix_us, WORLD.into(), "links") };

    let known = |id: u32| setting.robots.iter().any(|robot| robot.id == id);
    let going = moment.robots.iter().filter(|robot| known(robot.id));
    let spheres = going.filter_map(|robot| robot.target_w.map(|target_w| sphere(target_w, paint(robot.id)))).collect();
    let targets = SceneEntity { lifetime, spheres, ..entity(unix_us, WORLD.into(), "targets") };
    SceneUpdate { deletions: Vec::new(), entities: vec![links, targets] }
}

/// Every two robots of which one hears the other, once; and whether either relies on it.
fn pairs(moment: &Moment) -> BTreeMap<(u32, u32), bool> {
    let mut pairs = BTreeMap::new();
    for robot in &moment.robots {
        for heard in &robot.heard {
            let ends = (robot.id.min(heard.id), robot.id.max(heard.id));
            *pairs.entry(ends).or_insert(false) |= heard.kept;
        }
    }
    pairs
}

/// Nothing yet, for ever. It is locked to its frame: then it needs no transform from the time at which it was made.
fn entity(unix_us: u64, frame_id: String, id: &str) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(unix_us)),
        frame_id,
        id: id.into(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// A colour for a robot: neighbouring ids are far apart on the colour wheel, whose steps are the golden ratio's.
fn paint(id: u32) -> Color {
    let hue = (f64::from(id) * 0.618_033_988_749_895).fract() * 6.0;
    let part = |offset: f64| 0.3 + 0.6 * (((hue + offset) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    color([part(0.0), part(4.0), part(2.0), 1.0])
}

fn points(outline_m: &[[f64; 2]], z: f64) -> Vec<Point3> {
    outline_m.iter().map(|corner| point(*corner, z)).collect()
}

/// A line `pixels` wide; `None` if there is nothing to join.
fn line(kind: Line, points: Vec<Point3>, pixels: f64, paint: [f64; 4]) -> Option<LinePrimitive> {
    (points.len() >= 2).then(|| LinePrimitive {
        r#type: kind as i32,
        pose: Some(pose([0.0, 0.0], 0.0, 0.0)),
        thickness: pixels,
        scale_invariant: true,
        points,
        color: Some(color(paint)),
        ..LinePrimitive::default()
    })
}

fn cylinder(at_m: [f64; 2], radius_m: f64, height_m: f64, color: Color) -> CylinderPrimitive {
    CylinderPrimitive {
        pose: Some(pose(at_m, height_m / 2.0, 0.0)),
        size: Some(Vector3 { x: 2.0 * radius_m, y: 2.0 * radius_m, z: height_m }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    }
}

fn sphere(at_m: [f64; 2], color: Color) -> SpherePrimitive {
    let size = Some(Vector3 { x: TARGET_M, y: TARGET_M, z: TARGET_M });
    SpherePrimitive { pose: Some(pose(at_m, TARGET_M / 2.0, 0.0)), size, color: Some(color) }
}

/// Upright walls along a chain of points: two triangles each.
fn walls(chain_m: &[[f64; 2]], closed: bool, height_m: f64, color: Color) -> Option<TriangleListPrimitive> {
    let count = u32::try_from(chain_m.len()).ok().filter(|count| *count >= 2)?;
    let points = chain_m.iter().flat_map(|corner| [point(*corner, 0.0), point(*corner, height_m)]).collect();
    let walls = if closed { count } else { count - 1 };
    let indices = (0..walls).flat_map(|wall| {
        let (from, to) = (2 * wall, 2 * ((wall + 1) % count));
        [from, to, to + 1, from, to + 1, from + 1]
    });
    Some(triangles(points, indices.collect(), color))
}

/// The top of a body: a fan, as its outline is convex.
fn lid(outline_m: &[[f64; 2]], height_m: f64, color: Color) -> Option<TriangleListPrimitive> {
    let count = u32::try_from(outline_m.len()).ok().filter(|count| *count >= 3)?;
    let indices = (1..count - 1).flat_map(|corner| [0, corner, corner + 1]).collect();
    Some(triangles(points(outline_m, height_m), indices, color))
}

fn triangles(points: Vec<Point3>, indices: Vec<u32>, color: Color) -> TriangleListPrimitive {
    TriangleListPrimitive {
        pose: Some(pose([0.0, 0.0], 0.0, 0.0)),
        points,
        color: Some(color),
        colors: Vec::new(),
        indices,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GoalSetting, Heard, MoverSetting, Place, RobotMoment};

    fn setting() -> Setting {
        let square = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let round = RobotSetting { id: 1, radius_m: 0.2, ..RobotSetting::default() };
        let cornered = RobotSetting { id: 2, footprint_m: square.clone(), ..round.clone() };
        Setting {
            robots: vec![round, cornered],
            place: PlaceSetting {
                enclosure_m: square.clone(),
                polygons_m: vec![square],
                circles_m: vec![[1.0, 2.0, 0.5]],
                polylines_m: vec![vec![[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]]],
                movers: vec![MoverSetting { radius_m: 0.4, round_m: vec![[1.0, 1.0], [3.0, 1.0]] }],
                ..PlaceSetting::default()
            },
            route_m: vec![[0.0, 0.0], [1.0, 0.0]],
            goal: Some(GoalSetting { at_m: [3.0, 3.0], within_m: 0.5 }),
            ..Setting::default()
        }
    }

    #[test]
    fn the_place_is_drawn_once_and_stays() {
        let update = scene_place(5, &setting());
        let names: Vec<&str> = update.entities.iter().map(|entity| entity.id.as_str()).collect();
        assert_eq!(names, ["place", "route", "goal", "mover-1"]);
        assert!(update.entities.iter().all(|entity| entity.lifetime.is_none() && entity.frame_locked));
        let frames: Vec<&str> = update.entities.iter().map(|entity| entity.frame_id.as_str()).collect();
        assert_eq!(frames, ["world", "world", "world", "mover-1"]);
        let place = &update.entities[0];
        assert_eq!((place.lines.len(), place.triangles.len(), place.cylinders.len()), (4, 3, 1));
        assert_eq!(place.triangles[0].indices.len(), 4 * 6);
        assert_eq!(place.triangles[2].indices.len(), 2 * 6);
        let size = place.cylinders[0].size.expect("a size");
        assert!((size.x - 1.0).abs() < 1e-12);
    }

    #[test]
    fn every_index_names_a_point() {
        let setting = setting();
        let entities = [scene_place(0, &setting), scene_robots(0, &setting)].map(|update| update.entities).concat();
        let mut triangles = entities.iter().flat_map(|entity| &entity.triangles);
        assert!(triangles.all(|list| list.indices.iter().all(|index| (*index as usize) < list.points.len())));
    }

    #[test]
    fn a_robot_follows_the_frame_that_is_true_where_it_runs() {
        let mut setting = setting();
        let simulated = scene_robots(0, &setting).entities;
        assert_eq!((simulated[0].frame_id.as_str(), simulated[1].frame_id.as_str()), ("body-1", "body-2"));
        assert!(simulated.iter().all(|robot| robot.frame_locked && robot.lifetime.is_none()));
        assert_eq!((simulated[0].cylinders.len(), simulated[1].triangles.len()), (1, 2));
        assert_eq!(simulated[1].texts[0].text, "2");
        setting.source = Source::Field;
        assert_eq!(scene_robots(0, &setting).entities[0].frame_id, "robot-1");
    }

    #[test]
    fn a_link_is_drawn_once_and_thick_if_either_end_relies_on_it() {
        let hears = |id: u32, whom: &[(u32, bool)]| RobotMoment {
            id,
            believed: Some(Place { x_m: f64::from(id), ..Place::default() }),
            target_w: (id == 1).then_some([5.0, 5.0]),
            heard: whom.iter().map(|(id, kept)| Heard { id: *id, age_ms: 0, kept: *kept }).collect(),
            ..RobotMoment::default()
        };
        let robots = vec![hears(1, &[(2, false), (3, false)]), hears(2, &[(1, true), (9, true)]), hears(3, &[])];
        let update = scene_links(0, &setting(), &Moment { robots, ..Moment::default() });
        let (links, targets) = (&update.entities[0], &update.entities[1]);
        let drawn: Vec<(f64, f64)> = links.lines.iter().map(|line| (line.thickness, line.points[1].x)).collect();
        assert_eq!(drawn, [(1.0, 3.0), (3.0, 2.0)]);
        assert_eq!(links.lines[1].points.len(), 2, "robot 9 is nowhere, so nothing leads there");
        assert_eq!(targets.spheres.len(), 1);
        assert!(links.lifetime.is_some() && targets.lifetime.is_some());
    }

    #[test]
    fn colours_are_colours_and_differ() {
        let paints: Vec<Color> = (1..=8).map(paint).collect();
        assert!(paints.iter().all(|paint| [paint.r, paint.g, paint.b].iter().all(|part| (0.0..=1.0).contains(part))));
        assert!((1..8).all(|index| paints[index] != paints[index - 1]));
    }
}
