//! A recording: other moments of it, and no control that makes no sense.

use crate::common::drover;
use crate::support::{Browser, Shown, alone, assert_clean, fleet_file, number};
use crate::{common::free_port_base, common::json};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Record a small fleet for a few seconds.
fn recorded(folder: &Path) -> PathBuf {
    let base = free_port_base();
    let mut command = drover();
    command.arg("up").arg(fleet_file(folder, 6, "room.toml")).args(["--json", "--no-view", "--duration", "5"]);
    command.arg("--set").arg(format!("mavlink_port_base={base}"));
    command.arg("--set").arg(format!("beacon.port={}", base + 319));
    command.arg("--set").arg(format!("record_dir={:?}", folder.display().to_string()));
    let summary = json(&command.output().expect("drover runs"));
    PathBuf::from(summary["recording"].as_str().unwrap_or_else(|| panic!("not recorded: {summary:#}")))
}

/// Where a moment of the recording has its robots, and when it was.
fn moment(seen: &Value) -> (f64, &Value) {
    (number(&seen["moment"][0]), &seen["moment"][1])
}

#[test]
fn a_recording_is_sought_through_and_cannot_be_stopped() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let shown = Shown::replay(&recorded(folder.path()));
    let found = Browser::open("replay", &shown).found();
    assert_clean(&found, &shown);
    let controls = json!({ "stop": false, "pause": true, "speed": true, "restart": true, "seek": true });
    assert_eq!(found["shown"], controls);
    for seen in found["seen"].as_array().expect("a list") {
        let off_s = moment(seen).0 - number(&seen["sought"]);
        assert!(off_s.abs() < 0.2, "off by {off_s} s: {seen:#}");
    }
    let ((late_s, there), (early_s, here)) = (moment(&found["seen"][0]), moment(&found["seen"][1]));
    assert!(late_s > early_s && there != here, "the robots are where they were: {found:#}");
    assert!(number(&found["later"]) > early_s + 0.5, "it does not go on: {found:#}");
    assert_eq!(shown.interrupt().0, Some(0));
}
