//! What is left of a recording when a process is killed, or when its disk is full.

use crate::common::{Place, Running, drover, first_swarm, json, peer, up, up_command};
use drover_record::RecordingFile;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// A process that dies takes this much of its recording with it at most, s.
const LOSS_S_MAX: f64 = 1.0;

fn unix_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock after 1970").as_secs_f64()
}

/// The only file that ends in .mcap in `folder` or in a folder in it.
fn recording_in(folder: &Path) -> PathBuf {
    let list = |folder: &Path| -> Vec<PathBuf> {
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
    };
    let mut all: Vec<PathBuf> = list(folder).iter().filter(|path| path.is_dir()).flat_map(|path| list(path)).collect();
    all.extend(list(folder));
    all.retain(|path| path.extension().is_some_and(|end| end == "mcap"));
    assert_eq!(all.len(), 1, "{all:?}");
    all.remove(0)
}

fn opened(path: &Path) -> RecordingFile {
    RecordingFile::open(path).unwrap_or_else(|error| panic!("{error}"))
}

/// What the MCAP project's own reader finds, with an index and without.
fn read_by_others(path: &Path) -> Value {
    let output = peer("read_mcap.py").arg(path).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = json(&output);
    let found = found[path.display().to_string()].clone();
    assert_eq!(found["streamed"], found["messages"], "{found:#}");
    found
}

/// The file opens everywhere, and what it lacks is at most a second.
fn assert_survived(path: &Path, killed_s: f64) {
    let found = read_by_others(path);
    assert_eq!(found["summary"], false, "nobody was there to write one: {found:#}");
    let lost_s = killed_s - found["last_s"].as_f64().expect("a time");
    println!("{}: {lost_s:.3} s lost of {} bytes", path.display(), found["bytes"]);
    assert!((0.0..=LOSS_S_MAX).contains(&lost_s), "{lost_s} s lost");
    let file = opened(path);
    assert!(!file.complete && file.summary.is_none());
    let counted: u64 = file.messages_by_topic().values().sum();
    assert_eq!(found["messages"], counted, "both read the same");
    assert!(file.duration_s > 3.0 && file.moments(true).len() > 30, "{} s", file.duration_s);
    for begin in &file.begins {
        assert!(file.tape(begin).len() > 100 && file.decisions(begin).len() > 20, "robot {}", begin.robot);
    }
}

#[test]
fn a_killed_swarm_leaves_a_recording_that_lacks_a_second_at_most() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = up_command(folder.path(), &["--no-view", "--duration", "30"]);
    let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
    std::thread::sleep(Duration::from_secs(5));
    let killed_s = unix_s();
    running.kill();
    let path = recording_in(folder.path());
    assert_eq!(opened(&path).begins.len(), 5);
    assert_survived(&path, killed_s);
    // What is left is still good for all that a recording is good for.
    let checked = drover().args(["replay", "--check", "--json"]).arg(&path).output().expect("drover runs");
    assert_all_the_same(&json(&checked), 50);
}

#[test]
fn a_killed_robot_leaves_a_recording_that_lacks_a_second_at_most() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(first_swarm(folder.path(), &[]), folder);
    let kept = place.folder.path().join("kept");
    let path = place.robot_file(0);
    let text = std::fs::read_to_string(&path).expect("the robot's file");
    std::fs::write(&path, format!("record_dir = {:?}\n{text}", kept.display().to_string())).expect("a writable file");
    let mut command = drover();
    command.arg("run").arg(&path).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut running = Running::start(&mut command);
    std::thread::sleep(Duration::from_secs(5));
    let killed_s = unix_s();
    running.kill();
    assert_survived(&recording_in(&kept), killed_s);
}

/// A run whose recordings go to a disk of its own, in a mount namespace of its own, with room for `kib`; what is left
/// of the recording is copied to `left`.
fn up_on_a_small_disk(folder: &Path, kib: u32, left: &Path, arguments: &[&str]) -> Command {
    let disk = folder.join("disk");
    std::fs::create_dir_all(&disk).expect("a folder");
    let up = up_command(&disk, arguments);
    // "$@" is the run.
    let script = format!(
        "mount -t tmpfs -o size={kib}k tmpfs '{disk}' && {{ \"$@\"; ended=$?; cp '{disk}'/*/run.mcap '{left}'; \
         exit $ended; }}",
        disk = disk.display(),
        left = left.display()
    );
    let root = Command::new("id").arg("-u").output().expect("id runs").stdout == b"0\n";
    let mut command = Command::new("unshare");
    command.arg(if root { "-m" } else { "-rm" }).args(["sh", "-c", &script, "sh"]);
    command.arg(up.get_program()).args(up.get_args()).stdin(Stdio::null());
    command
}

#[test]
fn a_full_disk_ends_the_recording_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let left = folder.path().join("left.mcap");
    let arguments = ["--no-view", "--duration", "12", "--json"];
    let output = up_on_a_small_disk(folder.path(), 160, &left, &arguments).output().expect("unshare runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    let summary = json(&output);
    assert_eq!(output.status.code(), Some(1), "the time was over, nothing else: {errors}");
    assert_eq!((&summary["stopped"], &summary["aged_commands"]), (&true.into(), &0.into()), "{summary:#}");
    let robots = summary["robots"].as_array().expect("robots");
    let moved = |robot: &Value| robot["path_m"].as_f64().is_some_and(|path_m| path_m > 3.0);
    assert!(robots.iter().all(moved), "they drove on: {summary:#}");
    for words in [&*errors, summary["recording_failed"].as_str().unwrap_or_default()] {
        assert!(words.contains("the recording has ended, the robots go on"), "{words}");
        assert!(words.contains("make room, or set record_dir to another disk"), "{words}");
    }
    assert!(summary["recording_dropped"].as_u64().is_some_and(|dropped| dropped > 0), "{summary:#}");
    let found = read_by_others(&left);
    let file = opened(&left);
    assert!(!file.complete && file.duration_s > 1.0 && file.duration_s < 11.0, "{} s", file.duration_s);
    println!("{} bytes, {:.1} s of 12 s", found["bytes"], file.duration_s);
}

/// Every robot decides and sends again what it decided and sent.
fn assert_all_the_same(checked: &Value, ticks: u64) {
    let robots = checked.as_array().expect("robots");
    assert_eq!(robots.len(), 5, "{checked:#}");
    for robot in robots {
        assert!(robot["decision"].is_null() && robot["wire"].is_null(), "{robot:#}");
        assert!(robot["ticks"].as_u64().is_some_and(|count| count > ticks), "{robot:#}");
    }
}

#[test]
fn a_run_in_real_time_fed_to_the_same_code_gives_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    up(folder.path(), &["--no-view", "--duration", "8", "--json"]);
    let path = recording_in(folder.path());
    let output = drover().args(["replay", "--check", "--json"]).arg(&path).output().expect("drover runs");
    assert_all_the_same(&json(&output), 100);
    assert_eq!(output.status.code(), Some(0));
}
