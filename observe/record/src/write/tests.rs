//! What the recorder puts on a disk, seen after every single write.

use super::sealed::tests::SmallDisk;
use super::*;
use crate::{Heard, Place, RobotMoment, RobotSetting, RunState, Truth};
use drover_config::load_swarm;
use drover_io::{TapeEvent, TapePort};
use mcap::MessageStream;
use std::io;
use std::path::Path;

/// Where the robots' clock began, microseconds since the Unix epoch.
pub(crate) const OFFSET_US: u64 = 1_700_000_000_123_456;
/// What a run without an end of the disk may fill.
const ROOM: usize = 1 << 30;

/// A disk that remembers what was on it after every write.
#[derive(Clone, Default)]
pub(crate) struct Snapshots {
    disk: SmallDisk,
    taken: Arc<Mutex<Vec<Vec<u8>>>>,
}

impl Snapshots {
    pub(crate) fn with_room(room: usize) -> Self {
        let snapshots = Self::default();
        snapshots.disk.0.lock().unwrap().1 = room;
        snapshots
    }

    /// What is on it now.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.disk.0.lock().unwrap().0.clone()
    }

    /// What was on it after each write that found room.
    pub(crate) fn taken(&self) -> Vec<Vec<u8>> {
        self.taken.lock().unwrap().clone()
    }
}

impl Store for Snapshots {
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        self.disk.write_all_at(bytes, offset)?;
        self.taken.lock().unwrap().push(self.bytes());
        Ok(())
    }

    fn set_len(&self, len: u64) -> io::Result<()> {
        self.disk.set_len(len)
    }
}

pub(crate) fn setting() -> Setting {
    let robot = |id| RobotSetting { id, kind: "rover".into(), radius_m: 0.3, peer_ms: 500, ..RobotSetting::default() };
    Setting {
        swarm: "two".into(),
        behaviour: "flock".into(),
        seed: 7,
        started_unix_us: OFFSET_US,
        duration_s: Some(60.0),
        robots: vec![robot(1), robot(2)],
        route_m: vec![[0.5, 1.0], [2.0, 1.5]],
        ..Setting::default()
    }
}

/// A scan every second moment; the other moments have the one before.
fn scan(step: u32) -> ScanMoment {
    ScanMoment {
        time_s: f64::from(step / 2 * 2) * 0.1,
        angle_first_rad: -1.5,
        angle_step_rad: 0.25,
        range_m_max: 8.0,
        ranges_m: vec![Some(1.5 + f64::from(step / 2)), Some(crate::CLEAR), None],
    }
}

pub(crate) fn moment(step: u32) -> Moment {
    let at_m = f64::from(step) * 0.0625;
    let robot = |id: u32| RobotMoment {
        id,
        state: "active".into(),
        reason: "driving".into(),
        changed: (step % 10 == 3).then(|| "obstacle".into()),
        link: "ready".into(),
        truth: Some(Truth {
            place: Place { x_m: at_m, y_m: f64::from(id), yaw_rad: 0.5 },
            twist_b: [0.625, -0.125],
            in_contact: false,
        }),
        believed: Some(Place { x_m: at_m + 0.0625, y_m: f64::from(id), yaw_rad: 0.5 }),
        nearest_m: Some(1.5),
        scan_age_ms: Some(40),
        // The kept link is a new one every half second, which is how often links are written.
        heard: vec![Heard { id: 3 - id, age_ms: u64::from(step / 5), kept: id == 2 }],
        scan: Some(scan(step)),
        ..RobotMoment::default()
    };
    Moment {
        time_s: f64::from(step) * 0.1,
        run: RunState { rate: 1.0, words: format!("step {step}"), ..RunState::default() },
        robots: vec![robot(1), robot(2)],
        movers_m: vec![[at_m, 3.0]],
        min_gap_robot_m: Some(0.75),
        min_gap_wall_m: None,
    }
}

/// The file of a robot of the shipped swarm.
pub(crate) fn robot_file() -> RobotFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/swarms/first.toml");
    let swarm = load_swarm(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    swarm.robot_file(1).expect("robot 1")
}

