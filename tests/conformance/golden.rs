//! The golden vectors are what others' implementations make today, not what somebody once edited.

use crate::common::{peers_python, top};
use std::process::Command;

fn makes_the_same(script: &str, arguments: &[&str]) {
    let folder = top().join("tests/golden");
    let output = Command::new(peers_python()).arg(folder.join(script)).args(arguments).current_dir(&folder).output();
    let output = output.expect("Python runs");
    assert!(output.status.success(), "{script} makes another file: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn mavlink_vectors_are_what_pymavlink_makes() {
    makes_the_same("mavlink/make.py", &["--check"]);
}

#[test]
fn dronecan_vectors_are_what_pydronecan_makes() {
    makes_the_same("can/make_dronecan.py", &["--check", "can/dronecan.json"]);
}
