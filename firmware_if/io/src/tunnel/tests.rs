use super::*;
use std::time::{Duration, Instant};

/// Made by cannelloni's own `buildPacket` (parser.cpp of github.com/mguentner/cannelloni @ a7776f8, compiled into a
/// program that prints what it built). Sequence number and frame stand beside each.
const STANDARD: (u8, &str, &str) = (7, "111#0096000000000000", "020007000100000111080096000000000000");
const EXTENDED: (u8, &str, &str) = (255, "1055962A#496B0140", "0200FF00019055962A04496B0140");
const EMPTY: (u8, &str, &str) = (0, "421#", "02000000010000042100");
/// A remote frame, an error frame (bus-off), a CAN FD frame, and the two data frames above.
const MIXED: &str = "0200010005400001230420000040080000000000000000000000558C010102030405060708090A0B0C\
                     000001110800960000000000009055962A04496B0140";

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

fn frame(text: &str) -> CanFrame {
    let (id, data) = text.split_once('#').unwrap();
    let raw = u32::from_str_radix(id, 16).unwrap();
    let id = if id.len() == 3 { CanId::Standard(raw as u16) } else { CanId::Extended(raw) };
    CanFrame::new(id, &bytes(data)).unwrap()
}

fn items(packet: &[u8]) -> (Vec<Item>, Result<(), Malformed>) {
    let mut items = Vec::new();
    let result = parse(packet, |item| items.push(item));
    (items, result)
}

#[test]
fn packets_are_those_that_cannelloni_builds() {
    for (sequence, text, packet) in [STANDARD, EXTENDED, EMPTY] {
        let mut built = [0; 18];
        let len = emit(sequence, &frame(text), &mut built);
        assert_eq!(built[..len], bytes(packet), "{text}");
        assert_eq!(items(&bytes(packet)), (vec![Item::Data(frame(text))], Ok(())), "{text}");
    }
}

#[test]
fn of_a_packet_with_all_kinds_of_frames_the_classic_data_frames_are_taken() {
    let expected = vec![
        Item::NotClassicData,
        Item::Error,
        Item::NotClassicData,
        Item::Data(frame(STANDARD.1)),
        Item::Data(frame(EXTENDED.1)),
    ];
    assert_eq!(items(&bytes(MIXED)), (expected, Ok(())));
}

#[test]
fn a_packet_that_was_cut_gives_its_whole_frames_and_then_an_error() {
    let whole = bytes(MIXED);
    for len in 0..whole.len() {
        let (found, result) = items(&whole[..len]);
        assert!(result.is_err(), "{len} bytes were taken for a whole packet");
        assert!(found.len() < 5);
    }
}

#[test]
fn no_packet_with_a_bit_turned_is_read_beyond_its_end_or_gives_more_frames_than_fit() {
    let whole = bytes(MIXED);
    for at in 0..whole.len() * 8 {
        let mut broken = whole.clone();
        broken[at / 8] ^= 1 << (at % 8);
        assert!(items(&broken).0.len() <= whole.len() / 5);
    }
    let claims_many = [VERSION, DATA, 0, 0xFF, 0xFF];
    assert_eq!(items(&claims_many), (vec![], Err(Malformed("shorter than its frames"))));
}

#[test]
fn other_versions_kinds_lengths_and_identifiers_are_refused() {
    for (packet, why) in [
        ("010007000100000111080096000000000000", "not version 2"),
        ("020107000100000111080096000000000000", "not a data packet"),
        ("02000700010000011109009600000000000000", "a frame longer than CAN allows"),
        ("020007000100000811080096000000000000", "a standard identifier wider than 11 bits"),
        ("020007000110000111080096000000000000", "a standard identifier wider than 11 bits"),
    ] {
        assert_eq!(items(&bytes(packet)), (vec![], Err(Malformed(leak(why)))), "{packet}");
    }
}