/// A turn of a loop with everything that can be on a tape, to the microsecond; what it reads and sends has its time.
pub(crate) fn turn(now_us: u64) -> Vec<TapeEntry> {
    let at = |dt_us, event| TapeEntry { stamp: Stamp::from_micros(now_us + dt_us), event };
    vec![
        at(0, TapeEvent::Turn),
        at(0, TapeEvent::Received(TapePort::Autopilot, vec![0xFD, 0, 255, 7])),
        at(0, TapeEvent::Received(TapePort::LidarBus, vec![1, 2, 3, 4, 5])),
        at(17, TapeEvent::Clock),
        at(0, TapeEvent::Sent(TapePort::DriveBus, Vec::new())),
        at(0, TapeEvent::Sent(TapePort::Beacons, vec![9; 300])),
        at(401, TapeEvent::ToldToEnd("operator".into())),
    ]
}

pub(crate) fn decision(stamp_us: u64, changed: Option<&str>) -> Decision {
    Decision {
        stamp_us,
        verdict: "driving".into(),
        request_speed_mps: Some(0.1 + 0.2),
        command_speed_mps: 0.25,
        changed: changed.map(Into::into),
        scan_age_us: Some(0),
        x_m: 1.0 / 3.0,
        progress: 0.5,
        ..Decision::default()
    }
}

pub(crate) fn on(disk: &Snapshots, pace: Pace) -> Result<Recorder, String> {
    let options = RecorderOptions { path: PathBuf::new(), pace, unix_offset_us: OFFSET_US };
    Recorder::on(Box::new(disk.clone()), "run.mcap".into(), &options, &setting())
}

/// One decision, as a robot's own witness would put it down.
pub(crate) fn decide(recorder: &Recorder, robot: u32, decision: Decision) {
    recorder.put(Item::Decision { robot, decision: Box::new(decision) });
}

/// Everything of `steps` tenths of a second: moments, two lives of robot 1, words.
pub(crate) fn record(recorder: &Recorder, steps: u32) {
    let file = robot_file();
    for step in 0..steps {
        let now_us = u64::from(step) * 100_000 + 3;
        if step == 0 || step == steps / 2 {
            recorder.put(Item::Begin(Box::new(Begin {
                robot: 1,
                epoch: 7 + u32::from(step > 0),
                now_us,
                unix_offset_us: OFFSET_US,
                file: file.to_toml(),
            })));
        }
        recorder.take(1, turn(now_us));
        decide(recorder, 1, decision(now_us, (step % 10 == 3).then_some("obstacle")));
        recorder.moment_with_scans(&moment(step));
        if step % 8 == 0 {
            recorder.say(Stamp::from_micros(now_us), Severity::Warning, 1, "a word");
        }
    }
}

/// A whole recording in memory.
pub(crate) fn whole(steps: u32) -> (Snapshots, RecorderState) {
    let disk = Snapshots::with_room(ROOM);
    let recorder = on(&disk, Pace::Virtual).unwrap();
    record(&recorder, steps);
    recorder.finish(&serde_json::json!({ "reached": true, "time_s": 1.5 }));
    (disk, recorder.state())
}

/// Messages that any reader finds, which demands the magic at the end.
fn messages(bytes: &[u8]) -> usize {
    MessageStream::new(bytes).unwrap().inspect(|message| assert!(message.is_ok(), "{message:?}")).count()
}

#[test]
fn after_every_write_the_file_is_a_whole_one_and_grows() {
    let (disk, state) = whole(60);
    assert_eq!((state.dropped, &state.failed), (0, &None));
    let taken = disk.taken();
    assert!(taken.len() > 9, "{} writes in six seconds", taken.len());
    let counts: Vec<usize> = taken.iter().map(|bytes| messages(bytes)).collect();
    assert!(counts.is_sorted() && counts[0] > 0, "{counts:?}");
    // What is not in the file yet is never much.
    let (last, before) = (counts[counts.len() - 1], counts[counts.len() - 2]);
    assert!(last - before < last / 8, "{counts:?}");
}

