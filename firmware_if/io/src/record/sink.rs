//! What stands behind a recorder: memory, or files that a thread of its own writes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Most bytes that are kept in memory.
const MEMORY_BYTES_MAX: usize = 1 << 30;
/// Messages that wait for the disk: some seconds of a hundred robots.
const QUEUE: usize = 16_384;
/// How often the thread looks for messages. It is not woken by each: that costs its robots a switch of threads a frame.
const LOOK_PERIOD: Duration = Duration::from_millis(50);
/// How much a crash can cost.
const FLUSH_PERIOD: Duration = Duration::from_secs(1);

/// Takes recordings, at once, whatever becomes of them.
pub(super) trait Sink: Send + Sync {
    /// Begin the file `name`.
    fn create(&self, name: &str) -> io::Result<()>;
    /// Write `bytes` at the end of the file `name`, or drop and count them.
    fn append(&self, name: &Arc<str>, bytes: Vec<u8>);
    fn contents(&self) -> BTreeMap<String, Vec<u8>>;
    fn dropped(&self) -> u64;
    fn count_dropped(&self);
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Default)]
pub(super) struct MemorySink {
    memory: Mutex<Memory>,
    dropped: AtomicU64,
}

#[derive(Default)]
struct Memory {
    files: BTreeMap<String, Vec<u8>>,
    /// In all files together.
    bytes: usize,
}

impl Sink for MemorySink {
    fn create(&self, name: &str) -> io::Result<()> {
        lock(&self.memory).files.entry(name.to_owned()).or_default();
        Ok(())
    }

    fn append(&self, name: &Arc<str>, bytes: Vec<u8>) {
        let mut memory = lock(&self.memory);
        let kept = memory.bytes + bytes.len();
        match memory.files.get_mut(&**name) {
            Some(file) if kept <= MEMORY_BYTES_MAX => {
                file.extend_from_slice(&bytes);
                memory.bytes = kept;
            }
            Some(_) | None => self.count_dropped(),
        }
    }

    fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        lock(&self.memory).files.clone()
    }

    fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn count_dropped(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }
}

enum Job {
    Create(String, File),
    Append(Arc<str>, Vec<u8>),
}

pub(super) struct FileSink {
    folder: PathBuf,
    /// `None` only while this is being dropped.
    queue: Option<SyncSender<Job>>,
    thread: Option<JoinHandle<()>>,
    dropped: Arc<AtomicU64>,
}

impl FileSink {
    pub(super) fn start(folder: &Path) -> io::Result<Self> {
        if !folder.is_dir() {
            return Err(io::Error::new(io::ErrorKind::NotFound, "there is no such folder"));
        }
        let (queue, jobs) = sync_channel(QUEUE);
        let dropped = Arc::new(AtomicU64::new(0));
        let lost = Arc::clone(&dropped);
        let thread = std::thread::Builder::new().name("recorder".into()).spawn(move || write_all(&jobs, &lost))?;
        Ok(Self { folder: folder.to_owned(), queue: Some(queue), thread: Some(thread), dropped })
    }

    fn put(&self, job: Job) -> bool {
        self.queue.as_ref().is_some_and(|queue| queue.try_send(job).is_ok())
    }
}

impl Sink for FileSink {
    fn create(&self, name: &str) -> io::Result<()> {
        let file = File::create(self.folder.join(name))?;
        if self.put(Job::Create(name.to_owned(), file)) {
            Ok(())
        } else {
            Err(io::Error::other("the recorder is too busy to begin another file"))
        }
    }

    fn append(&self, name: &Arc<str>, bytes: Vec<u8>) {
        if !self.put(Job::Append(Arc::clone(name), bytes)) {
            self.count_dropped();
        }
    }

    fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        BTreeMap::new()
    }

    fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn count_dropped(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }
}

impl Drop for FileSink {
    fn drop(&mut self) {
        drop(self.queue.take());
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // The thread ends when it has written what is queued; it does not panic.
            let _ = thread.join();
        }
    }
}

fn write_all(jobs: &Receiver<Job>, lost: &AtomicU64) {
    let mut files = BTreeMap::new();
    let mut flush_at = Instant::now() + FLUSH_PERIOD;
    loop {
        match jobs.try_recv() {
            Ok(Job::Create(name, file)) => {
                files.insert(name, BufWriter::new(file));
            }
            Ok(Job::Append(name, bytes)) => {
                let written = files.get_mut(&*name).is_some_and(|file| file.write_all(&bytes).is_ok());
                lost.fetch_add(u64::from(!written), Ordering::Relaxed);
            }
            Err(TryRecvError::Empty) => {
                if Instant::now() >= flush_at {
                    flush(&mut files);
                    flush_at = Instant::now() + FLUSH_PERIOD;
                }
                std::thread::park_timeout(LOOK_PERIOD);
            }
            Err(TryRecvError::Disconnected) => return flush(&mut files),
        }
    }
}

fn flush(files: &mut BTreeMap<String, BufWriter<File>>) {
    for (name, file) in files {
        if let Err(error) = file.flush() {
            tracing::warn!(file = name, %error, "a recording could not be written");
        }
    }
}
