//! Tapes kept in memory: for virtual time.

use super::{TapeEntry, TapeEvent, TapeSink, WireFiles};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Most bytes that are kept.
const BYTES_MAX: usize = 1 << 30;

/// All tapes of a run, in memory.
#[derive(Default)]
pub struct MemoryTapes {
    held: Mutex<Held>,
    dropped: AtomicU64,
}

#[derive(Default)]
struct Held {
    entries: Vec<(u32, Vec<TapeEntry>)>,
    bytes: usize,
}

impl MemoryTapes {
    /// Everything that crossed the links, as files of their own formats: file name to bytes. Tapes that are still in
    /// use hold back their newest entries until [`super::Tape::flush`].
    #[must_use]
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let mut files = WireFiles::new(0);
        let held = self.lock();
        for (robot, entries) in &held.entries {
            entries.iter().for_each(|entry| files.add(*robot, entry));
        }
        files.into_files()
    }

    /// Entries for which there was no room.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl TapeSink for MemoryTapes {
    fn take(&self, robot: u32, entries: Vec<TapeEntry>) {
        let bytes: usize = entries.iter().map(bytes_of).sum();
        let mut held = self.lock();
        if held.bytes + bytes > BYTES_MAX {
            self.dropped.fetch_add(entries.len() as u64, Ordering::Relaxed);
            return;
        }
        held.bytes += bytes;
        held.entries.push((robot, entries));
    }
}

fn bytes_of(entry: &TapeEntry) -> usize {
    let heap = match &entry.event {
        TapeEvent::Turn | TapeEvent::Clock => 0,
        TapeEvent::ToldToEnd(why) => why.len(),
        TapeEvent::Received(_, bytes) | TapeEvent::Sent(_, bytes) => bytes.len(),
    };
    size_of::<TapeEntry>() + heap
}
