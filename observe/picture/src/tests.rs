use super::*;
use drover_record::{
    CLEAR, GoalSetting, Heard, MapSetting, MoverSetting, Place, PlaceSetting, RobotMoment, RobotSetting, ScanMoment,
    Truth,
};
use serde_json::json;

const EVIL: &str = "<script>alert('1 & \"2\"')</script>\u{1}";

fn room() -> PlaceSetting {
    PlaceSetting {
        name: "room".to_owned(),
        enclosure_m: vec![[0.0, 0.0], [12.0, 0.0], [12.0, 8.0], [0.0, 8.0]],
        polygons_m: vec![vec![[5.0, 3.0], [6.0, 3.0], [6.0, 4.0], [5.0, 4.0]]],
        circles_m: vec![[8.0, 2.0, 0.5]],
        polylines_m: vec![vec![[3.0, 8.0], [3.0, 6.5]]],
        movers: vec![MoverSetting { radius_m: 0.4, round_m: vec![[2.0, 2.0], [5.0, 3.0], [6.0, 2.0]] }],
        map: Some(MapSetting {
            resolution_m: 0.5,
            origin_m: [9.0, 5.0],
            origin_yaw_rad: 0.2,
            width: 3,
            height: 2,
            runs: vec![1, 2, 1, 2],
        }),
    }
}

fn robot(id: u32, time_s: f64, others: u32) -> RobotMoment {
    let place = Place { x_m: 1.0 + 0.3 * time_s, y_m: 0.5 + 0.9 * f64::from(id), yaw_rad: 0.1 };
    let heard = (1..=others).filter(|peer| *peer != id).map(|id| Heard { id, age_ms: 40, kept: false }).collect();
    let scan = ScanMoment {
        time_s,
        angle_step_rad: 0.5,
        range_m_max: 4.0,
        ranges_m: vec![Some(CLEAR), Some(2.0), None],
        ..ScanMoment::default()
    };
    let truth = Truth { place, twist_b: [0.3, 0.0], in_contact: false };
    RobotMoment { id, truth: Some(truth), heard, scan: Some(scan), ..RobotMoment::default() }
}

fn run(robots: u32) -> Run {
    let setting = |id| RobotSetting { id, kind: "rover".to_owned(), radius_m: 0.2, peer_ms: 500, ..Default::default() };
    let moment = |tick: u32| {
        let time_s = f64::from(tick) * 0.1;
        let robots = (1..=robots).map(|id| robot(id, time_s, robots)).collect();
        Moment { time_s, robots, movers_m: vec![[2.0 + 0.1 * time_s, 2.0]], ..Moment::default() }
    };
    Run {
        setting: Setting {
            swarm: "first".to_owned(),
            behaviour: "flock".to_owned(),
            seed: 7,
            robots: (1..=robots).map(setting).collect(),
            place: room(),
            route_m: vec![[1.0, 1.0], [10.0, 4.0]],
            goal: Some(GoalSetting { at_m: [10.0, 4.0], within_m: 1.0 }),
            ..Setting::default()
        },
        moments: (0..100).map(moment).collect(),
        interventions: (0..30)
            .map(|tick| Intervention {
                time_s: f64::from(tick) * 0.3,
                robot: 1 + tick % 3,
                reason: format!("r{}", tick % 9),
            })
            .collect(),
        summary: Some(json!({
            "swarm": "first", "min_gap_robot_m": 0.25, "reached": true, "recording": null,
            "robots": [{"id": 1, "path_m": 3.0, "commands_changed": {"wall": 2}, "report": null}],
        })),
        title: "first run".to_owned(),
    }
}

fn well_formed(svg: &str) {
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{error}: {svg:.300}"));
    assert_eq!(document.root_element().tag_name().name(), "svg");
}

/// How many pixels of a PNG of the right size are not white.
fn inked(png: &[u8]) -> usize {
    let picture = image::load_from_memory(png).expect("a PNG").to_rgb8();
    assert_eq!(picture.dimensions(), (WIDTH, HEIGHT));
    picture.pixels().filter(|pixel| pixel.0 != [255; 3]).count()
}

