//! The host of a lidar node: rounds, silence, liveness.

use super::message::{
    GET_NODE_INFO_ID, GET_NODE_INFO_SIGNATURE, Health, MEASUREMENT_ID, MEASUREMENT_SIGNATURE, Measurement,
    NODE_STATUS_ID, NODE_STATUS_SIGNATURE, NodeMode, NodeStatus, PROXIMITY_ID, PROXIMITY_SIGNATURE, Proximity,
    ProximityReading, RangeReading,
};
use super::transfer::split;
use super::{DronecanLidarHost, DronecanLidarParams, FrameId, Reassembler};
use drover_contract::{Beam, CanFrame, CanId, CanNode, Event, Scan, Severity, Stamp};
use proptest::prelude::*;

const LIDAR: CanNode = CanNode(42);
const OWN: CanNode = CanNode(10);
const SECTORS: u32 = 8;

fn ms(ms: u64) -> Stamp {
    Stamp::from_millis(ms)
}

/// A host and the counters of the node that speaks to it.
struct Bench {
    host: DronecanLidarHost,
    transfer_id: u8,
}

impl Bench {
    fn new(silent_is_clear: bool) -> Self {
        let params = DronecanLidarParams {
            node: LIDAR,
            own_node: OWN,
            beams: SECTORS,
            range_m_min: 0.1,
            range_m_max: 8.0,
            rate_hz: 10.0,
            silent_is_clear,
        };
        let mut bench = Self { host: DronecanLidarHost::new(params, ms(0)), transfer_id: 0 };
        bench.status(0, Health::Ok, NodeMode::Operational);
        _ = bench.events();
        bench
    }

    fn send(&mut self, at_ms: u64, type_id: u16, signature: u64, payload: &[u8]) {
        self.transfer_id = (self.transfer_id + 1) % 32;
        let id = FrameId::Message { priority: 16, type_id, source: LIDAR };
        for frame in split(id, signature, self.transfer_id, payload) {
            self.host.handle_frame(ms(at_ms), &frame);
        }
    }

    fn status(&mut self, at_ms: u64, health: Health, mode: NodeMode) {
        let status = NodeStatus { health, mode, ..NodeStatus::default() };
        self.send(at_ms, NODE_STATUS_ID, NODE_STATUS_SIGNATURE, &status.emit());
    }

    fn proximity(&mut self, at_ms: u64, yaw_deg: f64, reading: ProximityReading, distance_m: f64) {
        let (yaw_deg, distance_m) = (Some(yaw_deg), Some(distance_m));
        let message = Proximity { sensor_id: 0, reading, flags: 0, yaw_deg, pitch_deg: Some(0.0), distance_m };
        self.send(at_ms, PROXIMITY_ID, PROXIMITY_SIGNATURE, &message.emit());
    }

    /// A good reading in every sector, sector i at `distance(i)`, clockwise as the wire has it.
    fn round(&mut self, at_ms: u64, distance: impl Fn(u32) -> f64) {
        for sector in 0..SECTORS {
            let yaw_deg = 360.0 / f64::from(SECTORS) * f64::from(sector);
            self.proximity(at_ms + u64::from(sector), yaw_deg, ProximityReading::Good, distance(sector));
        }
    }

    fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.host.poll_event()).collect()
    }

    fn scans(&mut self) -> Vec<Scan> {
        let scan = |event| if let Event::Scan(scan) = event { Some(scan) } else { None };
        self.events().into_iter().filter_map(scan).collect()
    }
}

fn hit_at(scan: &Scan, bearing_deg: f64) -> Beam {
    let index = (bearing_deg.rem_euclid(360.0) / scan.angle_step_rad.to_degrees()).round() as usize;
    scan.beams[index]
}

#[test]
fn a_scan_goes_out_as_soon_as_every_sector_was_heard_with_clockwise_turned_around() {
    let mut bench = Bench::new(false);
    bench.round(100, |sector| f64::from(sector) + 1.0);
    let scans = bench.scans();
    assert_eq!((scans.len(), scans[0].stamp), (1, ms(100)));
    assert_eq!(hit_at(&scans[0], 0.0), Beam::Hit(1.0));
    assert_eq!(hit_at(&scans[0], -90.0), Beam::Hit(3.0), "clockwise 90 degrees is to the right");
    assert_eq!(hit_at(&scans[0], 90.0), Beam::Hit(7.0));
    assert_eq!(hit_at(&scans[0], 45.0), Beam::Clear, "at the greatest range there is nothing");
}