#[test]
fn a_finished_file_has_a_summary_chunk_indexes_and_statistics() {
    let (disk, state) = whole(60);
    let bytes = disk.bytes();
    assert_eq!(state.bytes, bytes.len() as u64);
    let summary = mcap::Summary::read(&bytes).unwrap().expect("a summary");
    let stats = summary.stats.expect("statistics");
    assert_eq!(stats.message_count, messages(&bytes) as u64);
    assert_eq!(stats.chunk_count as usize, summary.chunk_indexes.len());
    assert!(summary.chunk_indexes.len() > 8);
    assert_eq!(stats.message_start_time, OFFSET_US * 1_000);
    assert!(summary.channels.values().all(|channel| channel.schema.is_some()));
}

#[test]
fn virtual_time_gives_the_same_bytes_twice() {
    assert!(whole(40).0.bytes() == whole(40).0.bytes());
}

#[test]
fn a_disk_without_room_for_the_setting_is_refused_at_once() {
    let refused = on(&Snapshots::with_room(100), Pace::Virtual).map(|_| ()).unwrap_err();
    assert!(refused.contains("cannot record there"), "{refused}");
}

#[test]
fn a_disk_that_fills_up_ends_the_recording_with_advice_and_leaves_what_was_there() {
    for pace in [Pace::Virtual, Pace::RealTime] {
        let disk = Snapshots::with_room(30_000);
        let recorder = on(&disk, pace).unwrap();
        record(&recorder, 200);
        recorder.finish(&serde_json::json!({}));
        let state = recorder.state();
        let words = state.failed.expect("30 kB are too few");
        assert!(words.contains("the recording has ended, the robots go on; make room"), "{words}");
        assert!(state.dropped > 0, "what came later is counted");
        assert_eq!(disk.taken().last(), Some(&disk.bytes()), "what was there before is there still");
        assert!(messages(&disk.bytes()) > 10);
        assert!(disk.bytes().len() <= 30_000);
    }
}

#[test]
fn what_is_put_after_the_end_changes_nothing() {
    let disk = Snapshots::with_room(ROOM);
    let recorder = on(&disk, Pace::Virtual).unwrap();
    recorder.finish(&serde_json::json!({}));
    let before = disk.bytes();
    record(&recorder, 3);
    recorder.finish(&serde_json::json!({}));
    assert!(disk.bytes() == before);
}

#[test]
fn real_time_commits_without_anything_following() {
    let disk = Snapshots::with_room(ROOM);
    let recorder = on(&disk, Pace::RealTime).unwrap();
    let before = messages(&disk.bytes());
    recorder.say(Stamp::ZERO, Severity::Info, 0, "alone");
    std::thread::sleep(COMMIT_PERIOD + LOOK_PERIOD * 6);
    assert_eq!(messages(&disk.bytes()), before + 1);
}

/// A disk that does not answer for a while.
#[derive(Clone)]
struct Slow(Snapshots, std::time::Duration);
impl Store for Slow {
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        std::thread::sleep(self.1);
        self.0.write_all_at(bytes, offset)
    }
    fn set_len(&self, len: u64) -> io::Result<()> {
        self.0.set_len(len)
    }
}

#[test]
fn a_summary_is_written_even_if_the_queue_is_full() {
    let disk = Snapshots::with_room(ROOM);
    let options = RecorderOptions { path: PathBuf::new(), pace: Pace::RealTime, unix_offset_us: OFFSET_US };
    let slow = Slow(disk.clone(), std::time::Duration::from_millis(300));
    let recorder = Recorder::on(Box::new(slow), "run.mcap".into(), &options, &setting()).unwrap();
    // The writer may keep up until its next commit, which the disk holds up.
    let mut step = 0;
    while recorder.state().dropped == 0 && step < 100 * QUEUE as u64 {
        recorder.say(Stamp::from_micros(step), Severity::Info, 0, "w");
        step += 1;
    }
    assert!(recorder.state().dropped > 0);
    recorder.finish(&serde_json::json!({ "reached": true }));
    assert!(crate::RecordingFile::of_bytes(&disk.bytes()).unwrap().summary.is_some());
}
