//! `drover replay --check`: what robots' links received, fed to today's code, leads to the same decisions and bytes.

use drover_config::robot_from_text;
use drover_contract::Stamp;
use drover_io::{TapeEntry, TapeEvent, TapePort, TapeSink};
use drover_record::{Begin, Pace, Recorder, RecorderOptions, RecordingFile};
use drover_robot::rerun;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn drover() -> Command {
    Command::new(env!("CARGO_BIN_EXE_drover"))
}

/// A run of the shipped swarm in virtual time, recorded.
fn recorded(arguments: &[&str]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/swarms/first.toml");
    let record_dir = format!("record_dir={:?}", folder.path().display().to_string());
    let output = drover()
        .arg("sim")
        .arg(swarm)
        .args(["--record", "--seeds", "1", "--set", &record_dir])
        .args(arguments)
        .output()
        .expect("drover runs");
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    let run = std::fs::read_dir(folder.path()).expect("a folder").next().expect("a run").expect("a run");
    let path = run.path().join("seed-1/run.mcap");
    (folder, path)
}

fn check(path: &Path, arguments: &[&str]) -> Output {
    drover().args(["replay", "--check"]).arg(path).args(arguments).output().expect("drover runs")
}

fn checked(path: &Path) -> (Vec<Value>, Option<i32>) {
    let output = check(path, &["--json"]);
    let found = serde_json::from_slice(&output.stdout);
    (found.unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr))), output.status.code())
}

fn is_the_same(robot: &Value) -> bool {
    robot["decision"].is_null() && robot["wire"].is_null()
}

#[test]
fn a_whole_run_in_virtual_time_is_the_same_again() {
    let (_folder, path) = recorded(&["--fidelity", "wire"]);
    let (robots, code) = checked(&path);
    assert_eq!((robots.len(), code), (5, Some(0)), "{robots:#?}");
    for robot in &robots {
        assert!(is_the_same(robot), "{robot:#}");
        for count in ["turns", "ticks", "sent"] {
            assert!(robot[count].as_u64().is_some_and(|count| count > 500), "{robot:#}");
        }
    }
    let words = String::from_utf8(check(&path, &[]).stdout).expect("text");
    assert_eq!(words.matches("decision: the same").count(), 5, "{words}");
    assert_eq!(words.matches("wire: the same").count(), 5, "{words}");
}

#[test]
fn a_recording_without_links_is_refused_in_clear_words() {
    let (_folder, path) = recorded(&["--duration", "3"]);
    let output = check(&path, &[]);
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words}");
    assert!(words.contains("holds no robot's links") && words.contains("--fidelity wire"), "{words}");
}

/// The recording at `path`, but for what `change_file` and `change_tape` make of robot `changed`'s file and tape; what
/// the robots decided stays as it was.
fn altered(
    path: &Path,
    changed: u32,
    change_file: impl Fn(&str) -> String,
    change_tape: impl Fn(&mut Vec<TapeEntry>),
) -> PathBuf {
    let recording = RecordingFile::open(path).unwrap_or_else(|error| panic!("{error}"));
    let altered = path.with_file_name("altered.mcap");
    let options = RecorderOptions { path: altered.clone(), pace: Pace::Virtual, unix_offset_us: 0 };
    let recorder = Recorder::create(options, &recording.setting).unwrap_or_else(|error| panic!("{error}"));
    for begin in &recording.begins {
        let Begin { robot, epoch, now_us, .. } = *begin;
        let now = Stamp::from_micros(now_us);
        let file = |text: &str| robot_from_text(text, "a robot's file").unwrap_or_else(|error| panic!("{error}"));
        let mut tape = recording.tape(begin);
        let is_changed = robot == changed;
        let told = if is_changed { change_file(&begin.file) } else { begin.file.clone() };
        let eyes = recorder.robot(&file(&told), epoch, now).witness;
        rerun(file(&begin.file), (epoch, now), &tape, eyes).unwrap_or_else(|error| panic!("{error}"));
        if is_changed {
            change_tape(&mut tape);
        }
        recorder.take(robot, tape);
    }
    recorder.finish(&Value::Null);
    altered
}

/// Only robot `id` differs; where its decisions, or its wire, do.
fn only_difference<'a>(robots: &'a [Value], id: u32, what: &str) -> &'a Value {
    for robot in robots {
        assert_eq!(is_the_same(robot), robot["robot"] != id, "{robot:#}");
    }
    let robot = robots.iter().find(|robot| robot["robot"] == id).expect("the robot");
    let difference = &robot[what];
    assert!(difference["recorded"] != difference["now"], "no {what} differs: {robot:#}");
    difference
}

#[test]
fn a_copy_of_a_recording_is_the_same_again() {
    let (_folder, path) = recorded(&["--fidelity", "wire", "--duration", "8"]);
    let (robots, code) = checked(&altered(&path, 0, str::to_owned, |_| {}));
    assert!(robots.len() == 5 && robots.iter().all(is_the_same), "{robots:#?}");
    assert_eq!(code, Some(0));
}

#[test]
fn another_gain_in_a_robots_file_is_found_with_tick_and_field() {
    let (_folder, path) = recorded(&["--fidelity", "wire", "--duration", "8"]);
    let another = |text: &str| {
        assert_eq!(text.matches("\ngain = 1.0\n").count(), 1, "{text}");
        text.replace("\ngain = 1.0\n", "\ngain = 2.0\n")
    };
    let altered = altered(&path, 4, another, |_| {});
    let (robots, code) = checked(&altered);
    assert_eq!(code, Some(1));
    let difference = only_difference(&robots, 4, "decision");
    let field = difference["field"].as_str().unwrap_or_default();
    assert!(field.starts_with("request_"), "the law asks for something else: {difference:#}");
    assert!(difference["index"].as_u64().is_some_and(|index| index > 0), "not before it drives: {difference:#}");
    let words = String::from_utf8(check(&altered, &[]).stdout).expect("text");
    let expected = format!("decision first differs at tick or entry {}", difference["index"]);
    assert!(words.contains("robot 4 (life") && words.contains(&expected) && words.contains(field), "{words}");
}

#[test]
fn another_byte_from_a_chassis_is_found_where_it_first_tells() {
    let (_folder, path) = recorded(&["--fidelity", "wire", "--duration", "8"]);
    let at_s = 6.0;
    let another_speed = |tape: &mut Vec<TapeEntry>| {
        // 0x221 is what the chassis measures; byte 0 is the high one of its speed. Its identifier is in the first four.
        let mut after = tape.iter_mut().filter(|entry| entry.stamp.as_secs_f64() > at_s);
        let first = after.find_map(|entry| match &mut entry.event {
            TapeEvent::Received(TapePort::DriveBus, bytes) if bytes.starts_with(&0x221_u32.to_le_bytes()) => {
                Some(bytes)
            }
            _ => None,
        });
        first.expect("the chassis tells its speed")[4] ^= 0x01;
    };
    let (robots, code) = checked(&altered(&path, 3, str::to_owned, another_speed));
    assert_eq!(code, Some(1));
    // The peers would have been told another speed.
    let difference = only_difference(&robots, 3, "wire");
    assert_eq!(difference["field"], "sent to Beacons", "{difference:#}");
    let time_s = difference["time_s"].as_f64().expect("a time");
    assert!((at_s..at_s + 0.3).contains(&time_s), "{difference:#}");
}
