//! A tape's batches, packed: most of a recording is what crossed the links, and there a message is much like the one
//! before it of the same kind.
//!
//! Messages are sorted into groups of one port, direction, length and kind (CAN identifier, MAVLink message id). Within
//! a group each byte is written as its difference to the same byte of the message before, and all first bytes stand
//! together, then all second bytes: what counts up or stands still is then a run of equal bytes, which any compression
//! finds. What every robot hears of one beacon is written once and referred to: [`Shared`].

use crate::foxglove::{Wire, WireGroup};
use drover_contract::Stamp;
use drover_io::{TapeEntry, TapeEvent, TapePort};
use std::collections::{BTreeMap, HashMap, VecDeque};

/// In an entry's mark: what it is in the low three bits, its port above.
const TURN: u8 = 0;
const CLOCK: u8 = 1;
const RECEIVED: u8 = 2;
const SENT: u8 = 3;
const TOLD_TO_END: u8 = 4;
/// Received, and the same bytes as a message before, whose number is the data.
const AGAIN: u8 = 5;
const KIND_BITS: u8 = 3;
const KIND: u8 = (1 << KIND_BITS) - 1;

/// Whether an entry has a time of its own; what is read and sent has its turn's.
const fn has_time(mark: u8) -> bool {
    matches!(mark & KIND, TURN | CLOCK | TOLD_TO_END)
}

/// Messages that are remembered because others may hear them, too.
const SHARED_MAX: usize = 8_192;

/// The newest messages of the beacon plane, numbered in the order in which a file holds them.
#[derive(Default)]
pub(crate) struct Shared {
    numbers: HashMap<Vec<u8>, u64>,
    held: VecDeque<Vec<u8>>,
    /// Number of the oldest that is held.
    first: u64,
}

impl Shared {
    fn number(&self, data: &[u8]) -> Option<u64> {
        self.numbers.get(data).copied()
    }

    fn get(&self, number: u64) -> Option<&Vec<u8>> {
        self.held.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    fn remember(&mut self, data: &[u8]) {
        let next = self.first + self.held.len() as u64;
        self.numbers.insert(data.to_vec(), next);
        self.held.push_back(data.to_vec());
        if self.held.len() > SHARED_MAX
            && let Some(oldest) = self.held.pop_front()
        {
            if self.numbers.get(&oldest) == Some(&self.first) {
                self.numbers.remove(&oldest);
            }
            self.first += 1;
        }
    }
}

/// Pack a batch of robot `robot`'s tape; times count from the first entry's.
pub(crate) fn pack(robot: u32, entries: &[TapeEntry], shared: &mut Shared) -> Wire {
    let mut wire = Wire { robot, ..Wire::default() };
    let mut keys: BTreeMap<(u8, usize, Vec<u8>), usize> = BTreeMap::new();
    let mut groups: Vec<Vec<Vec<u8>>> = Vec::new();
    let mut before_us = entries.first().map_or(0, |entry| entry.stamp.as_micros());
    for entry in entries {
        let (mark, data) = marked(&entry.event, shared);
        wire.marks.push(mark);
        if has_time(mark) {
            let at_us = entry.stamp.as_micros();
            put_varint(&mut wire.gaps_us, at_us.saturating_sub(before_us));
            before_us = before_us.max(at_us);
        }
        let Some(data) = data else { continue };
        let next = groups.len();
        let group = *keys.entry((mark, data.len(), kind_of(mark, &data).to_vec())).or_insert(next);
        if group == next {
            groups.push(Vec::new());
        }
        put_varint(&mut wire.order, group as u64);
        groups[group].push(data);
    }
    wire.groups = groups.iter().map(|messages| planes(messages)).collect();
    wire
}

fn marked(event: &TapeEvent, shared: &mut Shared) -> (u8, Option<Vec<u8>>) {
    let of_port = |kind: u8, port: TapePort| kind | ((port as u8) << KIND_BITS);
    match event {
        TapeEvent::Turn => (TURN, None),
        TapeEvent::Clock => (CLOCK, None),
        TapeEvent::ToldToEnd(why) => (TOLD_TO_END, Some(why.clone().into_bytes())),
        TapeEvent::Received(port @ TapePort::Beacons, data) => match shared.number(data) {
            Some(number) => (of_port(AGAIN, *port), Some(number.to_be_bytes().to_vec())),
            None => {
                shared.remember(data);
                (of_port(RECEIVED, *port), Some(data.clone()))
            }
        },
        TapeEvent::Sent(port @ TapePort::Beacons, data) => {
            shared.remember(data);
            (of_port(SENT, *port), Some(data.clone()))
        }
        TapeEvent::Received(port, data) => (of_port(RECEIVED, *port), Some(data.clone())),
        TapeEvent::Sent(port, data) => (of_port(SENT, *port), Some(data.clone())),
    }
}

/// The bytes that tell kinds of messages apart: a CAN identifier, or a MAVLink 2 message id.
fn kind_of(mark: u8, data: &[u8]) -> &[u8] {
    let bus = [TapePort::DriveBus, TapePort::LidarBus].iter().any(|port| mark >> KIND_BITS == *port as u8);
    let place = if bus { 0..4 } else { 7..10 };
    data.get(place).unwrap_or_default()
}

fn planes(messages: &[Vec<u8>]) -> WireGroup {
    let length = messages.first().map_or(0, Vec::len);
    let mut planes = Vec::with_capacity(length * messages.len());
    for at in 0..length {
        let mut before = 0_u8;
        for message in messages {
            planes.push(message[at].wrapping_sub(before));
            before = message[at];
        }
    }
    WireGroup { length: length as u32, planes }
}

/// The entries that were packed, the first of them at `base_us`; those of another version, or of a batch that is not
/// whole, are left out.
pub(crate) fn unpack(base_us: u64, wire: &Wire, shared: &mut Shared) -> Vec<TapeEntry> {
    let mut groups: Vec<Box<dyn Iterator<Item = Vec<u8>> + '_>> = Vec::new();
    for group in &wire.groups {
        groups.push(Box::new(messages_of(group)));
    }
    let (mut gaps, mut order) = (&wire.gaps_us[..], &wire.order[..]);
    let (mut at_us, mut turn_us) = (base_us, base_us);
    let mut entries = Vec::with_capacity(wire.marks.len());
    for mark in &wire.marks {
        let kind = mark & KIND;
        if has_time(*mark) {
            let Some(gap_us) = take_varint(&mut gaps) else { break };
            at_us = at_us.saturating_add(gap_us);
        }
        if kind == TURN {
            turn_us = at_us;
        }
        let data = if matches!(kind, TURN | CLOCK) {
            Vec::new()
        } else {
            let group = take_varint(&mut order).and_then(|group| usize::try_from(group).ok());
            let Some(data) = group.and_then(|group| groups.get_mut(group)?.next()) else { break };
            data
        };
        if let Some(event) = event_of(kind, mark >> KIND_BITS, data, shared) {
            let us = if has_time(*mark) { at_us } else { turn_us };
            entries.push(TapeEntry { stamp: Stamp::from_micros(us), event });
        }
    }
    entries
}

fn event_of(kind: u8, port: u8, data: Vec<u8>, shared: &mut Shared) -> Option<TapeEvent> {
    let port = TapePort::of(port)?;
    if port == TapePort::Beacons && matches!(kind, RECEIVED | SENT) {
        shared.remember(&data);
    }
    Some(match kind {
        TURN => TapeEvent::Turn,
        CLOCK => TapeEvent::Clock,
        RECEIVED => TapeEvent::Received(port, data),
        SENT => TapeEvent::Sent(port, data),
        TOLD_TO_END => TapeEvent::ToldToEnd(String::from_utf8_lossy(&data).into_owned()),
        AGAIN => TapeEvent::Received(port, shared.get(u64::from_be_bytes(data.try_into().ok()?))?.clone()),
        _ => return None,
    })
}

fn messages_of(group: &WireGroup) -> impl Iterator<Item = Vec<u8>> + '_ {
    let length = group.length as usize;
    // A group of empty messages has no bytes to count them by, and never ends.
    let count = group.planes.len().checked_div(length).unwrap_or(usize::MAX);
    let mut before = vec![0_u8; length.min(group.planes.len())];
    (0..count).map(move |index| {
        for (at, byte) in before.iter_mut().enumerate() {
            *byte = byte.wrapping_add(group.planes[at * count + index]);
        }
        before.clone()
    })
}

