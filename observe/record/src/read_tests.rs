use super::*;
use crate::CLEAR;
use crate::write::tests::{OFFSET_US, Snapshots, decision, moment, on, record, setting, turn, whole};
use crate::write::{Pace, Recorder, RecorderOptions};

const STEPS: u32 = 40;

fn read(bytes: &[u8]) -> RecordingFile {
    RecordingFile::of_bytes(bytes).expect("a recording")
}

fn count(file: &RecordingFile) -> u64 {
    file.messages_by_topic().values().sum()
}

/// What a file holds of step `step`.
fn expected(step: u32) -> Moment {
    let mut expected = moment(step);
    // Links are written every half second, scans once each.
    for (robot, then) in expected.robots.iter_mut().zip(moment(step / 5 * 5).robots) {
        robot.heard = then.heard;
    }
    expected
}

#[test]
fn setting_and_moments_come_back_with_scans_and_what_was_heard() {
    let file = read(&whole(STEPS).0.bytes());
    assert_eq!(file.setting, setting());
    let moments = file.moments(true);
    assert_eq!(moments.len(), STEPS as usize);
    for (step, found) in (0..).zip(&moments) {
        let expected = expected(step);
        assert!((found.time_s - expected.time_s).abs() < 1e-9, "{} {}", found.time_s, expected.time_s);
        assert_eq!(found.run, expected.run);
        let moved_m = (found.movers_m[0][0] - expected.movers_m[0][0]).abs();
        assert!(found.movers_m.len() == 1 && moved_m < 1e-4, "{found:?}");
        assert_eq!((found.min_gap_robot_m, found.min_gap_wall_m), (Some(0.75), None));
        for (found, expected) in found.robots.iter().zip(&expected.robots) {
            let (scan, wanted) = (found.scan.as_ref().expect("a scan"), expected.scan.as_ref().expect("one"));
            assert!((scan.time_s - wanted.time_s).abs() < 1e-5, "{} {}", scan.time_s, wanted.time_s);
            assert_scan(scan, wanted);
            let (mut found, mut expected) = (found.clone(), expected.clone());
            (found.scan, expected.scan) = (None, None);
            assert_eq!(found, expected, "step {step}");
        }
    }
    assert!(file.moments(false).iter().all(|moment| moment.robots.iter().all(|robot| robot.scan.is_none())));
}

fn assert_scan(found: &ScanMoment, wanted: &ScanMoment) {
    assert!((found.angle_first_rad - wanted.angle_first_rad).abs() < 1e-4);
    assert!((found.angle_step_rad - wanted.angle_step_rad).abs() < 1e-4);
    assert!((found.range_m_max - 8.0).abs() < 1e-9);
    assert_eq!(found.ranges_m.len(), 3);
    let (first, wanted) = (found.ranges_m[0].expect("a hit"), wanted.ranges_m[0].expect("a hit"));
    assert!((first - wanted).abs() < 1e-3, "{first} {wanted}");
    assert_eq!(found.ranges_m[1..], [Some(CLEAR), None]);
}

#[test]
fn tapes_and_decisions_of_each_life_come_back_to_the_microsecond() {
    let file = read(&whole(STEPS).0.bytes());
    let begins: Vec<_> = file.begins.iter().map(|begin| (begin.robot, begin.epoch, begin.now_us)).collect();
    let now_us = |step: u32| u64::from(step) * 100_000 + 3;
    assert_eq!(begins, [(1, 7, now_us(0)), (1, 8, now_us(STEPS / 2))]);
    for (begin, steps) in file.begins.iter().zip([0..STEPS / 2, STEPS / 2..STEPS]) {
        assert_eq!(begin.file, crate::write::tests::robot_file().to_toml());
        let wanted: Vec<TapeEntry> = steps.clone().flat_map(|step| turn(now_us(step))).collect();
        assert!(file.tape(begin) == wanted, "life {}", begin.epoch);
        let changed = |step: u32| (step % 10 == 3).then_some("obstacle");
        let wanted: Vec<Decision> = steps.map(|step| decision(now_us(step), changed(step))).collect();
        assert_eq!(file.decisions(begin), wanted);
    }
}

#[test]
fn interventions_summary_and_end_come_back() {
    let file = read(&whole(STEPS).0.bytes());
    let interventions = file.interventions();
    assert_eq!(interventions.len(), 4);
    for ((time_s, robot, why), wanted_s) in interventions.iter().zip([0.3, 1.3, 2.3, 3.3]) {
        assert!((time_s - wanted_s).abs() < 1e-4 && *robot == 1 && why == "obstacle", "{interventions:?}");
    }
    assert_eq!(file.summary, Some(serde_json::json!({ "reached": true, "time_s": 1.5 })));
    assert!(file.complete);
    assert!((file.duration_s - f64::from(STEPS - 1) * 0.1).abs() < 1e-9);
    assert_eq!(file.messages_by_topic()["/log"], 5);
}

#[test]
fn a_file_that_is_still_written_is_read_and_said_not_to_be_complete() {
    let disk = whole(STEPS).0;
    let taken = disk.taken();
    let (last, before) = taken.split_last().expect("writes");
    let mut messages = 0;
    for bytes in before {
        let file = read(bytes);
        assert!(!file.complete && file.summary.is_none());
        assert!(count(&file) >= messages);
        messages = count(&file);
    }
    assert!(read(last).complete);
}

