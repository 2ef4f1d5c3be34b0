//! `drover sim` as a user and a script meet it.

use crate::common::{drover, exported, first_toml, json, top};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

fn sim(file: &Path, arguments: &[&str]) -> Output {
    drover().arg("sim").arg(file).args(arguments).output().expect("drover runs")
}

fn first(arguments: &[&str]) -> Output {
    sim(&first_toml(), arguments)
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn runs(result: &Value) -> &Vec<Value> {
    result["runs"].as_array().expect("runs")
}

#[test]
fn a_batch_prints_one_json_document_and_nothing_else_on_stdout() {
    let output = first(&["--seeds", "1..4", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    // Nothing before and nothing behind it, or this does not parse.
    let result = json(&output);
    assert_eq!((result["swarm"].as_str(), result["fidelity"].as_str()), (Some("first"), Some("direct")));
    let seeds: Vec<Option<u64>> = runs(&result).iter().map(|run| run["seed"].as_u64()).collect();
    assert_eq!(seeds, [Some(1), Some(2), Some(3)]);
    for run in runs(&result) {
        let fields = run.as_object().expect("an object");
        assert!(fields.values().all(|value| !value.is_object() && !value.is_array()), "not flat: {run:#}");
        assert_eq!(run["digest"].as_str().map(str::len), Some(32), "{run:#}");
        let [robots, touched] = ["robots", "touched"].map(|name| run[name].as_u64());
        assert_eq!((robots, touched, run["reached"].as_bool()), (Some(5), Some(0), Some(true)));
    }
    let summary = result["summary"].as_object().expect("a summary");
    for metric in ["reached", "time_s", "path_m_mean", "min_gap_robot_m", "min_gap_wall_m", "commands_changed"] {
        let spread = &summary[metric];
        let of = |name: &str| spread[name].as_f64().unwrap_or_else(|| panic!("{metric} without {name}: {spread}"));
        let [low, q1, median, q3, high] = ["ci95_low", "q1", "median", "q3", "ci95_high"].map(of);
        assert!(q1 <= median && median <= q3 && low <= high, "{metric}: {spread}");
        assert!((of("n") - 3.0).abs() < 1e-9, "{metric}: {spread}");
        let worst = runs(&result).iter().any(|run| {
            let is = run[metric].as_f64().or(run[metric].as_bool().map(f64::from));
            is.is_some_and(|is| (is - of("worst")).abs() < 1e-12)
        });
        assert!(worst, "no run has the worst {metric}: {spread}");
    }
}

#[test]
fn the_same_bytes_come_out_twice_and_with_any_number_of_threads() {
    let bytes = |threads: &str| {
        let output = first(&["--seeds", "3..=6", "--json", "--duration", "15", "--threads", threads]);
        assert_eq!(output.status.code(), Some(1), "15 s are too short to arrive: {}", errors(&output));
        output.stdout
    };
    let one = bytes("1");
    assert!(one.len() > 1_000);
    for threads in ["1", "2", "3"] {
        assert!(one == bytes(threads), "{threads} threads");
    }
}

#[test]
fn keys_that_are_set_count_and_the_last_word_on_a_duration_is_its_own_option() {
    let digest = |arguments: &[&str]| {
        let output = first(&[&["--json", "--duration", "3"], arguments].concat());
        let result = json(&output);
        (runs(&result)[0]["digest"].clone(), runs(&result)[0]["time_s"].as_f64())
    };
    let plain = digest(&[]);
    assert!(plain.1.is_some_and(|time_s| (time_s - 3.0).abs() < 0.01), "{plain:?}");
    assert_eq!(plain, digest(&["--set", "seed=1"]), "its own seed");
    assert_eq!(plain, digest(&["--seeds", "1"]), "its own seed");
    assert_eq!(plain, digest(&["--set", "duration_s=9"]));
    assert_ne!(plain.0, digest(&["--set", "behaviour.leader_speed_mps=0.5"]).0);
    assert_ne!(plain.0, digest(&["--fidelity", "wire"]).0);
}

/// Run with `--record` and give the folders of the seeds.
fn recorded(folder: &Path, arguments: &[&str]) -> Vec<PathBuf> {
    let record_dir = format!("record_dir={:?}", folder.display().to_string());
    let output =
        first(&[&["--record", "--set", &record_dir, "--seeds", "1..3", "--duration", "4"], arguments].concat());
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    let batch = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).next();
    let batch = batch.expect("a folder of the batch");
    assert!(errors(&output).contains(&batch.display().to_string()), "it says where: {}", errors(&output));
    ["seed-1", "seed-2"].map(|seed| batch.join(seed)).into()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn a_recording_holds_everybodys_way_the_result_and_a_swarm_that_can_be_run_again() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed_folder in recorded(folder.path(), &[]) {
        let states = text(&exported(&seed_folder.join("run.mcap")).join("states.csv"));
        let columns = states.lines().next().expect("a head").split(',').count();
        assert!(states.starts_with("time_s,robot,x_m,y_m,yaw_rad,"), "{states:.200}");
        assert!(states.lines().count() > 5 * 39, "five robots, ten times a second");
        assert!(states.lines().all(|line| line.split(',').count() == columns));
        let result: Value = serde_json::from_str(&text(&seed_folder.join("result.json"))).expect("JSON");
        let swarm = seed_folder.join("swarm.toml");
        let checked = drover().arg("check").arg(&swarm).output().expect("drover runs");
        assert_eq!(checked.status.code(), Some(0), "{}", errors(&checked));
        let again = json(&sim(&swarm, &["--json"]));
        assert_eq!(runs(&again)[0], result, "what was recorded is what runs again");
    }
}

#[test]
fn a_recording_of_the_wire_holds_every_links_bytes_in_everybodys_formats() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed_folder in recorded(folder.path(), &["--fidelity", "wire"]) {
        let export = exported(&seed_folder.join("run.mcap"));
        let names: Vec<String> = std::fs::read_dir(&export)
            .expect("a folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        let count = |ending: &str| names.iter().filter(|name| name.ends_with(ending)).count();
        // Two rovers, three chassis with a bus for the drive and one for the lidar.
        assert!(count(".tlog") >= 2 && count(".log") >= 6, "{names:?}");
        assert!(names.iter().any(|name| name == "states.csv"), "{names:?}");
        let bytes = |name: &String| std::fs::metadata(export.join(name)).expect("a file").len();
        let mut links = names.iter().filter(|name| name.ends_with("log"));
        assert!(links.all(|name| bytes(name) > 10_000), "{names:?}");
    }
}

/// A swarm file of its own with one thing changed.
fn changed(folder: &Path, from: &str, to: &str) -> PathBuf {
    let shipped = text(&first_toml()).replace("../", &format!("{}/config/", top().display()));
    assert!(shipped.contains(from), "{from}");
    let path = folder.join("changed.toml");
    std::fs::write(&path, shipped.replacen(from, to, 1)).expect("a writable folder");
    path
}

/// It is refused, and what is said names all of `words`.
fn assert_refused(output: &Output, words: &[&str]) {
    let said = errors(output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(output.stdout.is_empty(), "stdout is for results: {}", String::from_utf8_lossy(&output.stdout));
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} in: {said}");
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn seeds_that_are_none_are_refused_with_how_to_write_them() {
    for (seeds, word) in [("5..5", "A..B"), ("7..2", "A..B"), ("one", "whole number"), ("0..9999999999", "at most")] {
        assert_refused(&first(&["--json", "--seeds", seeds]), &["--seeds", word]);
    }
}

#[test]
fn hostile_swarms_are_refused_with_place_and_advice_and_nothing_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let start = "start = { x_m = 4.6, y_m = 6.0, yaw_rad = 0.0 }";
    let line = text(&first_toml()).lines().position(|line| line == start).expect("robot 1") + 1;
    let place = format!("changed.toml:{line}:");
    let cases = [
        ("start = { x_m = nan, y_m = 6.0 }", ["x_m", "found nan", "do: write a finite number"]),
        ("start = { x_m = 1e300, y_m = 6.0 }", ["x_m", "allowed: a number in", "do:"]),
        ("start = { x_m = 7.2, y_m = 11.0 }", ["inside", "free floor", "do: move it"]),
        ("start = { x_m = 99.0, y_m = 6.0 }", ["found [99, 6]", "free floor", "do: move it"]),
    ];
    for (to, words) in cases {
        assert_refused(
            &sim(&changed(folder.path(), start, to), &["--json"]),
            &[&[place.as_str()], &words[..]].concat(),
        );
    }
    assert_refused(&first(&["--set", "robot[0].start.x_m=nan"]), &["--set robot[0].start.x_m=nan", "do:"]);
    assert_refused(&first(&["--duration", "0"]), &["duration_s", "allowed: a number in"]);
    assert_refused(&first(&["--set", "nonsense"]), &["nonsense"]);
    assert_refused(&sim(&folder.path().join("missing.toml"), &[]), &["missing.toml", "do:"]);
}

#[test]
fn ten_million_robots_are_refused_before_memory_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let fleet = "[[fleet]]\nkind = \"scout_mini\"\nfirst_id = 100\ncount = 10000000\n\n[behaviour]";
    let path = changed(folder.path(), "[behaviour]", fleet);
    let line = text(&path).lines().position(|line| line.starts_with("count")).expect("the count") + 1;
    assert_refused(&sim(&path, &[]), &[&format!("changed.toml:{line}:"), "fleet[0].count", "10000000", "do:"]);
}

#[test]
fn a_map_of_ten_gigabytes_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("a writable folder");
    write("world.toml", b"name = \"big\"\nmap = { file = \"big.yaml\" }\n");
    let yaml =
        "resolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\nimage: big.pgm\n";
    write("big.yaml", yaml.as_bytes());
    write("big.pgm", b"P5\n100000 100000\n255\n");
    let room = format!("world = \"{}/config/worlds/room.toml\"", top().display());
    let path = changed(folder.path(), &room, "world = \"world.toml\"");
    assert_refused(&sim(&path, &[]), &["big.yaml:6:", "big.pgm", "do:"]);
    // A file that really is so long: sparse, so that it costs no disk, and no time if nobody reads it.
    let image = std::fs::File::options().write(true).open(folder.path().join("big.pgm")).expect("the image");
    image.set_len(10_000_000_000).expect("a sparse file");
    let begun = std::time::Instant::now();
    assert_refused(&sim(&path, &[]), &["big.yaml:6:", "big.pgm", "do:"]);
    assert!(begun.elapsed().as_secs_f64() < 5.0, "it was read");
}