fn all_well(run: &Run) -> Vec<Picture> {
    let pictures = pictures(run).expect("pictures");
    let names: Vec<&str> = pictures.iter().map(|picture| picture.name).collect();
    let expected = ["trajectories", "gaps", "connectivity", "coverage", "order", "speeds", "interventions"];
    assert_eq!(names, expected);
    for picture in &pictures {
        well_formed(&picture.svg);
        assert!(inked(&picture.png) > 1000, "{} is blank", picture.name);
    }
    let page = report(run).expect("a report");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    assert_eq!(page.matches("<figure").count(), page.matches("</figure>").count());
    assert_eq!(page.matches("<svg").count(), 7);
    pictures
}

fn without_data(pictures: &[Picture]) -> Vec<&str> {
    pictures.iter().filter(|picture| picture.svg.contains("no data")).map(|picture| picture.name).collect()
}

#[test]
fn every_picture_of_a_run_is_well_formed_and_shows_something() {
    for robots in [2, 5, 12, 13, 40] {
        let pictures = all_well(&run(robots));
        assert!(without_data(&pictures).is_empty(), "{robots} robots: {:?}", without_data(&pictures));
        assert_eq!(pictures[0].svg.contains("robot 2"), robots <= 12, "a legend for {robots} robots");
    }
}

#[test]
fn pictures_say_what_they_show_and_of_which_run() {
    for picture in pictures(&run(3)).expect("pictures") {
        assert!(picture.svg.contains(&picture.title), "{}", picture.name);
        for words in ["swarm first", "seed 7", "simulation", "(s)", "(m)"] {
            let unit_of_another = words.starts_with('(') && (words == "(m)") != (picture.name == "trajectories");
            assert!(unit_of_another || picture.svg.contains(words), "{} lacks {words}", picture.name);
        }
    }
}

#[test]
fn runs_without_anything_to_see_are_pictures_that_say_so() {
    let nothing = all_well(&Run::default());
    assert_eq!(without_data(&nothing).len(), 7);
    let mut still = run(2);
    still.moments.clear();
    assert_eq!(without_data(&all_well(&still)).len(), 6, "all but the interventions");
    let mut field = run(2);
    field.setting.place = PlaceSetting::default();
    field.interventions.clear();
    assert_eq!(without_data(&all_well(&field)), ["coverage", "interventions"]);
    let mut blind = run(2);
    blind.moments.iter_mut().flat_map(|moment| &mut moment.robots).for_each(|robot| robot.truth = None);
    assert!(without_data(&all_well(&blind)).contains(&"trajectories"));
}

#[test]
fn a_lone_robot_and_a_single_moment_are_enough() {
    let alone = run(1);
    assert_eq!(without_data(&all_well(&alone)), ["connectivity"]);
    let mut short = run(3);
    short.moments.truncate(1);
    short.interventions.truncate(1);
    assert!(without_data(&all_well(&short)).is_empty());
}

#[test]
fn numbers_without_sense_do_no_harm() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300] {
        let mut odd = run(3);
        odd.setting.place.circles_m.push([value, 0.0, value]);
        odd.setting.place.polylines_m.push(vec![[value, value], [0.0, value]]);
        odd.setting.place.movers.push(MoverSetting { radius_m: value, round_m: vec![[1.0, 1.0], [5.0, value]] });
        odd.setting.place.enclosure_m.push([value, 1.0]);
        odd.setting.robots[1].radius_m = value;
        odd.setting.robots[1].footprint_m = vec![[value, 0.0], [0.1, 0.1], [0.0, value]];
        odd.setting.route_m.push([value, 2.0]);
        odd.setting.goal = Some(GoalSetting { at_m: [2.0, value], within_m: value });
        odd.setting.place.map = odd.setting.place.map.map(|map| MapSetting { resolution_m: value, ..map });
        odd.interventions[3].time_s = value;
        odd.moments.iter_mut().for_each(|moment| moment.movers_m.push([value, value]));
        for moment in odd.moments.iter_mut().skip(40).take(3) {
            moment.time_s = value;
            let truth =
                Truth { place: Place { x_m: value, y_m: 1.0, yaw_rad: value }, twist_b: [value; 2], in_contact: true };
            moment.robots[2].truth = Some(truth);
            moment.robots[1].scan =
                Some(ScanMoment { ranges_m: vec![Some(value)], range_m_max: value, ..Default::default() });
        }
        all_well(&odd);
    }
}

