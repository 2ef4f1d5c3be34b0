//! What needs a kernel with CAN is in `tests/vcan.rs`.

use super::state::BusState;
use super::*;
use crate::errno::{ENETDOWN, ENOBUFS, ENXIO};
use ::socketcan::CanErrorFrame;

fn error(errno: i32) -> io::Error {
    io::Error::from_raw_os_error(errno)
}

fn error_frame(class: u32, data: [u8; 8]) -> ::socketcan::CanError {
    const ERROR_FLAG: u32 = 1 << 29;
    CanErrorFrame::new_error(ERROR_FLAG | class, &data).unwrap().into_error()
}

const CONTROLLER: u32 = 0x04;
const BUS_OFF: u32 = 0x40;
const RESTARTED: u32 = 0x100;

fn state_of_controller(bits: u8) -> [u8; 8] {
    [0, bits, 0, 0, 0, 0, 0, 0]
}

#[test]
fn filters_tell_standard_extended_and_remote_frames_apart() {
    assert_eq!(IdFilter::exact(CanId::Standard(0x211)).raw(), (0x211, 0xC000_07FF));
    assert_eq!(IdFilter::exact(CanId::Extended(0x211)).raw(), (0x8000_0211, 0xDFFF_FFFF));
    assert_eq!(IdFilter::masked(CanId::Standard(0x250), 0x7F0).raw(), (0x250, 0xC000_07F0));
}

#[test]
fn a_full_transmit_queue_pauses_sending_for_5_ms_and_then_twice_as_long_up_to_100_ms() {
    let mut state = BusState::default();
    let mut now = Instant::now();
    let mut pauses_ms = Vec::new();
    for _ in 0..7 {
        assert_eq!(state.handle_error(now, &error(ENOBUFS)), LinkError::Full);
        let full_at = now;
        while !state.may_send(now) {
            now += Duration::from_millis(1);
        }
        pauses_ms.push((now - full_at).as_millis());
    }
    assert_eq!(pauses_ms, [5, 10, 20, 40, 80, 100, 100]);
}

#[test]
fn a_frame_that_went_out_ends_the_pauses() {
    let mut state = BusState::default();
    let now = Instant::now();
    state.handle_error(now, &error(ENOBUFS));
    state.handle_error(now, &error(ENOBUFS));
    state.handle_sent();
    state.handle_error(now, &error(ENOBUFS));
    assert!(!state.may_send(now + Duration::from_millis(4)));
    assert!(state.may_send(now + Duration::from_millis(5)));
}

#[test]
fn every_frame_dropped_for_a_full_queue_is_counted() {
    let mut state = BusState::default();
    let now = Instant::now();
    state.handle_error(now, &error(ENOBUFS));
    state.may_send(now);
    state.may_send(now + Duration::from_millis(1));
    state.may_send(now + Duration::from_millis(6));
    assert_eq!(state.health().dropped_full, 3);
}

#[test]
fn a_bus_is_down_until_a_frame_passes_and_a_restarted_controller_is_healthy() {
    let mut state = BusState::default();
    state.handle_error_frame(&error_frame(BUS_OFF, [0; 8]));
    assert!(matches!(state.handle_error(Instant::now(), &error(ENETDOWN)), LinkError::Down(_)));
    assert!(state.health().down && state.health().bus_off);
    state.handle_sent();
    assert_eq!(state.health(), BusHealth { error_frames: 1, ..BusHealth::default() });
}

#[test]
fn an_interface_that_is_gone_is_told_from_one_that_is_down() {
    let mut state = BusState::default();
    for errno in [ENODEV, ENXIO] {
        assert!(matches!(state.handle_error(Instant::now(), &error(errno)), LinkError::Gone(_)));
    }
    assert!(state.health().down);
}

#[test]
fn bus_off_lasts_until_the_controller_restarts() {
    let mut state = BusState::default();
    state.handle_error_frame(&error_frame(BUS_OFF, [0; 8]));
    state.handle_sent();
    assert!(state.health().bus_off, "a frame that was queued does not end bus-off");
    state.handle_error_frame(&error_frame(RESTARTED, [0; 8]));
    assert!(!state.health().bus_off);
    assert_eq!(state.health().error_frames, 2);
}

#[test]
fn error_passive_lasts_until_the_controller_says_a_better_state() {
    for better in [0x40, 0x04, 0x08, 0x0C] {
        let mut state = BusState::default();
        state.handle_error_frame(&error_frame(CONTROLLER, state_of_controller(0x20)));
        assert!(state.health().error_passive);
        state.handle_error_frame(&error_frame(CONTROLLER, state_of_controller(0x01)));
        assert!(state.health().error_passive, "an overflow says nothing of the state");
        state.handle_error_frame(&error_frame(CONTROLLER, state_of_controller(better)));
        assert!(!state.health().error_passive, "{better:#04x}");
    }
}

#[test]
fn every_failure_to_open_says_what_to_do() {
    for (errno, advice) in [
        (EAFNOSUPPORT, "tests/with-vcan"),
        (ENODEV, "ip link add dev can7 type vcan"),
        (ENODEV, "ip link set can7 up type can bitrate 500000"),
        (EPERM, "as a user who may"),
        (5, "ip -details link show"),
    ] {
        let text = explain("can7", &error(errno)).to_string();
        assert!(text.contains(advice), "{text}");
        assert!(text.starts_with("cannot open can7: "), "{text}");
    }
}

#[test]
fn frames_keep_format_identifier_and_data_on_their_way_through_the_kernels_structure() {
    for (id, data) in [
        (CanId::Standard(0), &[][..]),
        (CanId::Standard(0x7FF), &[1, 2, 3]),
        (CanId::Extended(0x211), &[0; 8]),
        (CanId::Extended(0x1FFF_FFFF), &[9]),
    ] {
        let frame = CanFrame::new(id, data).unwrap();
        let ::socketcan::CanFrame::Data(kernel) = to_kernel(&frame).unwrap() else { panic!("not a data frame") };
        assert_eq!(from_kernel(&kernel), Some(frame));
    }
}
