use super::*;
use std::net::SocketAddr;
use std::process::Command;
use std::time::{Duration, Instant};

/// Set in the child process of the test below: the port of the beacon plane.
const CHILD_PORT: &str = "DROVER_TEST_BEACON_PORT";

/// A port that is free at this moment.
fn free_port() -> u16 {
    UdpSocket::bind("0.0.0.0:0").unwrap().local_addr().unwrap().port()
}

fn open(group: &str, port: u16) -> BeaconSocket {
    BeaconSocket::open(group, port, "127.0.0.1").unwrap()
}

fn hears(socket: &mut BeaconSocket, wanted: &[u8], limit: Duration) -> bool {
    let end = Instant::now() + limit;
    let mut buf = [0; 64];
    while Instant::now() < end {
        match socket.try_recv(&mut buf).unwrap() {
            Some(len) if &buf[..len] == wanted => return true,
            Some(_) => {}
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    false
}

#[test]
fn all_sockets_of_a_group_hear_each_other_and_themselves() {
    let port = free_port();
    let mut all: Vec<_> = (0..3).map(|_| open("239.68.82.1", port)).collect();
    all[0].send(b"here I am").unwrap();
    for socket in &mut all {
        assert!(hears(socket, b"here I am", Duration::from_secs(5)));
    }
}

#[test]
fn a_group_hears_neither_another_group_nor_a_datagram_sent_to_its_port_alone() {
    let port = free_port();
    let mut one = open("239.68.82.1", port);
    let mut other = open("239.68.82.2", port);
    other.send(b"not yours").unwrap();
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(b"not a beacon", SocketAddr::from(([127, 0, 0, 1], port))).unwrap();
    one.send(b"yours").unwrap();
    let mut buf = [0; 64];
    assert!(hears(&mut other, b"not yours", Duration::from_secs(5)));
    std::thread::sleep(Duration::from_millis(20));
    let len = one.try_recv(&mut buf).unwrap().unwrap();
    assert_eq!(&buf[..len], b"yours");
    assert_eq!(one.try_recv(&mut buf), Ok(None));
}

#[test]
fn two_processes_hear_each_other_over_loopback() {
    if let Ok(port) = std::env::var(CHILD_PORT) {
        let mut socket = open("239.68.82.3", port.parse().unwrap());
        assert!(hears(&mut socket, b"question", Duration::from_secs(10)), "the child heard nothing");
        return socket.send(b"answer").unwrap();
    }
    let port = free_port();
    let mut socket = open("239.68.82.3", port);
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "beacon::tests::two_processes_hear_each_other_over_loopback"])
        .env(CHILD_PORT, port.to_string())
        .spawn()
        .unwrap();
    let answered = (0..100).any(|_| {
        socket.send(b"question").unwrap();
        hears(&mut socket, b"answer", Duration::from_millis(100))
    });
    assert!(child.wait().unwrap().success());
    assert!(answered, "the parent heard no answer");
}

#[test]
fn an_address_that_is_no_group_is_refused_with_what_to_write() {
    for group in ["127.0.0.1", "192.168.1.255", "240.0.0.1", "everybody", ""] {
        let error = BeaconSocket::open(group, 15_999, "127.0.0.1").err().unwrap();
        assert!(error.why.contains("is not an IPv4 multicast group"), "{error}");
        assert!(error.advice.contains("beacon.group"), "{error}");
    }
}

#[test]
fn an_interface_that_this_computer_lacks_is_refused_with_what_to_do() {
    for interface in ["203.0.113.77", "wlan0"] {
        let error = BeaconSocket::open("239.68.82.1", free_port(), interface).err().unwrap();
        assert!(error.why.contains(interface), "{error}");
        assert!(error.advice.contains("beacon.interface"), "{error}");
    }
}