#[test]
fn a_round_with_sectors_missing_ends_with_its_period_and_they_are_unknown() {
    let mut bench = Bench::new(false);
    bench.proximity(100, 0.0, ProximityReading::Good, 2.0);
    bench.proximity(110, 90.0, ProximityReading::NoData, 2.0);
    assert_eq!(bench.host.poll_timeout(), Some((ms(0), "dronecan own status")));
    bench.host.handle_timeout(ms(199));
    assert_eq!(bench.host.poll_timeout(), Some((ms(200), "dronecan scan period")));
    assert_eq!(bench.scans(), []);
    bench.host.handle_timeout(ms(200));
    let scans = bench.scans();
    assert_eq!((scans.len(), scans[0].stamp), (1, ms(100)));
    assert_eq!(scans[0].beams[0], Beam::Hit(2.0));
    assert!(scans[0].beams[1..].iter().all(|beam| *beam == Beam::Unknown));
}

#[test]
fn no_proximity_means_no_scan_when_silence_is_not_clear() {
    let mut bench = Bench::new(false);
    for second in 1..5 {
        bench.status(second * 1_000, Health::Ok, NodeMode::Operational);
        bench.host.handle_timeout(ms(second * 1_000 + 500));
    }
    assert_eq!((bench.scans(), bench.host.counters().scans), (vec![], 0));
}

#[test]
fn silence_is_clear_only_while_node_status_is_fresh() {
    let mut bench = Bench::new(true);
    let clear_at = |bench: &mut Bench, at_ms| {
        bench.host.handle_timeout(ms(at_ms));
        bench.scans().iter().filter(|scan| scan.beams.iter().all(|beam| *beam == Beam::Clear)).count()
    };
    assert_eq!(clear_at(&mut bench, 100), 1);
    assert_eq!(clear_at(&mut bench, 1_400), 1);
    assert_eq!(clear_at(&mut bench, 1_600), 0, "NodeStatus is 1.6 s old");
    assert_eq!(clear_at(&mut bench, 2_900), 0);
    bench.status(3_000, Health::Warning, NodeMode::Operational);
    assert_eq!(clear_at(&mut bench, 3_200), 0, "an ailing node's silence says nothing");
    bench.status(4_000, Health::Ok, NodeMode::Operational);
    assert_eq!(clear_at(&mut bench, 4_200), 1);
}

#[test]
fn an_obstacle_that_slips_out_of_one_round_is_not_gone() {
    let mut bench = Bench::new(true);
    bench.proximity(90, 0.0, ProximityReading::Good, 2.0);
    for (at_ms, ahead) in [(100, Beam::Hit(2.0)), (200, Beam::Hit(2.0)), (300, Beam::Clear)] {
        bench.host.handle_timeout(ms(at_ms));
        assert_eq!(bench.scans()[0].beams[0], ahead, "at {at_ms} ms");
    }
}

#[test]
fn a_broken_transfer_makes_the_silence_of_its_round_unknown() {
    let mut bench = Bench::new(true);
    let id = FrameId::Message { priority: 16, type_id: PROXIMITY_ID, source: LIDAR };
    bench.host.handle_frame(ms(50), &split(id, PROXIMITY_SIGNATURE, 9, &[0; 8])[1]);
    bench.host.handle_timeout(ms(100));
    assert!(bench.scans()[0..].iter().all(|scan| scan.beams[0] == Beam::Unknown));
    bench.proximity(150, 0.0, ProximityReading::Good, 2.0);
    bench.host.handle_timeout(ms(200));
    assert_eq!(bench.scans()[0].beams[1], Beam::Clear);
}

#[test]
fn a_lost_or_sick_node_is_told_and_gives_no_scan() {
    let mut bench = Bench::new(false);
    bench.host.handle_timeout(ms(0));
    let lost = (ms(3_000) + std::time::Duration::from_micros(1), "dronecan node status");
    bench.host.handle_timeout(ms(2_500));
    assert_eq!(bench.host.poll_timeout(), Some(lost));
    bench.host.handle_timeout(lost.0);
    bench.round(3_100, |_| 1.0);
    let text = "lidar node 42: no NodeStatus for 3 s: no scans are taken from it".to_owned();
    assert_eq!(bench.events(), [Event::Text(Severity::Error, text)]);
    bench.status(3_200, Health::Critical, NodeMode::Operational);
    bench.round(3_300, |_| 1.0);
    assert!(matches!(&bench.events()[..], [Event::Text(Severity::Error, text)] if text.contains("health critical")));
    bench.status(3_400, Health::Ok, NodeMode::Operational);
    bench.round(3_500, |_| 1.0);
    assert!(matches!(&bench.events()[..], [Event::Text(Severity::Info, _), Event::Scan(_)]));
}

#[test]
fn no_scan_is_taken_before_the_first_node_status() {
    let mut bench = Bench::new(false);
    bench.host = DronecanLidarHost::new(bench.host_params(), ms(0));
    bench.round(10, |_| 1.0);
    assert_eq!(bench.events(), []);
}

