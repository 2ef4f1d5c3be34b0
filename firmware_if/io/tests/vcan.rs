//! What only a kernel with CAN can show. These tests fail where there is none; `tests/with-vcan` gives them one:
//!
//! ```text
//! cargo test -p drover-io --features vcan-tests --test vcan --no-run    # prints the program's path
//! tests/with-vcan -t 120 target/debug/deps/vcan-...
//! ```

use drover_contract::{BusHealth, CanBus, CanFrame, CanId, LinkError};
use drover_io::{CanLink, IdFilter, SocketCanBus, VcanInterface, kernel_has_can, open_can};
use socketcan::{CanErrorFrame, CanInterface, CanRemoteFrame, CanSocket, EmbeddedFrame, Socket, StandardId};
use std::future::poll_fn;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(10);

/// A name that no other test uses.
fn fresh_name() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    format!("t{}x{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed))
}

fn interface() -> VcanInterface {
    assert!(kernel_has_can(), "this kernel has no CAN: run this program as tests/with-vcan PROGRAM");
    VcanInterface::create(&fresh_name()).unwrap()
}

fn standard(raw: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(CanId::Standard(raw), data).unwrap()
}

fn extended(raw: u32, data: &[u8]) -> CanFrame {
    CanFrame::new(CanId::Extended(raw), data).unwrap()
}

fn wait<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let limit = Instant::now() + PATIENCE;
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(Instant::now() < limit, "{what}: not within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn receive(bus: &mut SocketCanBus) -> CanFrame {
    wait("a frame", || bus.try_recv().unwrap())
}

/// Everything that arrives up to a frame that ends the test.
fn received_before(last: CanFrame, bus: &mut SocketCanBus) -> Vec<CanFrame> {
    let mut frames = Vec::new();
    loop {
        match receive(bus) {
            frame if frame == last => return frames,
            frame => frames.push(frame),
        }
    }
}

#[test]
fn standard_and_extended_frames_cross_a_bus_both_ways() {
    let interface = interface();
    let mut one = SocketCanBus::open(interface.name()).unwrap();
    let mut two = SocketCanBus::open(interface.name()).unwrap();
    let frames = [standard(0x111, &[0, 0x96, 0, 0, 0, 0, 0, 0]), extended(0x1055_962A, &[0x49]), standard(0x421, &[])];
    for frame in frames {
        one.send(&frame).unwrap();
        assert_eq!(receive(&mut two), frame);
        two.send(&frame).unwrap();
        assert_eq!(receive(&mut one), frame);
    }
    assert_eq!(one.health(), BusHealth::default());
}

#[test]
fn a_node_does_not_hear_itself() {
    let interface = interface();
    let mut one = SocketCanBus::open(interface.name()).unwrap();
    let mut two = SocketCanBus::open(interface.name()).unwrap();
    one.send(&standard(0x111, &[1])).unwrap();
    two.send(&standard(0x221, &[2])).unwrap();
    assert_eq!(receive(&mut one), standard(0x221, &[2]));
    assert_eq!(one.try_recv(), Ok(None));
}

#[test]
fn an_extended_frame_never_passes_as_the_standard_one_of_the_same_number() {
    let interface = interface();
    let filters = [IdFilter::exact(CanId::Standard(0x211)), IdFilter::masked(CanId::Standard(0x250), 0x7F0)];
    let mut filtered = SocketCanBus::open_filtered(interface.name(), &filters).unwrap();
    let mut sender = SocketCanBus::open(interface.name()).unwrap();
    let last = standard(0x211, &[0xFF]);
    for frame in [extended(0x211, &[1]), standard(0x212, &[2]), standard(0x257, &[3]), extended(0x257, &[4]), last] {
        sender.send(&frame).unwrap();
    }
    assert_eq!(received_before(last, &mut filtered), [standard(0x257, &[3])]);
}

#[test]
fn a_filter_for_an_extended_identifier_stops_the_standard_one() {
    let interface = interface();
    let filters = [IdFilter::exact(CanId::Extended(0x211))];
    let mut filtered = SocketCanBus::open_filtered(interface.name(), &filters).unwrap();
    let mut sender = SocketCanBus::open(interface.name()).unwrap();
    let last = extended(0x211, &[0xFF]);
    for frame in [standard(0x211, &[1]), extended(0x212, &[2]), last] {
        sender.send(&frame).unwrap();
    }
    assert_eq!(received_before(last, &mut filtered), []);
}

#[test]
fn remote_frames_never_reach_a_codec() {
    let interface = interface();
    let mut bus = SocketCanBus::open(interface.name()).unwrap();
    let raw = CanSocket::open(interface.name()).unwrap();
    let remote = CanRemoteFrame::new_remote(StandardId::new(0x211).unwrap(), 8).unwrap();
    raw.write_frame(&remote).unwrap();
    let mut other = SocketCanBus::open(interface.name()).unwrap();
    other.send(&standard(0x211, &[1])).unwrap();
    assert_eq!(receive(&mut bus), standard(0x211, &[1]));
    assert_eq!(bus.try_recv(), Ok(None));
}

