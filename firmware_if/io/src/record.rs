//! A recorder around any link: everything that crosses it is written down, and nothing waits for the disk.
//!
//! * CAN buses as candump logs: `(sec.usec) interface id#data R`, the last letter being the direction (`candump -L -x`;
//!   R received, T transmitted). can-utils and python-can read them.
//! * MAVLink links as tlogs: before each frame, the time in microseconds as a big-endian u64. pymavlink, MAVProxy and
//!   QGroundControl read them. Bytes that are no MAVLink frame are left out and counted as dropped, because a tlog
//!   cannot carry them.
//!
//! Times come from the robot's clock plus a fixed offset to the calendar, so that a step of the calendar clock does not
//! tear a recording, and so that virtual time gives the same bytes twice.

mod format;
mod sink;

use crate::OpenError;
use drover_contract::{BusHealth, CanBus, CanFrame, Clock, Link, LinkError};
use format::{Direction, candump_line, tlog_entries};
use sink::{FileSink, MemorySink, Sink};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::task::{Context, Poll};

/// Where recordings go. Clones write to the same place; the last one to be dropped, with the links around which it
/// stands, writes out what is left.
#[derive(Clone)]
pub struct Recorder {
    sink: Arc<dyn Sink>,
    unix_offset_us: u64,
}

impl Recorder {
    /// Record into memory, at once and in order: for virtual time. At most 1 GiB in all; more is dropped and counted.
    #[must_use]
    pub fn in_memory() -> Self {
        Self { sink: Arc::new(MemorySink::default()), unix_offset_us: 0 }
    }

    /// Record into files in `folder`, which must be there. A thread of its own writes; what it cannot keep up with is
    /// dropped and counted. `unix_offset_us` is added to every time: see [`crate::OsClock::unix_offset_us`].
    ///
    /// # Errors
    /// [`OpenError`] if the folder is none or the system refuses a thread.
    pub fn in_folder(folder: &Path, unix_offset_us: u64) -> Result<Self, OpenError> {
        let sink = FileSink::start(folder).map_err(|error| {
            let name = folder.display().to_string();
            OpenError::new(name, format!("cannot record there: {error}"), "set record_dir to a folder you can write")
        })?;
        Ok(Self { sink: Arc::new(sink), unix_offset_us })
    }

    /// Record `bus` to the file `NAME.log`; `name` also stands in it as the interface.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be made.
    pub fn can<B: CanBus>(
        &self,
        name: &str,
        bus: B,
        clock: impl Clock + Send + Sync + 'static,
    ) -> Result<Recorded<B>, OpenError> {
        self.around(bus, Track { name: name.to_owned(), file: format!("{name}.log").into() }, Arc::new(clock))
    }

    /// Record `link` to the file `NAME.tlog`.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be made.
    pub fn link<L: Link>(
        &self,
        name: &str,
        link: L,
        clock: impl Clock + Send + Sync + 'static,
    ) -> Result<Recorded<L>, OpenError> {
        self.around(link, Track { name: name.to_owned(), file: format!("{name}.tlog").into() }, Arc::new(clock))
    }

    /// Everything recorded into memory so far, file by file; empty when recording into a folder.
    #[must_use]
    pub fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        self.sink.contents()
    }

    /// Messages that could not be recorded.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.sink.dropped()
    }

    fn around<L>(&self, inner: L, track: Track, clock: SharedClock) -> Result<Recorded<L>, OpenError> {
        self.sink.create(&track.file).map_err(|error| {
            OpenError::new(
                &*track.file,
                format!("cannot record there: {error}"),
                "see record_dir, and the disk's space",
            )
        })?;
        Ok(Recorded { inner, recorder: self.clone(), track, clock })
    }
}

type SharedClock = Arc<dyn Clock + Send + Sync>;

struct Track {
    name: String,
    file: Arc<str>,
}

/// A link that is recorded.
pub struct Recorded<L> {
    inner: L,
    recorder: Recorder,
    track: Track,
    clock: SharedClock,
}

impl<L> Recorded<L> {
    fn now_us(&self) -> u64 {
        self.clock.now().as_micros().saturating_add(self.recorder.unix_offset_us)
    }

    fn record_frame(&self, frame: &CanFrame, direction: Direction) {
        let line = candump_line(self.now_us(), &self.track.name, frame, direction);
        self.recorder.sink.append(&self.track.file, line.into_bytes());
    }

    fn record_datagram(&self, datagram: &[u8]) {
        let (entries, left_out) = tlog_entries(self.now_us(), datagram);
        if !entries.is_empty() {
            self.recorder.sink.append(&self.track.file, entries);
        }
        if left_out {
            self.recorder.sink.count_dropped();
        }
    }
}

impl<L: Link> Link for Recorded<L> {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        let received = self.inner.try_recv(buf)?;
        if let Some(datagram) = received.and_then(|len| buf.get(..len)) {
            self.record_datagram(datagram);
        }
        Ok(received)
    }

    /// Only what was sent is recorded: a recording never shows a command that did not leave.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.inner.send(bytes)?;
        self.record_datagram(bytes);
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }
}

impl<B: CanBus> CanBus for Recorded<B> {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        let received = self.inner.try_recv()?;
        if let Some(frame) = &received {
            self.record_frame(frame, Direction::Received);
        }
        Ok(received)
    }

    /// Only what was sent is recorded: a recording never shows a command that did not leave.
    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        self.inner.send(frame)?;
        self.record_frame(frame, Direction::Sent);
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }

    fn health(&self) -> BusHealth {
        self.inner.health()
    }
}

#[cfg(test)]
mod tests;
