//! A robot's tape: everything that its loop was given and everything that it sent, in order. Nothing waits for a disk.
//!
//! The order is the point: fed to the same loop again, turn by turn, a tape must lead to the same bytes. So it holds
//! when each turn of the loop began, what was read and sent in it and over which port, and what else the loop was told.
//! Links are taped by [`Tape::link`] and [`Tape::bus`] around them; only what was sent is taped, so that a tape never
//! shows a command that did not leave.
//!
//! A tape hands its entries on in batches, to whatever keeps them ([`TapeSink`]): a file, or memory in virtual time.
//! [`WireFiles`] writes entries in the formats that everybody's tools read.

mod format;
mod memory;

use drover_contract::{BusHealth, CanBus, CanFrame, CanId, Link, LinkError, Stamp};
pub use format::WireFiles;
pub use memory::MemoryTapes;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

/// Entries are handed on when the oldest of them is this old: what a crash can cost, at most.
const BATCH: Duration = Duration::from_millis(200);
/// Or when there are this many: a flood must not fill the memory.
const BATCH_ENTRIES: usize = 4096;
/// In a taped CAN frame's first four bytes (as in SocketCAN's `can_id`): the identifier has 29 bits.
const EXTENDED: u32 = 0x8000_0000;

/// Which way out of a robot's computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum TapePort {
    /// The MAVLink link to an autopilot: datagrams.
    Autopilot = 0,
    /// The chassis' CAN bus.
    DriveBus = 1,
    /// The lidar's CAN bus.
    LidarBus = 2,
    /// The beacon plane: datagrams.
    Beacons = 3,
}

impl TapePort {
    /// The port that was written as this number.
    #[must_use]
    pub const fn of(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Autopilot),
            1 => Some(Self::DriveBus),
            2 => Some(Self::LidarBus),
            3 => Some(Self::Beacons),
            _ => None,
        }
    }
}

/// One thing that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TapeEvent {
    /// A turn of the loop began.
    Turn,
    /// The loop looked at its clock again within the turn: the entry's stamp is what it saw.
    Clock,
    /// The loop was told to stop and end, and why.
    ToldToEnd(String),
    /// A datagram, or a CAN frame as [`frame_bytes`] writes it, was read.
    Received(TapePort, Vec<u8>),
    /// One was sent.
    Sent(TapePort, Vec<u8>),
}

/// One thing that happened, and when, on the robot's clock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TapeEntry {
    /// When.
    pub stamp: Stamp,
    /// What.
    pub event: TapeEvent,
}

/// Keeps what tapes hand on. It must not block the caller, unless the caller's time is virtual.
pub trait TapeSink: Send + Sync {
    /// Take a batch of robot `robot`'s entries, in order.
    fn take(&self, robot: u32, entries: Vec<TapeEntry>);
}

/// One robot's tape. Clones write on the same one.
#[derive(Clone)]
pub struct Tape(Arc<Reel>);

struct Reel {
    robot: u32,
    sink: Arc<dyn TapeSink>,
    held: Mutex<Held>,
}

#[derive(Default)]
struct Held {
    /// When the current turn began: the time of all that happens in it.
    now: Stamp,
    entries: Vec<TapeEntry>,
}

impl Tape {
    /// An empty tape of robot `robot`, whose entries go to `sink`.
    #[must_use]
    pub fn new(robot: u32, sink: Arc<dyn TapeSink>) -> Self {
        Self(Arc::new(Reel { robot, sink, held: Mutex::default() }))
    }

    /// A turn of the loop begins.
    pub fn turn(&self, now: Stamp) {
        let mut held = self.0.lock();
        let oldest = held.entries.first().map(|entry| entry.stamp);
        let full = held.entries.len() >= BATCH_ENTRIES || oldest.is_some_and(|oldest| now.since(oldest) >= BATCH);
        let batch = if full { std::mem::take(&mut held.entries) } else { Vec::new() };
        held.now = now;
        held.entries.push(TapeEntry { stamp: now, event: TapeEvent::Turn });
        drop(held);
        if full {
            self.0.sink.take(self.0.robot, batch);
        }
    }

