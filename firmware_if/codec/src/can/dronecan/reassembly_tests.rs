//! Reassembly under loss, repetition, disorder and malice.

use super::transfer::{TRANSFER_MAX, split};
use super::{FrameId, Reassembler, Transfer};
use drover_contract::{CanFrame, CanId, CanNode, Stamp};
use proptest::prelude::*;

const SIGNATURE: u64 = 0x0123_4567_89AB_CDEF;

fn id_of(source: u8) -> FrameId {
    FrameId::Message { priority: 16, type_id: 1000, source: CanNode(source) }
}

fn frames(source: u8, transfer_id: u8, len: u8) -> Vec<CanFrame> {
    let payload: Vec<u8> = (0..len).collect();
    split(id_of(source), SIGNATURE, transfer_id, &payload)
}

fn feed(reassembler: &mut Reassembler, at_ms: u64, frames: &[CanFrame]) -> Vec<Transfer> {
    let take = |frame| reassembler.accept(Stamp::from_millis(at_ms), frame, |_| Some(SIGNATURE));
    frames.iter().filter_map(take).collect()
}

#[test]
fn two_nodes_may_speak_at_once() {
    let mut reassembler = Reassembler::new(4);
    let (a, b) = (frames(1, 0, 20), frames(2, 0, 20));
    let mixed: Vec<CanFrame> = a.into_iter().zip(b).flat_map(|(a, b)| [a, b]).collect();
    assert_eq!(feed(&mut reassembler, 0, &mixed).len(), 2);
    assert_eq!(reassembler.counters().broken(), 0);
}

#[test]
fn a_transfer_with_a_frame_missing_is_dropped_and_the_next_one_arrives() {
    for missing in 0..4 {
        let mut reassembler = Reassembler::new(4);
        let mut torn = frames(1, 0, 20);
        torn.remove(missing);
        assert_eq!(feed(&mut reassembler, 0, &torn), [], "without frame {missing}");
        assert_eq!(feed(&mut reassembler, 1, &frames(1, 1, 20)).len(), 1);
        assert!(reassembler.counters().broken() >= 1);
    }
}

#[test]
fn a_transfer_with_a_flipped_bit_is_dropped() {
    let mut reassembler = Reassembler::new(4);
    let mut torn = frames(1, 0, 20);
    let mut data: [u8; 8] = torn[1].data().try_into().unwrap();
    data[3] ^= 0x10;
    torn[1] = CanFrame::new(torn[1].id(), &data).unwrap();
    assert_eq!(feed(&mut reassembler, 0, &torn), []);
    assert_eq!(reassembler.counters().crc_errors, 1);
}

#[test]
fn a_transfer_that_comes_twice_counts_once_until_its_number_may_come_again() {
    for len in [5, 20] {
        let mut reassembler = Reassembler::new(4);
        let twice = [frames(1, 3, len), frames(1, 3, len)].concat();
        assert_eq!(feed(&mut reassembler, 0, &twice).len(), 1);
        let counters = reassembler.counters();
        assert_eq!((counters.duplicates, counters.broken()), (1, 0));
        assert_eq!(feed(&mut reassembler, 2_001, &frames(1, 3, len)).len(), 1);
    }
}

#[test]
fn a_transfer_that_takes_too_long_is_given_up() {
    let mut reassembler = Reassembler::new(4);
    let slow = frames(1, 0, 20);
    assert_eq!(feed(&mut reassembler, 0, &slow[..3]), []);
    assert_eq!(feed(&mut reassembler, 2_001, &slow[3..]), []);
    assert_eq!((reassembler.counters().unfinished, reassembler.counters().missed_starts), (1, 1));
}

#[test]
fn a_first_frame_with_its_toggle_set_is_of_another_protocol() {
    let mut reassembler = Reassembler::new(4);
    let single = CanFrame::new(id_of(1).emit(), &[1, 2, 0xE0]).unwrap();
    assert_eq!(feed(&mut reassembler, 0, &[single]), []);
    assert_eq!(reassembler.counters().out_of_order, 1);
}

#[test]
fn a_transfer_without_end_is_cut_off() {
    let mut reassembler = Reassembler::new(4);
    let endless = (0..200_u8).map(|i| {
        let tail = if i == 0 { 0x80 } else { u8::from(i % 2 == 1) << 5 };
        CanFrame::new(id_of(1).emit(), &[0, 0, 0, 0, 0, 0, 0, tail]).unwrap()
    });
    assert_eq!(feed(&mut reassembler, 0, &endless.collect::<Vec<_>>()), []);
    assert_eq!(reassembler.counters().too_long, 1);
}

#[test]
fn more_nodes_than_sessions_push_out_the_longest_quiet() {
    let mut reassembler = Reassembler::new(3);
    for source in 1..=100 {
        _ = feed(&mut reassembler, source.into(), &frames(source, 0, 20)[..1]);
        assert!(reassembler.sessions() <= 3);
    }
    assert_eq!(reassembler.counters().unfinished, 97);
    assert_eq!(feed(&mut reassembler, 101, &frames(100, 0, 20)[1..]).len(), 1);
}

#[test]
fn frames_that_nobody_asked_for_leave_no_session() {
    let mut reassembler = Reassembler::new(3);
    for frame in frames(1, 0, 20) {
        assert_eq!(reassembler.accept(Stamp::ZERO, &frame, |_| None), None);
    }
    assert_eq!((reassembler.sessions(), reassembler.counters().foreign), (0, 4));
}

fn bytes_of_a_frame() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..=8)
}

proptest! {
    #[test]
    fn any_payload_survives(
        payload in prop::collection::vec(any::<u8>(), 0..=TRANSFER_MAX), transfer_id in 0_u8..32
    ) {
        let mut reassembler = Reassembler::new(1);
        let transfers = feed(&mut reassembler, 0, &split(id_of(9), SIGNATURE, transfer_id, &payload));
        prop_assert_eq!(transfers, [Transfer { id: id_of(9), transfer_id, payload }]);
    }

    #[test]
    fn no_sequence_of_frames_breaks_the_bounds(
        input in prop::collection::vec((0_u32..=0x1FFF_FFFF, 0_u32..4, bytes_of_a_frame()), 0..300)
    ) {
        let mut reassembler = Reassembler::new(5);
        for (i, (raw, few, data)) in input.iter().enumerate() {
            // Most frames fall on a few streams, or nothing would ever be continued.
            let raw = if *few > 0 { 0x1003_E800 | few } else { *raw };
            let frame = CanFrame::new(CanId::Extended(raw), data).unwrap();
            let transfer = reassembler.accept(Stamp::from_millis(i as u64), &frame, |_| Some(SIGNATURE));
            prop_assert!(transfer.is_none_or(|transfer| transfer.payload.len() <= TRANSFER_MAX));
            prop_assert!(reassembler.sessions() <= 5);
        }
    }
}