#[test]
fn what_is_drawn_far_away_stays_where_it_can_be_drawn() {
    let mut far = run(2);
    far.moments[50].robots[0].truth =
        Some(Truth { place: Place { x_m: 1e7, y_m: 0.0, yaw_rad: 0.0 }, ..Truth::default() });
    all_well(&far);
}

#[test]
fn words_of_a_run_are_words_and_nothing_else() {
    let mut evil = run(2);
    evil.title = EVIL.to_owned();
    evil.setting.swarm = EVIL.to_owned();
    evil.setting.behaviour = EVIL.to_owned();
    evil.setting.place.name = EVIL.to_owned();
    evil.setting.robots[0].kind = EVIL.to_owned();
    evil.interventions[0].reason = EVIL.to_owned();
    evil.summary = Some(json!({ EVIL: EVIL, "robots": [{ EVIL: EVIL, "id": EVIL, "list": [EVIL, {"a": EVIL}] }] }));
    all_well(&evil);
    let page = report(&evil).expect("a report");
    assert!(!page.contains("<script") && !page.contains('\u{1}') && page.contains("&lt;script&gt;"));
}

#[test]
fn the_page_asks_nobody_for_anything() {
    let page = report(&run(3)).expect("a report");
    let own = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in ["http:", "https:", "src=", "href=", "url(", "@import", "<link", "<script", "<img"] {
        assert!(!own.contains(word), "{word}");
    }
    for word in ["prefers-color-scheme: dark", "@media print", "min gap robot", "0.25 m", "seed", "λ₂", "φ = "] {
        assert!(page.contains(word), "the page lacks {word}");
    }
}

#[test]
fn a_summary_of_another_shape_is_shown_as_it_is() {
    for summary in [json!(null), json!("words"), json!([1, 2]), json!({"a": {"b_m": 1.5}}), json!({"a": [{}, 3]})] {
        all_well(&Run { summary: Some(summary), ..run(2) });
    }
}

#[test]
fn units_come_from_names() {
    assert_eq!(words::quantity("min_gap_robot_m"), ("min gap robot".to_owned(), "m"));
    assert_eq!(words::quantity("gap_m_min"), ("gap min".to_owned(), "m"));
    assert_eq!(words::quantity("accel_mps2_max"), ("accel max".to_owned(), "m/s²"));
    assert_eq!(words::quantity("ticks"), ("ticks".to_owned(), ""));
    assert_eq!(words::quantity("time_s"), ("time".to_owned(), "s"));
}

#[test]
fn charts_take_logarithms_error_bars_and_nothing_at_all() {
    let points: Vec<[f64; 2]> = (0..5).map(|power| [10_f64.powi(power), 3.0 * 2_f64.powi(power)]).collect();
    let series = Series {
        name: "both".to_owned(),
        errors: points.iter().map(|point| [point[1] * 0.9, point[1] * 1.2]).collect(),
        points,
        steps: false,
    };
    for (x_log, y_log) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut chart =
            Chart { title: "A <b>".to_owned(), x_log, y_log, series: vec![series.clone()], ..Chart::default() };
        well_formed(&chart.svg().expect("a chart"));
        assert!(inked(&chart.png().expect("a chart")) > 1000);
        // 0 and below have no logarithm.
        chart.series[0].points.extend([[0.0, -1.0], [f64::NAN, 1.0]]);
        assert!(!chart.svg().expect("a chart").contains("no data"));
        chart.series[0].points = vec![[-1.0, -1.0]];
        assert_eq!(chart.svg().expect("a chart").contains("no data"), x_log || y_log);
        chart.series.clear();
        assert!(chart.svg().expect("a chart").contains("no data"));
    }
}
