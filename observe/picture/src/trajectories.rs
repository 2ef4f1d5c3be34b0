//! Where the robots went.

use crate::axis::{Axis, extent};
use crate::colour::{self, FAINT, INK, PAPER, Shape};
use crate::measures::ROBOTS_APART;
use crate::paper::{self, Drawn, FINE, Fine, Label, MARGIN, Sheet, disc, fine, line, marker, pen, polygon};
use crate::plot::{Axes, BELOW, BESIDE, Frame, Key, Plane, TEXT, TICK_TEXT, dashed, pieces};
use crate::{Figure, HEIGHT, PictureError, Run, WIDTH, words};
use drover_record::{MapSetting, MoverSetting, Place, PlaceIndex, PlaceSetting, RobotSetting};
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::{Color, RGBColor};

const WALL: RGBColor = RGBColor(96, 96, 96);
const SOLID: RGBColor = RGBColor(190, 190, 190);
const OUTSIDE: RGBColor = RGBColor(236, 236, 236);
const ROUTE: RGBColor = RGBColor(125, 125, 125);
const GOAL: RGBColor = RGBColor(70, 140, 70);
/// Room for the legend at the right, pixels.
const LEGEND: i32 = 210;
/// Colours along a way that is coloured by time.
const SHADES: usize = 48;

/// Where one robot was, moment by moment.
struct Way<'a> {
    setting: &'a RobotSetting,
    /// NaN where nobody knows.
    places: Vec<Place>,
}

impl Way<'_> {
    fn known(&self) -> impl DoubleEndedIterator<Item = &Place> {
        self.places.iter().filter(|place| is_known(place))
    }
}

fn is_known(place: &Place) -> bool {
    place.x_m.is_finite() && place.y_m.is_finite()
}

pub(crate) fn figure(run: &Run) -> Result<Figure, PictureError> {
    let title = "Where the robots went";
    let caption = "The place seen from above, with equal scales: walls and obstacles grey, the leader's way dashed, \
                   the goal green. A robot's way begins at the open marker; its body is drawn where it was last seen, \
                   with a line to its front (a small body larger than it is). By the simulator's truth, in the field \
                   where each believed to be. The ways of more than 12 robots are coloured by time.";
    Ok(Figure { name: "trajectories", title, caption, svg: draw(run, title)? })
}

fn draw(run: &Run, title: &str) -> Result<String, PictureError> {
    let conditions = words::conditions(run);
    let ways: Vec<Way> = run.setting.robots.iter().enumerate().map(|(at, robot)| way(run, at, robot)).collect();
    if !ways.iter().any(|way| way.known().next().is_some()) {
        let why = if run.moments.is_empty() { "the recording holds no moment" } else { "no robot's place is known" };
        return paper::nothing(title, &conditions, why);
    }
    let [x, y] = bounds(run, &ways);
    let subtitle = match run.setting.place.name.as_str() {
        "" => conditions,
        place => format!("{conditions}  ·  {place}"),
    };
    paper::svg(title, |sheet| {
        let top = paper::head(sheet, title, &subtitle)? + 12;
        let frame = frame(top, (x[1] - x[0]) / (y[1] - y[0]));
        let (count_x, count_y) = ((frame[2] - frame[0]) / 90, (frame[3] - frame[1]) / 55);
        let axes = |grid| Axes {
            x: Axis::tight(x, count_x.max(1) as usize),
            y: Axis::tight(y, count_y.max(1) as usize),
            x_label: "east (m)",
            y_label: "north (m)",
            grid,
        };
        let plane = Plane::draw(sheet, frame, axes(false))?;
        world(sheet, &plane, &run.setting.place)?;
        movers(sheet, &plane, run)?;
        aims(sheet, &plane, run)?;
        robots(sheet, &plane, &ways)?;
        legend(sheet, frame, run, top)
    })
}