#[test]
fn a_file_that_was_cut_anywhere_gives_its_beginning_or_nothing() {
    let whole = whole(STEPS).0.bytes();
    let all = read(&whole);
    let mut messages = 0;
    for place in 0..60 {
        let cut = &whole[..whole.len() * place / 60];
        let Some(file) = RecordingFile::of_bytes(cut) else {
            assert_eq!(messages, 0, "nothing at {place} of 60, after something before");
            continue;
        };
        assert!(!file.complete && count(&file) >= messages, "{place} of 60");
        messages = count(&file);
        assert!(messages <= count(&all));
        assert_eq!(file.setting, all.setting);
        let (some, every) = (file.moments(false), all.moments(false));
        // The last of them may lack what was written after it; the others are as they were.
        let sure = some.len().saturating_sub(1);
        assert_eq!(some[..sure], every[..sure], "{place} of 60");
    }
    assert!(messages > count(&all) / 2, "{messages} of {}", count(&all));
}

#[test]
fn garbage_is_no_recording_and_panics_nobody() {
    let whole = whole(STEPS).0.bytes();
    let mut random = 1_u64;
    let mut next = move || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(random >> 33).expect("31 bits")
    };
    for round in 0..200 {
        let mut bytes = whole.clone();
        for _ in 0..=round % 7 {
            let at = next() % bytes.len();
            bytes[at] = (next() % 256) as u8;
        }
        if let Some(file) = RecordingFile::of_bytes(&bytes) {
            let _ = file.moments(true);
            let _ = file.interventions();
            file.begins.iter().for_each(|begin| drop((file.tape(begin), file.decisions(begin))));
            let _ = file.wire_files(|_| {});
        }
    }
    let noise: Vec<u8> = (0..5_000).map(|_| (next() % 256) as u8).collect();
    assert!(RecordingFile::of_bytes(&noise).is_none());
    assert!(RecordingFile::of_bytes(&[&whole[..8], &noise].concat()).is_none());
    assert!(RecordingFile::of_bytes(&[]).is_none());
}

#[test]
fn what_was_there_before_the_disk_was_full_is_read() {
    let disk = Snapshots::with_room(30_000);
    let recorder = on(&disk, Pace::Virtual).expect("room for a setting");
    record(&recorder, 200);
    recorder.finish(&serde_json::json!({}));
    let file = read(&disk.bytes());
    assert!(!file.complete && file.summary.is_none());
    let moments = file.moments(false);
    assert!(moments.len() > 10 && moments.len() < 200, "{}", moments.len());
    assert!(!file.tape(&file.begins[0]).is_empty());
}

#[test]
fn a_file_on_a_disk_is_opened_and_what_is_none_is_refused_with_advice() {
    let folder = std::env::temp_dir().join(format!("drover-read-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("run.mcap");
    let options = RecorderOptions { path: path.clone(), pace: Pace::RealTime, unix_offset_us: OFFSET_US };
    let recorder = Recorder::create(options, &setting()).unwrap_or_else(|error| panic!("{error}"));
    record(&recorder, 5);
    recorder.finish(&serde_json::json!(null));
    let file = RecordingFile::open(&path).unwrap_or_else(|error| panic!("{error}"));
    assert!(file.complete && file.moments(true).len() == 5);
    std::fs::write(&path, "no recording").expect("a writable folder");
    for (path, why) in [(path, "not a recording"), (folder.join("none.mcap"), "No such file")] {
        let refused = RecordingFile::open(&path).map(|_| ()).expect_err("it is none").to_string();
        assert!(refused.contains(why) && refused.contains("give the run.mcap"), "{refused}");
    }
    std::fs::remove_dir_all(&folder).expect("our folder");
}

#[test]
fn a_run_that_was_written_down_before_movers_were_told_is_read() {
    let run = r#"{"phase":"running","rate":1.0,"words":"","stop":null}"#;
    let text = format!(r#"{{"time_s":1.5,"run":{run},"min_gap_robot_m":0.75,"min_gap_wall_m":null}}"#);
    let record: RunRecord = serde_json::from_str(&text).expect("an old recording's");
    assert_eq!((record.movers_m.len(), record.min_gap_robot_m), (0, Some(0.75)));
    assert_eq!(serde_json::to_string(&record).expect("text"), text, "no place without movers has anything new");
}

#[test]
fn an_end_at_the_time_of_the_moment_before_still_has_its_robots() {
    let disk = Snapshots::with_room(1 << 30);
    let recorder = on(&disk, Pace::Virtual).unwrap();
    record(&recorder, 5);
    let mut end = moment(4);
    end.run.phase = crate::Phase::Ended;
    recorder.moment(&end);
    recorder.finish(&serde_json::json!(null));
    let file = read(&disk.bytes());
    let last = file.moments(false).pop().unwrap();
    assert_eq!(last.run.phase, crate::Phase::Ended);
    assert_eq!(last.robots[0].state, "active");
}

#[test]
fn a_time_out_of_all_bounds_panics_nobody() {
    let disk = Snapshots::with_room(1 << 30);
    let recorder = on(&disk, Pace::Virtual).unwrap();
    record(&recorder, 2);
    crate::write::tests::decide(&recorder, 1, decision(u64::MAX, Some("x")));
    recorder.finish(&serde_json::json!(null));
    let file = read(&disk.bytes());
    let _ = file.interventions();
}
