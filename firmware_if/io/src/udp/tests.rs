use super::*;
use std::future::poll_fn;

fn wait<T>(mut ask: impl FnMut() -> Option<T>) -> T {
    let limit = Instant::now() + Duration::from_secs(5);
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(Instant::now() < limit, "nothing came within 5 s");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn receive(link: &mut UdpLink) -> Vec<u8> {
    let mut buf = [0; 64];
    let len = wait(|| link.try_recv(&mut buf).unwrap());
    buf[..len].to_vec()
}

fn server() -> (UdpServer, String) {
    let server = UdpServer::open("127.0.0.1:0").unwrap();
    let address = format!("udpout:{}", server.local_addr().unwrap());
    (server, address)
}

#[test]
fn a_server_answers_each_of_its_peers() {
    let (mut server, address) = server();
    let (mut one, mut two) = (UdpLink::open(&address).unwrap(), UdpLink::open(&address).unwrap());
    one.send(b"one").unwrap();
    two.send(b"two").unwrap();
    for _ in 0..2 {
        let mut buf = [0; 64];
        let (len, from) = wait(|| server.try_recv_from(&mut buf).unwrap());
        server.send_to(&buf[..len], from).unwrap();
    }
    assert_eq!(receive(&mut one), b"one");
    assert_eq!(receive(&mut two), b"two");
}

#[test]
fn a_link_that_waits_is_down_until_it_is_spoken_to_and_then_answers_the_last_speaker() {
    let mut waiting = UdpLink::open("udpin:127.0.0.1:0").unwrap();
    assert_eq!(waiting.send(b"hello"), Err(LinkError::Down("no peer heard yet".into())));
    let address = format!("udpout:{}", waiting.local_addr().unwrap());
    let (mut one, mut two) = (UdpLink::open(&address).unwrap(), UdpLink::open(&address).unwrap());
    one.send(b"first").unwrap();
    assert_eq!(receive(&mut waiting), b"first");
    waiting.send(b"to one").unwrap();
    assert_eq!(receive(&mut one), b"to one");
    two.send(b"second").unwrap();
    assert_eq!(receive(&mut waiting), b"second");
    waiting.send(b"to two").unwrap();
    assert_eq!(receive(&mut two), b"to two");
    assert_eq!(one.try_recv(&mut [0; 64]), Ok(None));
}

#[test]
fn a_link_that_speaks_first_hears_its_peer_alone() {
    let (mut server, address) = server();
    let mut link = UdpLink::open(&address).unwrap();
    link.send(b"hello").unwrap();
    let (_, from) = wait(|| server.try_recv_from(&mut [0; 64]).unwrap());
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    stranger.send_to(b"forged", ("127.0.0.1", from.port())).unwrap();
    server.send_to(b"true", from).unwrap();
    assert_eq!(receive(&mut link), b"true");
    assert_eq!(link.try_recv(&mut [0; 64]), Ok(None));
}

#[test]
fn a_peer_that_went_away_is_down_and_heard_again_when_it_is_back() {
    let (server, address) = server();
    let place = server.local_addr().unwrap();
    let mut link = UdpLink::open(&address).unwrap();
    drop(server);
    link.send(b"into the void").unwrap();
    let down = wait(|| match link.send(b"again") {
        Err(LinkError::Down(why)) => Some(why),
        Ok(()) | Err(_) => None,
    });
    assert_eq!(down, "nobody listens at the other end");
    let mut server = UdpServer::open(&place.to_string()).unwrap();
    let mut buf = [0; 64];
    let len = wait(|| {
        let _ = link.send(b"back");
        server.try_recv_from(&mut buf).unwrap().map(|(len, _)| len)
    });
    assert_eq!(&buf[..len], b"back");
}

#[test]
fn a_stop_sender_speaks_from_another_thread_over_the_same_socket() {
    let (mut server, address) = server();
    let mut link = UdpLink::open(&address).unwrap();
    let mut stop = link.stop_sender();
    std::thread::spawn(move || stop(b"stop")).join().unwrap();
    link.send(b"go").unwrap();
    let mut buf = [0; 64];
    let (len, stop_from) = wait(|| server.try_recv_from(&mut buf).unwrap());
    assert_eq!(&buf[..len], b"stop");
    let (_, go_from) = wait(|| server.try_recv_from(&mut buf).unwrap());
    assert_eq!(stop_from, go_from);
}

#[test]
fn a_stop_sender_of_a_waiting_link_reaches_the_peer_heard_last() {
    let mut waiting = UdpLink::open("udpin:127.0.0.1:0").unwrap();
    let mut stop = waiting.stop_sender();
    stop(b"nobody to hear it");
    let mut peer = UdpLink::open(&format!("udpout:{}", waiting.local_addr().unwrap())).unwrap();
    peer.send(b"hello").unwrap();
    assert_eq!(receive(&mut waiting), b"hello");
    stop(b"stop");
    assert_eq!(receive(&mut peer), b"stop");
}

#[test]
fn a_port_in_use_is_named_with_what_to_do() {
    let first = UdpServer::open("127.0.0.1:0").unwrap();
    let place = first.local_addr().unwrap();
    let error = UdpLink::open(&format!("udpin:{place}")).err().unwrap();
    let text = error.to_string();
    assert!(text.contains(&format!("UDP port {} is in use", place.port())), "{text}");
    assert!(text.contains("ss -ulpn"), "{text}");
}

#[test]
fn addresses_that_cannot_be_read_say_what_to_write() {
    for address in ["", "udpout:", "udpout:127.0.0.1", "udpin:127.0.0.1:66000", "tcp:127.0.0.1:5760", "udpout::1"] {
        let error = UdpLink::open(address).err().unwrap_or_else(|| panic!("{address:?} was opened"));
        assert!(error.advice.contains("udpout:HOST:PORT"), "{address:?}: {error}");
    }
}

#[test]
fn a_datagram_longer_than_the_buffer_is_cut_and_the_next_is_whole() {
    let (mut server, address) = server();
    let mut link = UdpLink::open(&address).unwrap();
    link.send(&[1; 300]).unwrap();
    link.send(&[2; 3]).unwrap();
    let mut buf = [0; 8];
    assert_eq!(wait(|| server.try_recv_from(&mut buf).unwrap()).0, 8);
    assert_eq!(wait(|| server.try_recv_from(&mut buf).unwrap()).0, 3);
}

#[test]
fn a_link_without_a_way_to_its_peer_opens_and_says_that_it_is_down() {
    // A broadcast address cannot be connected to without a further option: it stands for a network that is not there.
    let mut link = UdpLink::open("udpout:255.255.255.255:14550").unwrap();
    assert!(matches!(link.send(b"hello"), Err(LinkError::Down(_))));
    assert_eq!(link.try_recv(&mut [0; 8]), Ok(None));
}

#[test]
fn a_waiting_task_is_woken_by_each_datagram_and_sleeps_between_them() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let (mut server, address) = server();
        let mut link = UdpLink::open(&address).unwrap();
        for round in 0..3_u8 {
            let quiet = Duration::from_millis(20);
            let early = tokio::time::timeout(quiet, poll_fn(|cx| server.poll_readable(cx))).await;
            assert!(early.is_err(), "woken in round {round} without a datagram");
            link.send(&[round]).unwrap();
            let limit = Duration::from_secs(5);
            tokio::time::timeout(limit, poll_fn(|cx| server.poll_readable(cx))).await.unwrap();
            let mut buf = [0; 8];
            assert_eq!(server.try_recv_from(&mut buf).unwrap().unwrap().0, 1);
            assert_eq!(buf[0], round);
        }
    });
}