fn way<'a>(run: &Run, at: usize, robot: &'a RobotSetting) -> Way<'a> {
    let nowhere = Place { x_m: f64::NAN, y_m: f64::NAN, yaw_rad: f64::NAN };
    let place = |seen: &drover_record::RobotMoment| seen.place();
    let places = run.moments.iter().map(|moment| {
        // They stand in the setting's order; only a recording from elsewhere is searched.
        let expected = moment.robots.get(at).filter(|seen| seen.id == robot.id);
        let seen = expected.or_else(|| moment.robots.iter().find(|seen| seen.id == robot.id));
        seen.and_then(place).unwrap_or(nowhere)
    });
    Way { setting: robot, places: places.collect() }
}

/// From where to where x and y go: everything, and a little around it.
fn bounds(run: &Run, ways: &[Way]) -> [[f64; 2]; 2] {
    let mut points: Vec<[f64; 2]> = run.setting.route_m.clone();
    for way in ways {
        let r = way.setting.radius_m;
        points.extend(way.known().flat_map(|place| [[place.x_m - r, place.y_m - r], [place.x_m + r, place.y_m + r]]));
    }
    if let Some(goal) = run.setting.goal {
        let ([x, y], r) = (goal.at_m, goal.within_m);
        points.extend([[x - r, y - r], [x + r, y + r]]);
    }
    points.extend(run.setting.place.movers.iter().flat_map(|mover| &mover.round_m));
    if let Some([west, south, east, north]) = PlaceIndex::new(&run.setting.place).bounds_m() {
        points.extend([[west, south], [east, north]]);
    }
    let range = |axis: usize| extent(points.iter().map(|point| point[axis])).unwrap_or([0.0, 1.0]);
    let (x, y) = (range(0), range(1));
    // A place with hardly any width would have no paper to be drawn on.
    let size = (x[1] - x[0]).max(y[1] - y[0]).max(1.0);
    let wide = |[from, to]: [f64; 2]| {
        let more = (size * 0.15 - (to - from)).max(0.0) / 2.0 + size * 0.02;
        [from - more, to + more]
    };
    [wide(x), wide(y)]
}

/// The largest frame of this ratio of width to height, in the middle of the room beside the legend.
fn frame(top: i32, ratio: f64) -> Frame {
    let (left, right) = (BESIDE + 12, WIDTH as i32 - MARGIN - LEGEND);
    let bottom = HEIGHT as i32 - 12 - BELOW;
    let (width, height) = (f64::from(right - left), f64::from(bottom - top));
    let (wide, high) = if width / height > ratio { (height * ratio, height) } else { (width, width / ratio) };
    let left = left + ((width - wide) / 2.0) as i32;
    [left, top, left + wide.round() as i32, top + high.round() as i32]
}

fn closed(plane: &Plane, outline: &[[f64; 2]]) -> Vec<Fine> {
    outline.iter().chain(outline.first()).map(|point| plane.at(*point)).collect()
}

fn finite(points: &[[f64; 2]]) -> bool {
    points.len() > 1 && points.iter().flatten().all(|value| value.is_finite())
}

fn world(sheet: &Sheet, plane: &Plane, place: &PlaceSetting) -> Drawn {
    if finite(&place.enclosure_m) {
        let [left, top, right, bottom] = plane.frame();
        let all = [(left, top), (right, top), (right, bottom), (left, bottom)].map(|(x, y)| fine(x, y));
        polygon(sheet, all.to_vec(), OUTSIDE.filled())?;
        let within = closed(plane, &place.enclosure_m);
        polygon(sheet, within.clone(), PAPER.filled())?;
        line(sheet, within, pen(WALL, 3.0))?;
        line(sheet, [all.as_slice(), &all[..1]].concat(), pen(INK, 1.0))?;
    }
    if let Some(map) = &place.map {
        for outline in blocks(map) {
            let outline = closed(plane, &outline);
            polygon(sheet, outline.clone(), SOLID.filled())?;
            // A thin edge of the same colour closes the seams between neighbours.
            line(sheet, outline, pen(SOLID, 1.0))?;
        }
    }
    for outline in place.polygons_m.iter().filter(|outline| finite(outline)) {
        polygon(sheet, closed(plane, outline), SOLID.filled())?;
        line(sheet, closed(plane, outline), pen(WALL, 1.5))?;
    }
    for [x, y, r] in place.circles_m.iter().copied().filter(|circle| circle.iter().all(|value| value.is_finite())) {
        let (at, radius) = (plane.at([x, y]), radius(plane, [x, y], r));
        disc(sheet, at, radius, SOLID.filled())?;
        disc(sheet, at, radius, pen(WALL, 1.5))?;
    }
    let mut chains = place.polylines_m.iter().filter(|points| finite(points));
    chains.try_for_each(|points| line(sheet, points.iter().map(|point| plane.at(*point)).collect(), pen(WALL, 2.5)))
}