fn put_varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..64).step_by(7) {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(us: u64, event: TapeEvent) -> TapeEntry {
        TapeEntry { stamp: Stamp::from_micros(us), event }
    }

    fn tape(robot: u8) -> Vec<TapeEntry> {
        let beacon = |n: u8| vec![n; 71];
        let mut entries = Vec::new();
        for n in 0..20_u8 {
            let us = 5_000_000 + u64::from(n) * 20_011;
            entries.push(entry(us, TapeEvent::Turn));
            entries.push(entry(us, TapeEvent::Received(TapePort::DriveBus, vec![0x11, 2, 0, 0, n, 1, 2])));
            entries.push(entry(us, TapeEvent::Received(TapePort::LidarBus, vec![0x11, 2, 0, 0x80])));
            entries.push(entry(us, TapeEvent::Received(TapePort::Beacons, beacon(n))));
            entries.push(entry(us + 7, TapeEvent::Clock));
            entries.push(entry(us, TapeEvent::Sent(TapePort::Beacons, vec![robot; 71])));
            entries.push(entry(us, TapeEvent::Sent(TapePort::Autopilot, Vec::new())));
        }
        entries.push(entry(9_000_000, TapeEvent::ToldToEnd("operator".into())));
        entries
    }

    #[test]
    fn what_is_packed_is_unpacked_as_it_was_and_shared_messages_are_written_once() {
        let (mut writer, mut reader) = (Shared::default(), Shared::default());
        let mut bytes = Vec::new();
        for robot in [1, 2] {
            let tape = tape(robot);
            let wire = pack(robot.into(), &tape, &mut writer);
            bytes.push(prost::Message::encoded_len(&wire));
            let back = unpack(5_000_000, &wire, &mut reader);
            assert_eq!(back, tape);
        }
        assert!(bytes[1] + 19 * 60 < bytes[0], "{bytes:?}");
    }

    #[test]
    fn torn_batches_never_panic() {
        let wire = pack(1, &tape(1), &mut Shared::default());
        for cut in 0..wire.gaps_us.len() {
            let mut torn = wire.clone();
            torn.gaps_us.truncate(cut);
            torn.order.truncate(cut / 2);
            for group in &mut torn.groups {
                group.planes.truncate(cut);
                group.length = group.length.wrapping_mul(cut as u32);
            }
            let _ = unpack(u64::MAX - 5, &torn, &mut Shared::default());
        }
    }
}