#[test]
fn a_bus_whose_interface_goes_down_says_so_and_works_again_when_it_is_up() {
    let interface = interface();
    let kernel = CanInterface::open(interface.name()).unwrap();
    let mut one = SocketCanBus::open(interface.name()).unwrap();
    let mut two = SocketCanBus::open(interface.name()).unwrap();
    kernel.bring_down().unwrap();
    let LinkError::Down(why) = one.try_recv().unwrap_err() else { panic!("reading did not say down") };
    assert!(why.contains(&format!("ip link set {} up", interface.name())), "{why}");
    assert!(matches!(one.send(&standard(0x111, &[1])), Err(LinkError::Down(_))));
    assert!(one.health().down);
    assert_eq!(one.try_recv(), Ok(None));
    kernel.bring_up().unwrap();
    one.send(&standard(0x111, &[2])).unwrap();
    assert!(!one.health().down);
    assert!(matches!(two.try_recv(), Err(LinkError::Down(_))));
    assert_eq!(receive(&mut two), standard(0x111, &[2]), "what was sent while it was down is not sent later");
    assert!(!two.health().down);
}

#[test]
fn an_interface_that_is_down_opens_and_says_so() {
    let interface = interface();
    CanInterface::open(interface.name()).unwrap().bring_down().unwrap();
    let mut bus = SocketCanBus::open(interface.name()).unwrap();
    assert!(matches!(bus.try_recv(), Err(LinkError::Down(_))));
}

#[test]
fn a_bus_whose_interface_is_unplugged_is_opened_again_when_it_is_back() {
    let first = interface();
    let name = first.name().to_owned();
    let mut bus = SocketCanBus::open(&name).unwrap();
    drop(first);
    // The kernel first says that it goes down, then that it is gone.
    wait("the loss", || matches!(bus.try_recv(), Err(LinkError::Gone(_))).then_some(()));
    assert!(bus.health().down);
    assert!(matches!(bus.send(&standard(0x111, &[1])), Err(LinkError::Gone(_))));
    let _second = VcanInterface::create(&name).unwrap();
    let mut other = SocketCanBus::open(&name).unwrap();
    let started = Instant::now();
    wait("the bus", || bus.send(&standard(0x111, &[2])).ok());
    println!("opened again {:?} after it was back", started.elapsed());
    assert_eq!(receive(&mut other), standard(0x111, &[2]));
    assert!(!bus.health().down);
}

#[test]
fn a_task_that_waits_on_an_unplugged_bus_is_woken_by_the_first_frame_after_it_is_back() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let first = interface();
        let name = first.name().to_owned();
        let mut bus = SocketCanBus::open(&name).unwrap();
        drop(first);
        while !matches!(bus.try_recv(), Err(LinkError::Gone(_))) {
            tokio::task::yield_now().await;
        }
        let _second = VcanInterface::create(&name).unwrap();
        let mut other = SocketCanBus::open(&name).unwrap();
        let talk = async {
            loop {
                other.send(&standard(0x221, &[3])).unwrap();
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        let listen = async {
            loop {
                poll_fn(|cx| bus.poll_readable(cx)).await;
                if let Ok(Some(frame)) = bus.try_recv() {
                    return frame;
                }
            }
        };
        tokio::select! {
            frame = tokio::time::timeout(PATIENCE, listen) => assert_eq!(frame.unwrap(), standard(0x221, &[3])),
            () = talk => {}
        }
    });
}

#[test]
fn a_waiting_task_is_woken_by_a_frame_and_by_nothing_else() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let interface = interface();
        let mut bus = SocketCanBus::open(interface.name()).unwrap();
        let mut other = SocketCanBus::open(interface.name()).unwrap();
        for round in 0..3_u8 {
            let early = tokio::time::timeout(Duration::from_millis(20), poll_fn(|cx| bus.poll_readable(cx))).await;
            assert!(early.is_err(), "woken in round {round} without a frame");
            other.send(&standard(0x221, &[round])).unwrap();
            tokio::time::timeout(PATIENCE, poll_fn(|cx| bus.poll_readable(cx))).await.unwrap();
            assert_eq!(bus.try_recv(), Ok(Some(standard(0x221, &[round]))));
        }
    });
}

/// Sends an error frame as a controller's driver would; see linux/can/error.h.
fn inject(socket: &CanSocket, class: u32, data: [u8; 8]) {
    const ERROR_FLAG: u32 = 1 << 29;
    socket.write_frame(&CanErrorFrame::new_error(ERROR_FLAG | class, &data).unwrap()).unwrap();
}

