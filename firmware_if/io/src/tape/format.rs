//! Taped entries in the formats that everybody's tools read.
//!
//! * CAN buses as candump logs: `(sec.usec) interface id#data R`, the last letter being the direction (`candump -L -x`;
//!   R received, T transmitted). can-utils, Wireshark and python-can read them.
//! * Datagrams as tlogs: before each MAVLink frame, the time in microseconds as a big-endian u64. pymavlink, MAVProxy
//!   and QGroundControl read them. Bytes that are no MAVLink frame are left out and counted, because a tlog cannot
//!   carry them.

use super::{TapeEntry, TapeEvent, TapePort, frame_of};
use drover_contract::{CanFrame, Stamp};
use std::collections::BTreeMap;

/// Files being written, one a link.
#[derive(Default)]
pub struct WireFiles {
    files: BTreeMap<String, Vec<u8>>,
    unix_offset_us: u64,
    left_out: u64,
}

impl WireFiles {
    /// No files yet; `unix_offset_us` leads from the robots' clock to the calendar, microseconds.
    #[must_use]
    pub fn new(unix_offset_us: u64) -> Self {
        Self { unix_offset_us, ..Self::default() }
    }

    /// Write what crossed one of robot `robot`'s links; what else happened is passed over.
    pub fn add(&mut self, robot: u32, entry: &TapeEntry) {
        let (port, bytes, letter) = match &entry.event {
            TapeEvent::Received(port, bytes) => (*port, bytes, 'R'),
            TapeEvent::Sent(port, bytes) => (*port, bytes, 'T'),
            TapeEvent::Turn | TapeEvent::Clock | TapeEvent::ToldToEnd(_) => return,
        };
        let unix_us = Stamp::from_micros(entry.stamp.as_micros().saturating_add(self.unix_offset_us)).as_micros();
        let (stem, datagrams) = match port {
            TapePort::Autopilot => (format!("robot-{robot}"), true),
            TapePort::Beacons => (format!("robot-{robot}-beacons"), true),
            TapePort::DriveBus => (format!("robot-{robot}-drive"), false),
            TapePort::LidarBus => (format!("robot-{robot}-lidar"), false),
        };
        if datagrams {
            let file = self.files.entry(format!("{stem}.tlog")).or_default();
            self.left_out += u64::from(append_tlog(file, unix_us, bytes));
        } else if let Some(frame) = frame_of(bytes) {
            let file = self.files.entry(format!("{stem}.log")).or_default();
            file.extend_from_slice(candump_line(unix_us, &stem, &frame, letter).as_bytes());
        } else {
            self.left_out += 1;
        }
    }

    /// Messages that could not be written in their format.
    #[must_use]
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// File name to bytes.
    #[must_use]
    pub fn into_files(self) -> BTreeMap<String, Vec<u8>> {
        self.files
    }
}

fn candump_line(unix_us: u64, interface: &str, frame: &CanFrame, letter: char) -> String {
    format!("({:010}.{:06}) {interface} {frame} {letter}\n", unix_us / 1_000_000, unix_us % 1_000_000)
}

/// Append a datagram's MAVLink frames; whether bytes were left out. Each frame needs its own time: a reader takes the
/// eight bytes before each frame for one.
fn append_tlog(file: &mut Vec<u8>, unix_us: u64, datagram: &[u8]) -> bool {
    let mut rest = datagram;
    while let Some((frame, after)) = frame_len(rest).and_then(|len| rest.split_at_checked(len)) {
        file.extend_from_slice(&unix_us.to_be_bytes());
        file.extend_from_slice(frame);
        rest = after;
    }
    !rest.is_empty()
}

/// Length of the MAVLink frame that begins `bytes` (mavlink.io, "Packet Serialization"): start, payload length, and in
/// version 2 the incompatibility flags, of which bit 0 says that a signature follows.
fn frame_len(bytes: &[u8]) -> Option<usize> {
    const START_V1: u8 = 0xFE;
    const START_V2: u8 = 0xFD;
    const SIGNATURE_LEN: usize = 13;
    match *bytes {
        [START_V1, len, ..] => Some(8 + usize::from(len)),
        [START_V2, len, flags, ..] => Some(12 + usize::from(len) + if flags & 1 == 1 { SIGNATURE_LEN } else { 0 }),
        _ => None,
    }
}