/// What moves, and its way: where it was last seen, as robots are; where it starts if nobody told.
fn movers(sheet: &Sheet, plane: &Plane, run: &Run) -> Drawn {
    let told_m = run.moments.last().map(|moment| moment.movers_m.as_slice()).unwrap_or_default();
    for (number, mover) in run.setting.place.movers.iter().enumerate() {
        let MoverSetting { radius_m, round_m } = mover;
        let Some(at_m) = told_m.get(number).or(round_m.first()) else { continue };
        if !finite(round_m) || !at_m.iter().chain([radius_m]).all(|value| value.is_finite()) {
            continue;
        }
        dashed(sheet, &closed(plane, round_m), WALL)?;
        disc(sheet, plane.at(*at_m), radius(plane, *at_m, *radius_m), pen(WALL, 1.5))?;
    }
    Ok(())
}

fn radius(plane: &Plane, [x, y]: [f64; 2], r: f64) -> i32 {
    (plane.at([x + r, y]).0 - plane.at([x, y]).0).abs()
}

/// Solid cells of a map as rectangles: as wide as they go, and equal ones above each other in one.
fn blocks(map: &MapSetting) -> Vec<[[f64; 2]; 4]> {
    let (sin, cos) = map.origin_yaw_rad.sin_cos();
    let corner = |x: usize, y: usize| {
        let (x, y) = (x as f64 * map.resolution_m, y as f64 * map.resolution_m);
        [map.origin_m[0] + x * cos - y * sin, map.origin_m[1] + x * sin + y * cos]
    };
    let block = |[from, to, south, north]: [usize; 4]| {
        [corner(from, south), corner(to, south), corner(to, north), corner(from, north)]
    };
    let solid = map.solid();
    let mut done = Vec::new();
    let mut open: Vec<[usize; 4]> = Vec::new();
    for (y, row) in solid.chunks(map.width.max(1)).enumerate() {
        let mut here: Vec<[usize; 4]> = Vec::new();
        let mut x = 0;
        for run in row.chunk_by(|one, other| one == other) {
            if run[0] {
                let below = open.iter().position(|[from, to, ..]| (*from, *to) == (x, x + run.len()));
                let south = below.map_or(y, |at| open.swap_remove(at)[2]);
                here.push([x, x + run.len(), south, y + 1]);
            }
            x += run.len();
        }
        done.append(&mut open);
        open = here;
    }
    done.append(&mut open);
    done.into_iter().map(block).filter(|outline| finite(outline)).collect()
}

/// The leader's way and the goal.
fn aims(sheet: &Sheet, plane: &Plane, run: &Run) -> Drawn {
    if let Some(goal) = run.setting.goal.filter(|goal| finite(&[goal.at_m, [goal.within_m, 0.0]])) {
        let (at, radius) = (plane.at(goal.at_m), radius(plane, goal.at_m, goal.within_m).max(5 * FINE));
        disc(sheet, at, radius, GOAL.mix(0.18).filled())?;
        disc(sheet, at, radius, pen(GOAL, 1.5))?;
        cross(sheet, at)?;
    }
    let route: Vec<Fine> = if finite(&run.setting.route_m) {
        run.setting.route_m.iter().map(|point| plane.at(*point)).collect()
    } else {
        Vec::new()
    };
    if !route.is_empty() {
        dashed(sheet, &route, ROUTE)?;
    }
    route.into_iter().try_for_each(|at| disc(sheet, at, 3 * FINE, ROUTE.filled()))
}

