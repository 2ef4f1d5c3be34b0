//! Frames in and out of datagrams.
//!
//! A datagram may hold several frames, garbage between them and a cut one at its end. Layout of a MAVLink 2 frame:
//! `FD len incompat compat seq system component id[3] payload[len] crc[2] (signature[13])`, of a MAVLink 1 frame:
//! `FE len seq system component id payload[len] crc[2]`. The CRC runs over everything behind the first byte and one
//! more byte that each message's definition fixes.

use drover_contract::MavId;
use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message, calculate_crc};

const START_V1: u8 = 0xFE;
const START_V2: u8 = 0xFD;
const HEADER_V1: usize = 6;
const HEADER_V2: usize = 10;
const CRC: usize = 2;
const PAYLOAD_MAX: usize = 255;
const SIGNATURE: usize = 13;
/// The one flag that may change a frame's layout and is understood here: a signature follows (it is not checked).
const FLAG_SIGNED: u8 = 0x01;
/// No more of a datagram is looked at: searching garbage costs time in proportion.
const DATAGRAM_BYTES_MAX: usize = 4096;

/// A frame whose checksum is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frame<'a> {
    /// Who sent it.
    pub(crate) from: MavId,
    /// The message's id.
    pub(crate) message: u32,
    /// The payload, without the zeros that the sender cut off its end.
    pub(crate) payload: &'a [u8],
}

/// Bytes that are no frame for us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skipped {
    /// Bytes before a frame's start.
    Noise,
    /// A wrong checksum, or a layout flag that is not understood.
    Broken,
    /// A frame cut off by the datagram's end.
    Truncated,
    /// A message that the dialect does not know.
    Unknown,
}

/// How the bytes of a link were received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireCounters {
    /// Datagrams.
    pub datagrams: u64,
    /// Frames with a right checksum.
    pub frames: u64,
    /// Runs of bytes between frames.
    pub noise: u64,
    /// Wrong checksums and layouts.
    pub broken: u64,
    /// Frames cut off by the end of their datagram.
    pub truncated: u64,
    /// Frames of messages that the common dialect does not know.
    pub unknown: u64,
}

impl WireCounters {
    pub(crate) fn skip(&mut self, skipped: Skipped) {
        match skipped {
            Skipped::Noise => self.noise += 1,
            Skipped::Broken => self.broken += 1,
            Skipped::Truncated => self.truncated += 1,
            Skipped::Unknown => self.unknown += 1,
        }
    }
}

/// The frames of one datagram. Every step consumes at least a byte.
pub(crate) struct Frames<'a> {
    rest: &'a [u8],
    extra_crc: fn(u32) -> Option<u8>,
}

/// The frames of `datagram` whose messages the common dialect knows.
pub(crate) fn frames(datagram: &[u8]) -> Frames<'_> {
    frames_of(datagram, common_extra_crc)
}

/// The frames of `datagram` whose messages a dialect knows: `extra_crc` says its byte for a message id.
pub(crate) fn frames_of(datagram: &[u8], extra_crc: fn(u32) -> Option<u8>) -> Frames<'_> {
    Frames { rest: &datagram[..datagram.len().min(DATAGRAM_BYTES_MAX)], extra_crc }
}

fn common_extra_crc(message: u32) -> Option<u8> {
    MavMessage::default_message_from_id(message).map(|_| MavMessage::extra_crc(message))
}

impl<'a> Iterator for Frames<'a> {
    type Item = Result<Frame<'a>, Skipped>;

    fn next(&mut self) -> Option<Self::Item> {
        let start = self.rest.iter().position(|byte| matches!(*byte, START_V1 | START_V2));
        let noise = start.unwrap_or(self.rest.len());
        if noise > 0 {
            self.rest = &self.rest[noise..];
            return Some(Err(Skipped::Noise));
        }
        if self.rest.is_empty() {
            return None;
        }
        let (found, length) = parse(self.rest, self.extra_crc);
        self.rest = &self.rest[length..];
        Some(found)
    }
}