fn leak(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn receive(bus: &mut impl CanBus) -> CanFrame {
    let limit = Instant::now() + Duration::from_secs(5);
    loop {
        if let Ok(Some(frame)) = bus.try_recv() {
            return frame;
        }
        assert!(Instant::now() < limit, "no frame within 5 s");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn pair() -> (Tunnel, Tunnel) {
    let (here, address) = Tunnel::pair().unwrap();
    let (local, remote) = Tunnel::ports_of(&address).unwrap().unwrap();
    (here, Tunnel::open(local, remote).unwrap())
}

#[test]
fn frames_cross_a_tunnel_both_ways_and_do_not_come_back() {
    let (mut here, mut there) = pair();
    here.send(&frame("111#0096")).unwrap();
    there.send(&frame("1055962A#01")).unwrap();
    assert_eq!(receive(&mut there), frame("111#0096"));
    assert_eq!(receive(&mut here), frame("1055962A#01"));
    assert_eq!((here.try_recv(), there.try_recv()), (Ok(None), Ok(None)));
}

#[test]
fn a_tunnel_whose_other_end_is_not_there_is_down_and_works_once_it_is() {
    let (mut here, address) = Tunnel::pair().unwrap();
    here.send(&frame("111#00")).unwrap();
    std::thread::sleep(Duration::from_millis(10));
    assert!(matches!(here.send(&frame("111#00")), Err(LinkError::Down(_))));
    assert!(here.health().down);
    let (local, remote) = Tunnel::ports_of(&address).unwrap().unwrap();
    let mut there = Tunnel::open(local, remote).unwrap();
    here.send(&frame("111#01")).unwrap();
    assert_eq!(receive(&mut there), frame("111#01"));
    assert!(!here.health().down);
}

#[test]
fn the_send_only_side_of_a_tunnel_reaches_the_other_end_from_another_thread() {
    let (here, mut there) = pair();
    let mut stop = here.send_only();
    std::thread::spawn(move || stop.send(&frame("111#0000000000000000")).unwrap()).join().unwrap();
    assert_eq!(receive(&mut there), frame("111#0000000000000000"));
}

#[test]
fn what_is_no_packet_is_an_error_and_the_next_packet_is_read() {
    let (here, mut there) = pair();
    here.socket.get().send(b"garbage").unwrap();
    here.socket.get().send(&bytes(STANDARD.2)).unwrap();
    std::thread::sleep(Duration::from_millis(10));
    assert!(matches!(there.try_recv(), Err(LinkError::Os(_))));
    assert_eq!(there.try_recv(), Ok(Some(frame(STANDARD.1))));
}

#[test]
fn a_packet_with_error_frames_shows_in_the_buses_health() {
    let (here, mut there) = pair();
    here.socket.get().send(&bytes(MIXED)).unwrap();
    assert_eq!(receive(&mut there), frame(STANDARD.1));
    assert_eq!(there.try_recv(), Ok(Some(frame(EXTENDED.1))));
    assert_eq!(there.health().error_frames, 1);
}

#[test]
fn a_tunnels_address_is_two_different_ports() {
    assert_eq!(Tunnel::ports_of("can0"), Ok(None));
    assert_eq!(Tunnel::ports_of("udp:20001:20002"), Ok(Some((20_001, 20_002))));
    for address in ["udp:", "udp:1", "udp:20001", "udp:20001:20001", "udp:80:20001", "udp:20001:70000", "udp:a:b"] {
        let error = Tunnel::ports_of(address).unwrap_err();
        assert!(error.advice.contains("udp:LOCAL_PORT:REMOTE_PORT"), "{address}: {error}");
    }
}

#[test]
fn a_tunnels_port_in_use_is_named() {
    let (_here, address) = Tunnel::pair().unwrap();
    let (_there, taken) = Tunnel::ports_of(&address).unwrap().unwrap();
    let error = Tunnel::open(taken, 20_000).err().unwrap();
    assert!(error.why.contains(&format!("{taken} is in use")), "{error}");
}
