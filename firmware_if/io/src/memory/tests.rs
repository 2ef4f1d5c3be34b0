use super::*;
use drover_contract::CanId;
use std::future::poll_fn;
use std::time::Duration;

fn frame(n: u8) -> CanFrame {
    CanFrame::new(CanId::Standard(0x100 + u16::from(n)), &[n]).unwrap()
}

#[test]
fn every_node_but_the_sender_hears_a_frame() {
    let bus = MemoryBus::new(8);
    let (mut one, mut two, mut three) = (bus.node(), bus.node(), bus.node());
    one.send(&frame(7)).unwrap();
    assert_eq!(one.try_recv(), Ok(None));
    assert_eq!(two.try_recv(), Ok(Some(frame(7))));
    assert_eq!(three.try_recv(), Ok(Some(frame(7))));
    assert_eq!(two.try_recv(), Ok(None));
}

#[test]
fn a_node_that_does_not_read_loses_its_oldest_frames_and_counts_them() {
    let bus = MemoryBus::new(3);
    let (mut one, mut two) = (bus.node(), bus.node());
    for n in 0..5 {
        one.send(&frame(n)).unwrap();
    }
    let heard: Vec<_> = std::iter::from_fn(|| two.try_recv().unwrap()).collect();
    assert_eq!(heard, [frame(2), frame(3), frame(4)]);
    assert_eq!(two.health().dropped_full, 2);
    assert_eq!(one.health().dropped_full, 0);
}

#[test]
fn a_dropped_node_takes_nothing_and_disturbs_nobody() {
    let bus = MemoryBus::new(3);
    let (mut one, two, mut three) = (bus.node(), bus.node(), bus.node());
    drop(two);
    one.send(&frame(1)).unwrap();
    assert_eq!(three.try_recv(), Ok(Some(frame(1))));
    assert_eq!(lock(&bus.wire).nodes.len(), 2);
}

#[test]
fn a_node_hears_only_what_was_sent_after_it_came() {
    let bus = MemoryBus::new(3);
    let mut one = bus.node();
    one.send(&frame(1)).unwrap();
    assert_eq!(bus.node().try_recv(), Ok(None));
}

#[test]
fn a_task_that_waits_for_a_frame_is_woken_from_another_thread() {
    let bus = MemoryBus::new(3);
    let (mut one, mut two) = (bus.node(), bus.node());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
    let sender = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(20));
        one.send(&frame(9)).unwrap();
        one
    });
    let heard = runtime.block_on(async {
        tokio::time::timeout(Duration::from_secs(5), poll_fn(|cx| two.poll_readable(cx))).await.unwrap();
        two.try_recv()
    });
    assert_eq!(heard, Ok(Some(frame(9))));
    sender.join().unwrap();
}

#[test]
fn datagrams_cross_a_memory_link_whole_and_in_order_both_ways() {
    let (mut near, mut far) = memory_link(4);
    near.send(b"one").unwrap();
    near.send(b"two").unwrap();
    far.send(b"back").unwrap();
    let mut buf = [0; 16];
    assert_eq!(far.try_recv(&mut buf), Ok(Some(3)));
    assert_eq!(&buf[..3], b"one");
    assert_eq!(far.try_recv(&mut buf), Ok(Some(3)));
    assert_eq!(far.try_recv(&mut buf), Ok(None));
    assert_eq!(near.try_recv(&mut buf), Ok(Some(4)));
    assert_eq!(&buf[..4], b"back");
}

#[test]
fn a_memory_link_whose_other_end_is_gone_is_down_but_still_gives_what_came_before() {
    let (mut near, mut far) = memory_link(4);
    far.send(b"last").unwrap();
    drop(far);
    assert!(matches!(near.send(b"hello"), Err(LinkError::Down(_))));
    assert_eq!(near.try_recv(&mut [0; 16]), Ok(Some(4)));
}

#[test]
fn a_memory_link_keeps_the_newest_datagrams_and_cuts_those_longer_than_the_buffer() {
    let (mut near, mut far) = memory_link(2);
    for text in [b"aaaa", b"bbbb", b"cccc"] {
        near.send(text).unwrap();
    }
    let mut buf = [0; 2];
    assert_eq!(far.try_recv(&mut buf), Ok(Some(2)));
    assert_eq!(&buf, b"bb");
    assert_eq!(far.dropped(), 1);
}