#[test]
fn the_quick_benches_print_what_they_measured_and_no_ray_that_differs_without_a_reason() {
    let bench = |name: &str| {
        let output = drover().args(["bench", name, "--quick", "--json"]).output().expect("drover runs");
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("one document")
    };
    let rays = bench("rays");
    let rows = rays["rows"].as_array().expect("rows");
    assert!(rows.len() >= 4 && rows.iter().all(|row| row["unexplained"] == 0), "{rays}");
    let sim = bench("sim");
    let rows = sim["diffusion"].as_array().expect("rows");
    assert!(rows.iter().all(|row| row["off_per_s"].as_f64() > Some(0.0) && row["on_per_s"].as_f64() > Some(0.0)));
    assert!(sim["flocks"][0]["bytes_per_robot"].as_u64() > Some(0) && sim["wire"]["real_time"].as_f64() > Some(0.0));
}

#[test]
fn a_batch_that_is_interrupted_says_what_it_has_and_ends_with_130() {
    let mut child = drover()
        .args(["sim", "config/swarms/diffuse_1000.toml", "--duration", "3600", "--json"])
        .current_dir(top())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("drover runs");
    // Long enough to have read its files and begun; a run of an hour is not over by then on any machine.
    std::thread::sleep(std::time::Duration::from_secs(2));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill runs").success());
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stdout.take().expect("piped"), &mut said).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let result: Value = serde_json::from_str(&said).expect("one document");
    assert_eq!((&result["interrupted"], result["runs"].as_array().map(Vec::len)), (&Value::Bool(true), Some(0)));
}