    /// The loop has looked at its clock again, and seen `now`.
    pub fn clock(&self, now: Stamp) {
        self.0.lock().entries.push(TapeEntry { stamp: now, event: TapeEvent::Clock });
    }

    /// The loop is told to end.
    pub fn told_to_end(&self, now: Stamp, why: String) {
        self.0.lock().entries.push(TapeEntry { stamp: now, event: TapeEvent::ToldToEnd(why) });
    }

    /// Tape `link`.
    pub fn link<L: Link>(&self, port: TapePort, link: L) -> Taped<L> {
        Taped { inner: link, port, tape: self.clone() }
    }

    /// Tape `bus`.
    pub fn bus<B: CanBus>(&self, port: TapePort, bus: B) -> Taped<B> {
        Taped { inner: bus, port, tape: self.clone() }
    }

    /// Hand on what is held.
    pub fn flush(&self) {
        let batch = std::mem::take(&mut self.0.lock().entries);
        if !batch.is_empty() {
            self.0.sink.take(self.0.robot, batch);
        }
    }

    fn put(&self, event: TapeEvent) {
        let mut held = self.0.lock();
        let stamp = held.now;
        held.entries.push(TapeEntry { stamp, event });
    }
}

impl Reel {
    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Reel {
    fn drop(&mut self) {
        let batch = std::mem::take(&mut self.lock().entries);
        if !batch.is_empty() {
            self.sink.take(self.robot, batch);
        }
    }
}

/// A link that is taped.
pub struct Taped<L> {
    inner: L,
    port: TapePort,
    tape: Tape,
}

impl<L: Link> Link for Taped<L> {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        let received = self.inner.try_recv(buf)?;
        if let Some(datagram) = received.and_then(|len| buf.get(..len)) {
            self.tape.put(TapeEvent::Received(self.port, datagram.to_vec()));
        }
        Ok(received)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.inner.send(bytes)?;
        self.tape.put(TapeEvent::Sent(self.port, bytes.to_vec()));
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }
}

impl<B: CanBus> CanBus for Taped<B> {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        let received = self.inner.try_recv()?;
        if let Some(frame) = &received {
            self.tape.put(TapeEvent::Received(self.port, frame_bytes(frame)));
        }
        Ok(received)
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        self.inner.send(frame)?;
        self.tape.put(TapeEvent::Sent(self.port, frame_bytes(frame)));
        Ok(())
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.inner.poll_readable(cx)
    }

    fn health(&self) -> BusHealth {
        self.inner.health()
    }
}

/// A CAN frame as bytes: SocketCAN's `can_id` (little-endian, bit 31 set for 29 bits), then its data.
#[must_use]
pub fn frame_bytes(frame: &CanFrame) -> Vec<u8> {
    let id = match frame.id() {
        CanId::Standard(raw) => u32::from(raw),
        CanId::Extended(raw) => raw | EXTENDED,
    };
    let mut bytes = Vec::with_capacity(4 + frame.data().len());
    bytes.extend_from_slice(&id.to_le_bytes());
    bytes.extend_from_slice(frame.data());
    bytes
}

/// The frame that [`frame_bytes`] wrote; `None` for bytes that are none.
#[must_use]
pub fn frame_of(bytes: &[u8]) -> Option<CanFrame> {
    let (id, data) = bytes.split_first_chunk::<4>()?;
    let id = u32::from_le_bytes(*id);
    let id = if id & EXTENDED == 0 { CanId::Standard(u16::try_from(id).ok()?) } else { CanId::Extended(id ^ EXTENDED) };
    CanFrame::new(id, data).ok()
}

#[cfg(test)]
mod tests;
