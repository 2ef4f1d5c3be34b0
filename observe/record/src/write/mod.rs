//! Writes a run down, in a thread of its own: who is recorded never waits for a disk.
//!
//! Times are Unix times: the robots' clock plus a fixed offset, so that a step of the calendar clock does not tear a
//! recording and virtual time gives the same bytes twice.

mod deck;
mod sealed;

pub use deck::Begin;
pub(crate) use deck::{RANGE_MAX, RunRecord};

use crate::foxglove::{Decision, LinkHealth};
use crate::moment::{Moment, ScanMoment};
use crate::setting::Setting;
use deck::{Deck, Item};
use drover_config::RobotFile;
use drover_contract::{Scan, Severity, Stamp};
use drover_core::Status;
use drover_io::{OpenError, Tape, TapeEntry, TapeSink};
use drover_robot::{Recording, ScanView, Witness};
use sealed::Store;
use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Items that wait for the disk: some seconds of a hundred robots.
const QUEUE: usize = 16_384;
/// How often the thread looks for items. It is not woken by each: that costs its robots a switch of threads an item.
const LOOK_PERIOD: Duration = Duration::from_millis(50);
/// What was written is in the file after this long, even if nothing follows it.
const COMMIT_PERIOD: Duration = Duration::from_millis(600);
/// The end of a recording waits this long for a slow disk.
const PATIENCE: Duration = Duration::from_secs(5);

/// How a recorder treats those whom it cannot keep up with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Time is real: nobody waits; what finds no room is dropped and counted.
    RealTime,
    /// Time is virtual: it waits, nothing is dropped, and the same run gives the same bytes.
    Virtual,
}

/// What is recorded, and where to.
#[derive(Clone, Debug)]
pub struct RecorderOptions {
    /// The file.
    pub path: PathBuf,
    /// How a slow disk is treated.
    pub pace: Pace,
    /// From the robots' clock's zero back to the Unix epoch, microseconds.
    pub unix_offset_us: u64,
}

/// How a recording is going.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecorderState {
    /// Items that were dropped.
    pub dropped: u64,
    /// Why it has ended early, in words; `None` if it has not.
    pub failed: Option<String>,
    /// Bytes in the file.
    pub bytes: u64,
}

/// A recording that goes on. Clones write to the same file; it is ended by [`Recorder::finish`], or by the last clone.
#[derive(Clone)]
pub struct Recorder(Arc<Shared>);

struct Shared {
    /// `None` once it has ended.
    queue: Mutex<Option<SyncSender<Item>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
    progress: Arc<Progress>,
    pace: Pace,
    unix_offset_us: u64,
}

#[derive(Default)]
struct Progress {
    dropped: AtomicU64,
    bytes: AtomicU64,
    failed: Mutex<Option<String>>,
    /// Not in the queue: that may be full, and this must not be lost.
    summary: Mutex<Option<serde_json::Value>>,
}

impl Recorder {
    /// Begin a recording of the run that `setting` describes.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be made or written, or the system refuses a thread.
    pub fn create(options: RecorderOptions, setting: &Setting) -> Result<Self, OpenError> {
        let name = options.path.display().to_string();
        let refused = |why: String| OpenError::new(&*name, why, "set record_dir to a folder you can write, with room");
        let file = File::create(&options.path).map_err(|error| refused(format!("cannot record there: {error}")))?;
        Self::on(Box::new(file), name.clone(), &options, setting).map_err(refused)
    }

    fn on(store: Box<dyn Store>, name: String, options: &RecorderOptions, setting: &Setting) -> Result<Self, String> {
        let words = |error: mcap::McapError| format!("cannot record there: {error}");
        let mut deck = Deck::new(store, setting.clone(), options.unix_offset_us).map_err(words)?;
        deck.put(Item::Setting(Box::new(setting.clone()))).map_err(words)?;
        let progress = Arc::new(Progress::default());
        let (queue, items) = sync_channel(QUEUE);
        let writing = Writing { deck, name, progress: Arc::clone(&progress), pace: options.pace };
        let thread = std::thread::Builder::new().name("recorder".into()).spawn(move || writing.run(&items));
        let thread = thread.map_err(|error| format!("no thread to record in: {error}"))?;
        Ok(Self(Arc::new(Shared {
            queue: Mutex::new(Some(queue)),
            thread: Mutex::new(Some(thread)),
            progress,
            pace: options.pace,
            unix_offset_us: options.unix_offset_us,
        })))
    }

    /// What records the robot of `file`, whose life `epoch` begins at `now`.
    #[must_use]
    pub fn robot(&self, file: &RobotFile, epoch: u32, now: Stamp) -> Recording {
        let robot = file.robot.id;
        self.put(Item::Begin(Box::new(Begin {
            robot,
            epoch,
            now_us: now.as_micros(),
            unix_offset_us: self.0.unix_offset_us,
            file: file.to_toml(),
        })));
        let tape = Tape::new(robot, Arc::new(self.clone()));
        Recording { tape, witness: Box::new(Eyes { robot, recorder: self.clone() }) }
    }

