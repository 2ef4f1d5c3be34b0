//! The two file formats, as bytes.

use drover_contract::CanFrame;

/// Which way a frame went.
#[derive(Clone, Copy)]
pub(super) enum Direction {
    Received,
    Sent,
}

/// One line of a candump log.
pub(super) fn candump_line(now_us: u64, interface: &str, frame: &CanFrame, direction: Direction) -> String {
    let letter = match direction {
        Direction::Received => 'R',
        Direction::Sent => 'T',
    };
    format!("({:010}.{:06}) {interface} {frame} {letter}\n", now_us / 1_000_000, now_us % 1_000_000)
}

/// The tlog entries of a datagram's MAVLink frames, and whether bytes were left out. Each frame needs its own time: a
/// reader takes the eight bytes before each frame for one.
pub(super) fn tlog_entries(now_us: u64, datagram: &[u8]) -> (Vec<u8>, bool) {
    let mut entries = Vec::with_capacity(datagram.len() + 8);
    let mut rest = datagram;
    while let Some((frame, after)) = frame_len(rest).and_then(|len| rest.split_at_checked(len)) {
        entries.extend_from_slice(&now_us.to_be_bytes());
        entries.extend_from_slice(frame);
        rest = after;
    }
    (entries, !rest.is_empty())
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