fn cross(sheet: &Sheet, (x, y): Fine) -> Drawn {
    let arm = 6 * FINE;
    line(sheet, vec![(x - arm, y), (x + arm, y)], pen(GOAL, 2.0))?;
    line(sheet, vec![(x, y - arm), (x, y + arm)], pen(GOAL, 2.0))
}

fn robots(sheet: &Sheet, plane: &Plane, ways: &[Way]) -> Drawn {
    let by_time = ways.len() > ROBOTS_APART;
    for (at, way) in ways.iter().enumerate() {
        if by_time { shaded(sheet, plane, way)? } else { plain(sheet, plane, way, colour::look(at).0)? }
    }
    // Ends above all ways: where somebody is matters more than where somebody else went.
    for (at, way) in ways.iter().enumerate() {
        let look = if by_time { (FAINT, Shape::Circle) } else { colour::look(at) };
        if let Some(first) = way.known().next() {
            marker(sheet, plane.at([first.x_m, first.y_m]), look, if by_time { 3.0 } else { 6.0 }, true)?;
        }
    }
    for (at, way) in ways.iter().enumerate() {
        let colour = if by_time { shade(1.0) } else { colour::look(at).0 };
        if let Some(last) = way.known().next_back() {
            body(sheet, plane, (way.setting, last), colour)?;
        }
    }
    Ok(())
}

fn plain(sheet: &Sheet, plane: &Plane, way: &Way, colour: RGBColor) -> Drawn {
    for piece in pieces(&way.places, is_known) {
        line(sheet, spaced(plane, piece), pen(colour, 2.0))?;
    }
    Ok(())
}

/// A way whose colour tells the time.
fn shaded(sheet: &Sheet, plane: &Plane, way: &Way) -> Drawn {
    let moments = way.places.len();
    let together = moments.div_ceil(SHADES).max(1);
    for from in (0..moments).step_by(together) {
        // One more than a shade's share, so that the shades join.
        let chunk = &way.places[from..(from + together + 1).min(moments)];
        let colour = shade((from + together / 2) as f64 / moments.max(1) as f64);
        for piece in pieces(chunk, is_known) {
            line(sheet, spaced(plane, piece), pen(colour, 1.5))?;
        }
    }
    Ok(())
}

fn shade(share: f64) -> RGBColor {
    // The last tenth of the map is a yellow that is lost on white paper.
    ViridisRGB.get_color_normalized(share * 0.9, 0.0, 1.0)
}

/// Points on the paper without those that would fall on the one before.
fn spaced(plane: &Plane, places: &[Place]) -> Vec<Fine> {
    let mut points: Vec<Fine> = Vec::new();
    for (at, place) in places.iter().enumerate() {
        let point = plane.at([place.x_m, place.y_m]);
        let near = points.last().is_some_and(|last| (last.0 - point.0).abs() + (last.1 - point.1).abs() < 2 * FINE);
        if !near || at + 1 == places.len() {
            points.push(point);
        }
    }
    points
}

fn body(sheet: &Sheet, plane: &Plane, (robot, last): (&RobotSetting, &Place), colour: RGBColor) -> Drawn {
    let at = plane.at([last.x_m, last.y_m]);
    let scale = f64::from(radius(plane, [last.x_m, last.y_m], 1.0));
    let (least, most) = (f64::from(7 * FINE), f64::from(WIDTH) * f64::from(FINE));
    // `max` and `min` also take care of a radius that is not a number.
    let true_radius = (robot.radius_m * scale).max(0.0).min(most);
    let yaw = if last.yaw_rad.is_finite() { last.yaw_rad } else { 0.0 };
    let turned = |[x, y]: [f64; 2], by: f64| {
        let (sin, cos) = yaw.sin_cos();
        let (east, north) = ((x * cos - y * sin) * by, (x * sin + y * cos) * by);
        (at.0 + east.clamp(-most, most).round() as i32, at.1 - north.clamp(-most, most).round() as i32)
    };
    let radius = true_radius.max(least);
    if finite(&robot.footprint_m) && robot.footprint_m.len() > 2 && true_radius >= least {
        let corners = robot.footprint_m.iter().chain(robot.footprint_m.first());
        let outline: Vec<Fine> = corners.map(|corner| turned(*corner, scale)).collect();
        polygon(sheet, outline.clone(), colour.filled())?;
        line(sheet, outline, pen(INK, 1.5))?;
    } else {
        disc(sheet, at, radius as i32, colour.filled())?;
        disc(sheet, at, radius as i32, pen(INK, 1.5))?;
    }
    if last.yaw_rad.is_finite() {
        let nose = vec![at, turned([1.0, 0.0], radius * 1.5)];
        line(sheet, nose.clone(), pen(PAPER, 4.5))?;
        line(sheet, nose, pen(INK, 2.5))?;
    }
    Ok(())
}