/// The frame at the start of `bytes`, and how many bytes it takes: one if what stands there is no frame, so that the
/// search goes on behind its first byte.
fn parse(bytes: &[u8], extra_crc: fn(u32) -> Option<u8>) -> (Result<Frame<'_>, Skipped>, usize) {
    let Some(layout) = Layout::read(bytes) else { return (Err(Skipped::Truncated), 1) };
    if layout.flags & !FLAG_SIGNED != 0 {
        return (Err(Skipped::Broken), 1);
    }
    let total = layout.total();
    if bytes.len() < total {
        return (Err(Skipped::Truncated), 1);
    }
    let Some(extra_crc) = extra_crc(layout.message) else {
        // Its checksum cannot be known. It is believed to be a frame if something sensible follows it.
        let framed = bytes.get(total).is_none_or(|next| matches!(*next, START_V1 | START_V2));
        return (Err(Skipped::Unknown), if framed { total } else { 1 });
    };
    let end = layout.header + layout.payload;
    let crc = calculate_crc(&bytes[1..end], extra_crc);
    if bytes[end..end + CRC] != crc.to_le_bytes() {
        return (Err(Skipped::Broken), 1);
    }
    let payload = &bytes[layout.header..end];
    (Ok(Frame { from: layout.from, message: layout.message, payload }), total)
}

/// What a frame's header says.
struct Layout {
    header: usize,
    payload: usize,
    flags: u8,
    from: MavId,
    message: u32,
}

impl Layout {
    fn read(bytes: &[u8]) -> Option<Self> {
        if *bytes.first()? == START_V1 {
            let head = bytes.get(..HEADER_V1)?;
            let from = MavId { system: head[3], component: head[4] };
            let message = u32::from(head[5]);
            return Some(Self { header: HEADER_V1, payload: usize::from(head[1]), flags: 0, from, message });
        }
        let head = bytes.get(..HEADER_V2)?;
        let from = MavId { system: head[5], component: head[6] };
        let message = u32::from_le_bytes([head[7], head[8], head[9], 0]);
        Some(Self { header: HEADER_V2, payload: usize::from(head[1]), flags: head[2], from, message })
    }

    fn total(&self) -> usize {
        let signature = if self.flags & FLAG_SIGNED != 0 { SIGNATURE } else { 0 };
        self.header + self.payload + CRC + signature
    }
}

/// One component that sends on one link: it counts its own frames, as receivers do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emitter {
    from: MavId,
    sequence: u8,
}

impl Emitter {
    pub(crate) const fn new(from: MavId) -> Self {
        Self::starting_at(from, 0)
    }

    pub(crate) const fn starting_at(from: MavId, sequence: u8) -> Self {
        Self { from, sequence }
    }

    /// The next frame of this component, MAVLink 2, unsigned.
    pub(crate) fn encode(&mut self, message: &MavMessage) -> Vec<u8> {
        let mut payload = [0; PAYLOAD_MAX];
        let length = message.ser(MavlinkVersion::V2, &mut payload);
        let id = message.message_id();
        self.encode_raw(id, MavMessage::extra_crc(id), &payload[..length])
    }

    /// The same for a payload that is serialised already; `extra_crc` is the byte that the message's definition fixes.
    pub(crate) fn encode_raw(&mut self, message: u32, extra_crc: u8, payload: &[u8]) -> Vec<u8> {
        let payload = trimmed(payload);
        let [low, middle, high, _] = message.to_le_bytes();
        let mut frame = Vec::with_capacity(HEADER_V2 + payload.len() + CRC);
        frame.extend_from_slice(&[START_V2, payload.len() as u8, 0, 0, self.sequence]);
        frame.extend_from_slice(&[self.from.system, self.from.component, low, middle, high]);
        frame.extend_from_slice(payload);
        let crc = calculate_crc(&frame[1..], extra_crc);
        frame.extend_from_slice(&crc.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
        frame
    }
}

/// `payload` as it goes out: at most 255 bytes, zeros cut off its end, but never its first byte.
fn trimmed(payload: &[u8]) -> &[u8] {
    let payload = &payload[..payload.len().min(PAYLOAD_MAX)];
    let end = payload.iter().rposition(|byte| *byte != 0).map_or(1, |last| last + 1);
    &payload[..end.min(payload.len())]
}
