//! Frames back into transfers, within bounds: so many sessions, so many bytes, so much time.
//!
//! A session is one stream of transfers: one identifier (but for its priority). Whatever does not fit (a frame that
//! does not start anything, a wrong toggle, another transfer id, a CRC that fails) ends the transfer under way and is
//! counted; the next start frame begins anew.

use super::FrameId;
use super::transfer::{BYTES_PER_FRAME, TRANSFER_MAX, Tail, transfer_crc};
use drover_contract::{CanFrame, Stamp};
use std::collections::BTreeMap;
use std::time::Duration;

/// A transfer not complete within this is given up, and a transfer id may come again after it (DroneCAN: 2 s).
const SESSION_TIMEOUT: Duration = Duration::from_secs(2);

/// A complete transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Who sent what.
    pub id: FrameId,
    /// Its number, 0..=31; a service's answer repeats it.
    pub transfer_id: u8,
    /// Its bytes, CRC checked and taken off.
    pub payload: Vec<u8>,
}

/// What a reassembler has met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReassemblyCounters {
    /// Complete transfers.
    pub transfers: u64,
    /// Frames that are not DroneCAN, or of types nobody asked for.
    pub foreign: u64,
    /// Frames without a tail byte, or anonymous ones that want several frames.
    pub malformed: u64,
    /// Transfers whose CRC failed.
    pub crc_errors: u64,
    /// Frames with the wrong toggle or another transfer id than the transfer under way.
    pub out_of_order: u64,
    /// Frames that continue a transfer whose start was not seen.
    pub missed_starts: u64,
    /// Transfers that came twice.
    pub duplicates: u64,
    /// Transfers that did not end: timed out, overtaken by a new start, or put out by newer sessions.
    pub unfinished: u64,
    /// Transfers longer than [`TRANSFER_MAX`].
    pub too_long: u64,
}

impl ReassemblyCounters {
    /// Transfers that were lost on the way, as far as one can see.
    #[must_use]
    pub fn broken(&self) -> u64 {
        self.malformed + self.crc_errors + self.out_of_order + self.missed_starts + self.unfinished + self.too_long
    }
}

#[derive(Clone, Debug, Default)]
struct Session {
    touched: Stamp,
    partial: Option<Partial>,
    last_done: Option<(Stamp, u8)>,
}

/// A transfer under way.
#[derive(Clone, Debug)]
struct Partial {
    started: Stamp,
    transfer_id: u8,
    toggle_next: bool,
    duplicate: bool, // followed to its end all the same, or its rest would look like missed starts
    bytes: Vec<u8>,  // the CRC first
}

/// Frames in, transfers out.
#[derive(Clone, Debug)]
pub struct Reassembler {
    sessions: BTreeMap<FrameId, Session>,
    sessions_max: usize,
    counters: ReassemblyCounters,
}

impl Reassembler {
    /// One that follows at most `sessions_max` streams at a time (at least one): the longest quiet gives way.
    #[must_use]
    pub fn new(sessions_max: usize) -> Self {
        let counters = ReassemblyCounters::default();
        Self { sessions: BTreeMap::new(), sessions_max: sessions_max.max(1), counters }
    }

    /// Take a frame; the transfer if it completes one. `signature_of` says which types are wanted, by their signature;
    /// all others leave no trace but a count.
    pub fn accept(
        &mut self,
        now: Stamp,
        frame: &CanFrame,
        signature_of: impl Fn(&FrameId) -> Option<u64>,
    ) -> Option<Transfer> {
        let wanted = FrameId::parse(frame.id()).and_then(|id| signature_of(&id).map(|signature| (id, signature)));
        let Some((id, signature)) = wanted else {
            self.counters.foreign += 1;
            return None;
        };
        let Some((tail, chunk)) = frame.data().split_last() else {
            self.counters.malformed += 1;
            return None;
        };
        let tail = Tail::parse(*tail);
        let payload = match id {
            FrameId::Anonymous { .. } => self.accept_anonymous(tail, chunk),
            FrameId::Message { .. } | FrameId::Service { .. } => {
                self.accept_in_session(now, id, signature, (tail, chunk))
            }
        }?;
        self.counters.transfers += 1;
        Some(Transfer { id, transfer_id: tail.transfer_id, payload })
    }