impl Bench {
    fn host_params(&self) -> DronecanLidarParams {
        DronecanLidarParams {
            node: LIDAR,
            own_node: OWN,
            beams: SECTORS,
            range_m_min: 0.1,
            range_m_max: 8.0,
            rate_hz: 10.0,
            silent_is_clear: false,
        }
    }

    fn measurement(&mut self, at_ms: u64, yaw_steps: i8, reading: RangeReading) {
        let measurement = Measurement {
            timestamp_us: 0,
            sensor_id: 0,
            roll_pitch_yaw: [0, 0, yaw_steps],
            orientation_defined: true,
            field_of_view_rad: Some(0.1),
            sensor_type: 2,
            reading,
            range_m: Some(2.25),
        };
        self.send(at_ms, MEASUREMENT_ID, MEASUREMENT_SIGNATURE, &measurement.emit());
    }
}

#[test]
fn a_range_measurement_with_a_direction_is_a_sector_too() {
    let mut bench = Bench::new(false);
    let readings = [RangeReading::Valid, RangeReading::TooClose, RangeReading::TooFar, RangeReading::Undefined];
    for (yaw_steps, reading) in [0, 6, -6, 12].into_iter().zip(readings) {
        bench.measurement(100, yaw_steps, reading);
    }
    bench.host.handle_timeout(ms(200));
    let scan = &bench.scans()[0];
    assert_eq!([hit_at(scan, 0.0), hit_at(scan, -90.0)], [Beam::Hit(2.25), Beam::Hit(0.1)]);
    assert_eq!([hit_at(scan, 90.0), hit_at(scan, 180.0)], [Beam::Clear, Beam::Unknown]);
}

#[test]
fn tools_see_us_once_a_second_and_may_ask_who_we_are() {
    let mut bench = Bench::new(false);
    for at_ms in (0..3_000).step_by(100) {
        bench.host.handle_timeout(ms(at_ms));
    }
    let statuses: Vec<CanFrame> = std::iter::from_fn(|| bench.host.poll_output()).collect();
    assert_eq!(statuses.len(), 3);
    assert!(statuses.iter().all(|frame| frame.id() == CanId::Extended(0x1401_550A)));
    let request = CanFrame::new(CanId::Extended(0x1E01_8AAA), &[0xC2]).unwrap(); // from 42, to us
    bench.host.handle_frame(ms(3_000), &request);
    let mut reassembler = Reassembler::new(1);
    let answer = std::iter::from_fn(|| bench.host.poll_output())
        .find_map(|frame| reassembler.accept(ms(3_000), &frame, |_| Some(GET_NODE_INFO_SIGNATURE)))
        .unwrap();
    let to_asker =
        FrameId::Service { priority: 20, type_id: GET_NODE_INFO_ID, request: false, destination: LIDAR, source: OWN };
    assert_eq!((answer.id, answer.transfer_id), (to_asker, 2));
    assert!(answer.payload.ends_with(b"drover.robot"));
}

#[test]
fn other_nodes_are_not_our_lidar() {
    let mut bench = Bench::new(false);
    let message = Proximity::parse(&[0, 0x40, 0, 0, 0, 0, 0, 0x3C]).unwrap();
    let id = FrameId::Message { priority: 16, type_id: PROXIMITY_ID, source: CanNode(43) };
    for frame in split(id, PROXIMITY_SIGNATURE, 0, &message.emit()) {
        bench.host.handle_frame(ms(10), &frame);
    }
    bench.host.handle_timeout(ms(200));
    assert_eq!(bench.events(), []);
    assert_eq!(bench.host.counters().reassembly.foreign, 2);
}

proptest! {
    #[test]
    fn whatever_the_node_sends_scans_have_all_sectors_and_finite_ranges(
        silent_is_clear: bool,
        messages in prop::collection::vec((0_u64..400, any::<[u8; 8]>(), any::<bool>()), 0..200),
    ) {
        let (mut bench, mut now) = (Bench::new(silent_is_clear), 0);
        for (step_ms, mut payload, good) in messages {
            now += step_ms;
            payload[1] = if good { 0x40 } else { payload[1] };
            bench.send(now, PROXIMITY_ID, PROXIMITY_SIGNATURE, &payload);
            bench.host.handle_timeout(ms(now));
            for scan in bench.scans() {
                prop_assert_eq!(scan.beams.len(), SECTORS as usize);
                let fine = |beam: &Beam| !matches!(beam, Beam::Hit(range_m) if !(0.0..8.0).contains(range_m));
                prop_assert!(scan.beams.iter().all(fine));
                prop_assert!(now <= 3_000, "NodeStatus was lost 3 s after the start");
            }
        }
    }
}