fn legend(sheet: &Sheet, frame: Frame, run: &Run, top: i32) -> Drawn {
    let x = frame[2] + 24;
    let mut y = top + 10;
    let mut entry = |words: &str, key: &dyn Fn((i32, i32)) -> Drawn| {
        key((x, y))?;
        let words = paper::fitted(words, TEXT, LEGEND - 40);
        Label { colour: FAINT, ..Label::new(&words, fine(x + 38, y), TEXT) }.draw(sheet)?;
        y += 27;
        Ok::<(), PictureError>(())
    };
    let by_time = run.setting.robots.len() > ROBOTS_APART;
    if !by_time {
        for (at, robot) in run.setting.robots.iter().enumerate() {
            let (colour, shape) = colour::look(at);
            entry(&format!("robot {}", robot.id), &|at| {
                line(sheet, vec![fine(at.0, at.1), fine(at.0 + 28, at.1)], pen(colour, 2.5))?;
                marker(sheet, fine(at.0 + 14, at.1), (colour, shape), 6.0, true)
            })?;
        }
    }
    entry("start", &|at| marker(sheet, fine(at.0 + 14, at.1), (FAINT, Shape::Circle), 6.0, true))?;
    entry("end", &|at| {
        disc(sheet, fine(at.0 + 10, at.1), 7 * FINE, FAINT.filled())?;
        line(sheet, vec![fine(at.0 + 10, at.1), fine(at.0 + 22, at.1)], pen(INK, 2.5))
    })?;
    if !run.setting.route_m.is_empty() {
        entry("leader's way", &|at| dashed(sheet, &[fine(at.0, at.1), fine(at.0 + 28, at.1)], ROUTE))?;
    }
    if run.setting.goal.is_some() {
        entry("goal", &|at| {
            disc(sheet, fine(at.0 + 14, at.1), 9 * FINE, GOAL.mix(0.18).filled())?;
            disc(sheet, fine(at.0 + 14, at.1), 9 * FINE, pen(GOAL, 1.5))
        })?;
    }
    if run.setting.place != PlaceSetting::default() {
        entry("wall, obstacle", &|at| Key::Patch(SOLID).draw(sheet, at))?;
    }
    if by_time { time_bar(sheet, run, (x, y + 12)) } else { Ok(()) }
}

/// Which colour is which time.
fn time_bar(sheet: &Sheet, run: &Run, (x, y): (i32, i32)) -> Drawn {
    const STEPS: i32 = 60;
    let times = extent(run.moments.iter().map(|moment| moment.time_s)).unwrap_or([0.0, 0.0]);
    Label { colour: FAINT, ..Label::new("time (s)", fine(x, y), TEXT) }.draw(sheet)?;
    let top = y + 24;
    for step in 0..STEPS {
        let (from, to) = (top + step * 4, top + step * 4 + 5);
        let corners = [(x, from), (x + 28, from), (x + 28, to), (x, to)].map(|(x, y)| fine(x, y));
        polygon(sheet, corners.to_vec(), shade(f64::from(step) / f64::from(STEPS)).filled())?;
    }
    for (share, at) in [(0.0, top), (0.5, top + STEPS * 2), (1.0, top + STEPS * 4)] {
        let words = format!("{:.0}", times[0] + share * (times[1] - times[0]));
        Label { colour: FAINT, ..Label::new(&words, fine(x + 38, at), TICK_TEXT) }.draw(sheet)?;
    }
    Ok(())
}
