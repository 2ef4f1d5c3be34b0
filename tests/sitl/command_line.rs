//! What a user does wrong, and what is said.

use crate::common::{drover, first_toml, free_port_base, json, top};
use std::net::UdpSocket;
use std::process::Output;

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn a_port_in_use_is_named_and_nothing_starts() {
    let base = free_port_base();
    let _taken = UdpSocket::bind(("127.0.0.1", base + 1)).expect("it was free");
    let folder = tempfile::tempdir().expect("a folder");
    let output = drover()
        .arg("up")
        .arg(first_toml())
        .args(["--set", &format!("mavlink_port_base={base}")])
        .args(["--set", &format!("record_dir={:?}", folder.path().display().to_string())])
        .output()
        .expect("drover runs");
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    let text = said(&output);
    assert!(text.contains(&(base + 1).to_string()) && text.contains("in use"), "{text}");
}

#[test]
fn a_can_interface_that_is_not_there_is_named_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = crate::common::first_swarm(folder.path(), &[]);
    let mut file = swarm.robot_file(3).expect("robot 3");
    file.robot.links = drover_config::Links::Can { drive: "can77".into(), lidar: "can78".into() };
    let path = folder.path().join("robot.toml");
    std::fs::write(&path, file.to_toml()).expect("a writable folder");
    let output = drover().arg("run").arg(&path).output().expect("drover runs");
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("can77"), "{}", said(&output));
}

fn is_toml(path: &std::path::Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml")
}

#[test]
fn every_shipped_file_is_good() {
    let mut files = Vec::new();
    for folder in ["config/robots", "config/worlds", "config/worlds/generated", "config/swarms"] {
        let entries = std::fs::read_dir(top().join(folder)).expect("a folder");
        files.extend(entries.map(|entry| entry.expect("an entry").path()).filter(|path| is_toml(path)));
    }
    assert!(files.len() >= 16);
    let output = drover().arg("check").args(&files).output().expect("drover runs");
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn all_problems_of_a_file_are_said_at_once_with_their_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(first_toml()).expect("the shipped swarm");
    let text = text
        .replacen("seed = 1", "seed = \"one\"\nsede = 2", 1)
        .replace("../", &format!("{}/config/", top().display()));
    let path = folder.path().join("bad.toml");
    std::fs::write(&path, text).expect("a writable folder");
    let output = drover().arg("check").arg("--json").arg(&path).output().expect("drover runs");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let rows = json(&output);
    let problems = rows[0]["problems"].as_array().expect("problems");
    let keys: Vec<&str> = problems.iter().filter_map(|problem| problem["key"].as_str()).collect();
    assert!(keys.contains(&"seed") && keys.contains(&"sede"), "{rows:#}");
    assert!(problems.iter().all(|problem| problem["line"].as_u64().is_some_and(|line| line > 0)), "{rows:#}");
}

#[test]
fn hostile_files_are_refused_and_end_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let nested = format!("a = {}1{}", "[".repeat(50_000), "]".repeat(50_000));
    let cases: [(&str, &[u8]); 5] = [
        ("empty.toml", b""),
        ("binary.toml", &[0xFF, 0xFE, 0x00, 0x80]),
        ("truncated.toml", b"name = \"x\"\n[[robot"),
        ("nested.toml", nested.as_bytes()),
        ("numbers.toml", b"seed = 99999999999999999999999999999\nduration_s = nan\n"),
    ];
    for (name, bytes) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a writable folder");
        for verb in ["up", "run", "check"] {
            let output = drover().arg(verb).arg(&path).output().expect("drover runs");
            assert_eq!(output.status.code(), Some(2), "{verb} {name}: {}", said(&output));
            assert!(said(&output).contains(name), "{verb} {name}: {}", said(&output));
            assert!(!said(&output).contains("panicked"), "{verb} {name}: {}", said(&output));
        }
    }
}