#[test]
fn error_frames_become_the_health_of_the_bus_and_never_data() {
    let interface = interface();
    let mut bus = SocketCanBus::open(interface.name()).unwrap();
    let driver = CanSocket::open(interface.name()).unwrap();
    let mut health_after = |class, data| {
        inject(&driver, class, data);
        let count = bus.health().error_frames;
        wait("an error frame", || {
            assert_eq!(bus.try_recv(), Ok(None));
            (bus.health().error_frames > count).then_some(())
        });
        bus.health()
    };
    let controller = |bits| [0, bits, 0, 0, 0, 0, 0, 0];
    assert!(health_after(0x204, controller(0x30)).error_passive, "passive, with counters");
    assert!(health_after(0x88, [0, 0, 4, 0, 0, 0, 0, 0]).error_passive, "a bus error does not end it");
    let off = health_after(0x40, [0; 8]);
    assert!(off.bus_off && off.error_passive);
    let restarted = health_after(0x100, [0; 8]);
    assert_eq!(restarted, BusHealth { error_frames: 4, ..BusHealth::default() });
}

#[test]
fn a_full_transmit_queue_is_counted_and_sending_goes_on_when_there_is_room() {
    let interface = interface();
    let mut bus = SocketCanBus::open(interface.name()).unwrap();
    let mut other = SocketCanBus::open(interface.name()).unwrap();
    // A queue of some frames before a wire of 8 kbit/s stands for a bus on which nobody acknowledges.
    let shape =
        ["qdisc", "add", "dev", interface.name(), "root", "tbf", "rate", "8kbit", "burst", "64", "limit", "128"];
    let shaped = Command::new("tc").args(shape).output().expect("tc of the package iproute2");
    assert!(shaped.status.success(), "{}", String::from_utf8_lossy(&shaped.stderr));
    let mut refused = 0_u64;
    for n in 0..200_u8 {
        match bus.send(&standard(0x111, &[n])) {
            Ok(()) => {}
            Err(LinkError::Full) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused > 150, "only {refused} of 200 frames were refused");
    assert_eq!(bus.health().dropped_full, refused);
    wait("room in the queue", || bus.send(&standard(0x111, &[0xFF])).ok());
    assert!(received_before(standard(0x111, &[0xFF]), &mut other).len() < 50);
}

#[test]
fn the_send_only_side_of_a_bus_speaks_and_hears_nothing() {
    let interface = interface();
    let bus = CanLink::open(interface.name()).unwrap();
    let mut stop = bus.stop_sender().unwrap();
    let mut other = SocketCanBus::open(interface.name()).unwrap();
    other.send(&standard(0x221, &[1])).unwrap();
    let stop = std::thread::spawn(move || {
        stop.send(&standard(0x111, &[0; 8])).unwrap();
        stop.try_recv()
    });
    assert_eq!(stop.join().unwrap(), Ok(None));
    assert_eq!(receive(&mut other), standard(0x111, &[0; 8]));
}

#[test]
fn an_interface_that_is_missing_is_an_error_with_what_to_do() {
    assert!(kernel_has_can());
    let error = open_can("can77").err().unwrap();
    assert!(error.to_string().contains("no such CAN interface"), "{error}");
    assert!(error.advice.contains("ip link set can77 up type can bitrate 500000"), "{error}");
}

#[test]
fn an_interface_that_is_no_can_interface_is_refused() {
    assert!(kernel_has_can());
    let error = open_can("lo").err().unwrap();
    assert!(error.to_string().starts_with("cannot open lo: "), "{error}");
    println!("{error}");
}

#[test]
fn an_interface_made_for_a_run_goes_with_it_and_one_that_was_there_stays() {
    let name = fresh_name();
    let made = interface_named(&name);
    let used = VcanInterface::create(&name).unwrap();
    drop(used);
    assert!(SocketCanBus::open(&name).is_ok(), "an interface that was there before was deleted");
    drop(made);
    assert!(SocketCanBus::open(&name).is_err(), "the interface outlived its run");
}

fn interface_named(name: &str) -> VcanInterface {
    assert!(kernel_has_can());
    VcanInterface::create(name).unwrap()
}

#[test]
fn a_virtual_interface_that_is_down_is_brought_up_and_one_that_is_not_can_is_refused() {
    let interface = interface();
    CanInterface::open(interface.name()).unwrap().bring_down().unwrap();
    let used = VcanInterface::create(interface.name()).unwrap();
    let mut bus = SocketCanBus::open(used.name()).unwrap();
    bus.send(&standard(0x111, &[1])).unwrap();
    let error = VcanInterface::create("lo").unwrap_err();
    assert!(error.why.contains("not CAN"), "{error}");
}

#[test]
fn a_thousand_frames_arrive_in_order() {
    let interface = interface();
    let mut one = SocketCanBus::open(interface.name()).unwrap();
    let mut two = SocketCanBus::open(interface.name()).unwrap();
    let started = Instant::now();
    for n in 0..1_000_u16 {
        one.send(&standard(0x251, &n.to_be_bytes())).unwrap();
        assert_eq!(receive(&mut two), standard(0x251, &n.to_be_bytes()));
    }
    println!("1000 frames there in {:?}", started.elapsed());
}
