//! A run that goes on: what is seen of it, and what is asked of it.

use crate::common::{STANDSTILL, first_toml};
use crate::support::{Browser, Shown, alone, assert_clean, fleet_file, number, numbers};
use serde_json::{Value, json};

const LOOPBACK: &str = "127.0.0.1:0";

/// A phone's width: nothing is wider, and STOP is in sight without scrolling.
fn assert_fits_a_phone(phone: &Value) {
    assert_eq!(phone["width"], 390, "{phone:#}");
    assert_eq!(phone["complaints"], json!([]), "{phone:#}");
    let stop = &phone["stop"];
    let (top, height) = (number(&stop["y"]), number(&stop["height"]));
    assert!(top >= 0.0 && top + height <= 844.0 && height >= 44.0, "{phone:#}");
}

#[test]
fn robots_are_seen_to_drive_with_links_and_trails() {
    let _alone = alone();
    let shown = Shown::up(&first_toml(), LOOPBACK, &[]);
    let found = Browser::open("watch", &shown).found();
    assert_clean(&found, &shown);
    assert_eq!(found["hooks"]["robots"], "5");
    assert_eq!(found["hooks"]["phase"], "running");
    assert_eq!(found["connection"], "connected");
    let ways = numbers(&found["ways"]);
    assert!(ways.len() == 5 && ways.iter().all(|way_m| *way_m > 0.1), "{ways:?}");
    assert!(number(&found["drawn"]) > 200.0, "too little in the colour of driving robots: {found:#}");
    let controls = json!({ "stop": true, "pause": true, "speed": true, "restart": true, "seek": false });
    assert_eq!(found["shown"], controls);
    assert_fits_a_phone(&found["phone"]);
}

#[test]
fn the_stop_button_stops_every_robot_for_good() {
    let _alone = alone();
    let shown = Shown::up(&first_toml(), LOOPBACK, &[]);
    let found = Browser::open("stop", &shown).found();
    assert_clean(&found, &shown);
    assert!(numbers(&found["before"]).iter().any(|speed| *speed > 0.1), "nobody drove before: {found:#}");
    let after = numbers(&found["speeds"]);
    assert!(after.len() >= 20 && after.iter().all(|speed| *speed < STANDSTILL), "not all stand: {after:?}");
    assert_eq!(found["states"], json!(["stopped"]));
    let results = found["results"].as_array().expect("a list");
    assert_eq!(results.len(), 1, "the page changed its mind: {results:?}");
    assert!(results[0].as_str().is_some_and(|text| text.contains("all 5 robots stand")), "{results:?}");
    assert_eq!((&found["stop"]["latched"], &found["stop"]["standing"]), (&json!(5), &json!(5)));

    let (code, printed) = shown.interrupt();
    let summary: Value = serde_json::from_str(&printed).expect("a summary");
    assert_eq!(code, Some(130), "{summary:#}");
    assert_eq!(summary["stopped"], true, "{summary:#}");
    let robots = summary["robots"].as_array().expect("a list");
    assert!(robots.len() == 5 && robots.iter().all(|robot| robot["state"] == "stopped"), "{summary:#}");
}

#[test]
fn time_is_held_goes_on_goes_twice_as_fast_and_begins_anew() {
    let _alone = alone();
    let shown = Shown::up(&first_toml(), LOOPBACK, &[]);
    let found = Browser::open("pace", &shown).found();
    assert_clean(&found, &shown);
    assert_eq!(found["held"], found["held_later"], "time or bodies went on while paused");
    let (rate, fast) = (number(&found["rate"]), number(&found["fast"]));
    assert!((0.7..1.3).contains(&rate), "{rate} s of the run per second after resuming");
    assert!((1.5..2.5).contains(&fast), "{fast} s of the run per second at twice the speed");
    let anew = &found["anew"];
    assert!(number(&anew["time_s"]) < 2.0 && number(&found["time_s"]) > 3.0, "{found:#}");
    assert!(number(&anew["began"]) > number(&anew["before"]), "{anew:#}");
    assert_eq!(shown.interrupt().0, Some(130));
}

#[test]
fn movers_are_drawn_where_they_are_now() {
    let _alone = alone();
    let file = first_toml().with_file_name("flock_scouts_mover.toml");
    let shown = Shown::up(&file, LOOPBACK, &["--no-record"]);
    let found = Browser::open("movers", &shown).found();
    assert_clean(&found, &shown);
    // Each time what was told, [x, y] a mover, and what was drawn then: x, y and radius a mover, as text.
    let [before, after] = [0, 1].map(|look| {
        let [told, drawn] = [0, 1].map(|at| &found["seen"][look][at]);
        let drawn = drawn.as_str().expect("text").split(' ').map(|mover| {
            let numbers: Vec<f64> = mover.split(',').map(|number| number.parse().expect("a number")).collect();
            (numbers[0], numbers[1], numbers[2])
        });
        let drawn: Vec<(f64, f64, f64)> = drawn.collect();
        assert_eq!((told.as_array().map(Vec::len), drawn.len()), (Some(2), 2), "{found:#}");
        for (told, (x_m, y_m, radius_m)) in told.as_array().expect("a list").iter().zip(&drawn) {
            let told = numbers(told);
            // Drawn up to a second late, on a busy machine, at 0.4 m/s.
            assert!((told[0] - x_m).abs() < 1e-3 && (told[1] - y_m).abs() < 0.5, "{found:#}");
            assert!((radius_m - 1.0).abs() < 1e-3, "{found:#}");
        }
        drawn
    });
    let went_m = before.iter().zip(&after).map(|(before, after)| (after.1 - before.1).abs());
    assert!(went_m.into_iter().all(|went_m| went_m > 0.3), "{found:#}");
    // Nothing else in that place is solid.
    assert!(number(&found["solid"]) > 200.0, "{found:#}");
}

#[test]
fn a_hundred_robots_are_drawn_fluently() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let shown = Shown::up(&fleet_file(folder.path(), 100, "pillars.toml"), LOOPBACK, &["--no-record"]);
    let found = Browser::open("fleet", &shown).found();
    assert_clean(&found, &shown);
    assert_eq!(found["hooks"]["robots"], "100");
    assert_eq!(found["hooks"]["trails"], "100");
    // Software rendering: some 60 when the machine is free. Others may take some seconds away, hardly every one.
    let fps = numbers(&found["fps"]);
    assert!(fps.iter().any(|fps| *fps >= 15.0), "frames per second: {fps:?}");
    assert_fits_a_phone(&found["phone"]);
}