    /// The run as it is now; ten of these a second are written. Scans in it are not: a robot's own recording has them.
    pub fn moment(&self, moment: &Moment) {
        self.put(Item::Moment { moment: Box::new(moment.clone()), scans: false });
    }

    /// The same for robots without recordings of their own: scans in it are written once each.
    pub fn moment_with_scans(&self, moment: &Moment) {
        self.put(Item::Moment { moment: Box::new(moment.clone()), scans: true });
    }

    /// How a robot's links are.
    pub fn health(&self, now: Stamp, health: LinkHealth) {
        self.put(Item::Health { stamp: now, health: Box::new(health) });
    }

    /// Words of robot `robot`, or of the swarm (0).
    pub fn say(&self, now: Stamp, severity: Severity, robot: u32, words: &str) {
        self.put(Item::Said { stamp: now, severity, robot, words: words.to_owned() });
    }

    /// The run is over. Waits, within a patience if time is real, until all is written; what comes later is dropped.
    pub fn finish(&self, summary: &serde_json::Value) {
        *self.0.progress.summary.lock().unwrap_or_else(PoisonError::into_inner) = Some(summary.clone());
        self.0.end();
    }

    /// How it is going.
    #[must_use]
    pub fn state(&self) -> RecorderState {
        let progress = &self.0.progress;
        RecorderState {
            dropped: progress.dropped.load(Ordering::Relaxed),
            failed: progress.failed.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            bytes: progress.bytes.load(Ordering::Relaxed),
        }
    }

    fn put(&self, item: Item) {
        let queue = self.0.queue.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let taken = match (queue, self.0.pace) {
            (None, _) => return,
            (Some(queue), Pace::RealTime) => queue.try_send(item).is_ok(),
            (Some(queue), Pace::Virtual) => queue.send(item).is_ok(),
        };
        self.0.progress.dropped.fetch_add(u64::from(!taken), Ordering::Relaxed);
    }
}

impl TapeSink for Recorder {
    fn take(&self, robot: u32, entries: Vec<TapeEntry>) {
        self.put(Item::Tape { robot, entries });
    }
}

impl Shared {
    fn end(&self) {
        drop(self.queue.lock().unwrap_or_else(PoisonError::into_inner).take());
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(thread) = thread else { return };
        let deadline = Instant::now() + PATIENCE;
        while self.pace == Pace::RealTime && !thread.is_finished() && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(5));
        }
        if self.pace == Pace::Virtual || thread.is_finished() {
            // It does not panic.
            let _ = thread.join();
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.end();
    }
}

/// Sees one robot decide.
struct Eyes {
    robot: u32,
    recorder: Recorder,
}

impl Witness for Eyes {
    fn decided(&mut self, status: &Status) {
        self.recorder.put(Item::Decision { robot: self.robot, decision: Box::new(Decision::from(status).coarse()) });
    }

    fn scanned(&mut self, scan: &Scan) {
        let scan = Box::new(ScanMoment::from(&ScanView::from(scan)));
        self.recorder.put(Item::Scan { robot: self.robot, scan });
    }

    fn said(&mut self, now: Stamp, severity: Severity, words: &str) {
        self.recorder.say(now, severity, self.robot, words);
    }
}

/// The thread that writes.
struct Writing {
    deck: Deck,
    name: String,
    progress: Arc<Progress>,
    pace: Pace,
}

impl Writing {
    fn run(mut self, items: &Receiver<Item>) {
        let mut commit_at = Instant::now() + COMMIT_PERIOD;
        loop {
            let received = match self.pace {
                Pace::Virtual => items.recv().map_err(|_| TryRecvError::Disconnected),
                Pace::RealTime => items.try_recv(),
            };
            match received {
                Ok(item) => self.attempt(|deck| deck.put(item)),
                Err(TryRecvError::Empty) => std::thread::sleep(LOOK_PERIOD),
                Err(TryRecvError::Disconnected) => break,
            }
            if self.pace == Pace::RealTime && Instant::now() >= commit_at {
                commit_at = Instant::now() + COMMIT_PERIOD;
                self.attempt(Deck::commit);
            }
        }
        let summary = self.progress.summary.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(summary) = summary {
            self.attempt(|deck| deck.put(Item::Summary(summary)));
        }
        self.attempt(Deck::finish);
    }

    /// Do it, unless the recording has failed before; if it fails now, that is said once, and robots go on.
    fn attempt(&mut self, work: impl FnOnce(&mut Deck) -> Result<(), mcap::McapError>) {
        let mut failed = self.progress.failed.lock().unwrap_or_else(PoisonError::into_inner);
        if failed.is_some() {
            self.progress.dropped.fetch_add(1, Ordering::Relaxed);
            return;
        }
        drop(failed);
        let outcome = work(&mut self.deck);
        self.progress.bytes.store(self.deck.len(), Ordering::Relaxed);
        if let Err(error) = outcome {
            let why = format!(
                "{}: {error}; the recording has ended, the robots go on; make room, or set record_dir to another disk",
                self.name
            );
            tracing::error!("{why}");
            failed = self.progress.failed.lock().unwrap_or_else(PoisonError::into_inner);
            *failed = Some(why);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