    /// What was met so far.
    #[must_use]
    pub fn counters(&self) -> ReassemblyCounters {
        self.counters
    }

    /// How many streams are followed now.
    #[must_use]
    pub fn sessions(&self) -> usize {
        self.sessions.len()
    }

    /// A node without an id has no sessions: its transfers are one frame each.
    fn accept_anonymous(&mut self, tail: Tail, chunk: &[u8]) -> Option<Vec<u8>> {
        let single = tail.start && tail.end && !tail.toggle;
        if !single {
            self.counters.malformed += 1;
        }
        single.then(|| chunk.to_vec())
    }

    fn accept_in_session(
        &mut self,
        now: Stamp,
        id: FrameId,
        signature: u64,
        (tail, chunk): (Tail, &[u8]),
    ) -> Option<Vec<u8>> {
        let key = id.without_priority();
        self.make_room(key);
        let session = self.sessions.entry(key).or_default();
        session.touched = now;
        let payload = session.accept(now, signature, (tail, chunk), &mut self.counters)?;
        session.last_done = Some((now, tail.transfer_id));
        Some(payload)
    }

    fn make_room(&mut self, key: FrameId) {
        if self.sessions.len() < self.sessions_max || self.sessions.contains_key(&key) {
            return;
        }
        let quietest = self.sessions.iter().min_by_key(|(_, session)| session.touched).map(|(key, _)| *key);
        let gone = quietest.and_then(|key| self.sessions.remove(&key));
        self.counters.unfinished += u64::from(gone.is_some_and(|session| session.partial.is_some()));
    }
}

impl Session {
    fn accept(
        &mut self,
        now: Stamp,
        signature: u64,
        (tail, chunk): (Tail, &[u8]),
        counters: &mut ReassemblyCounters,
    ) -> Option<Vec<u8>> {
        if self.partial.as_ref().is_some_and(|partial| now.since(partial.started) > SESSION_TIMEOUT) {
            self.partial = None;
            counters.unfinished += 1;
        }
        if tail.start {
            return self.start(now, (tail, chunk), counters);
        }
        let Some(mut partial) = self.partial.take() else {
            counters.missed_starts += 1;
            return None;
        };
        if tail.toggle != partial.toggle_next || tail.transfer_id != partial.transfer_id {
            counters.out_of_order += 1;
            return None;
        }
        if partial.bytes.len() + chunk.len() > TRANSFER_MAX + 2 {
            counters.too_long += 1;
            return None;
        }
        partial.bytes.extend_from_slice(chunk);
        partial.toggle_next = !partial.toggle_next;
        if !tail.end {
            self.partial = Some(partial);
            return None;
        }
        if partial.duplicate {
            counters.duplicates += 1;
            return None;
        }
        finish(&partial.bytes, signature, counters)
    }

    fn start(
        &mut self,
        now: Stamp,
        (tail, chunk): (Tail, &[u8]),
        counters: &mut ReassemblyCounters,
    ) -> Option<Vec<u8>> {
        let again = |(then, id): (Stamp, u8)| id == tail.transfer_id && now.since(then) <= SESSION_TIMEOUT;
        counters.unfinished += u64::from(self.partial.take().is_some());
        if tail.toggle {
            counters.out_of_order += 1; // only version 1 of the protocol starts so
            return None;
        }
        let duplicate = self.last_done.is_some_and(again);
        if tail.end {
            counters.duplicates += u64::from(duplicate);
            return (!duplicate).then(|| chunk.to_vec());
        }
        if chunk.len() < BYTES_PER_FRAME {
            counters.malformed += 1; // only a last frame may be short
            return None;
        }
        let (bytes, transfer_id) = (chunk.to_vec(), tail.transfer_id);
        self.partial = Some(Partial { started: now, transfer_id, toggle_next: true, duplicate, bytes });
        None
    }
}

/// The payload of a complete transfer of several frames.
fn finish(bytes: &[u8], signature: u64, counters: &mut ReassemblyCounters) -> Option<Vec<u8>> {
    let (crc, payload) = bytes.split_first_chunk::<2>()?;
    if transfer_crc(signature, payload) != u16::from_le_bytes(*crc) {
        counters.crc_errors += 1;
        return None;
    }
    Some(payload.to_vec())
}
