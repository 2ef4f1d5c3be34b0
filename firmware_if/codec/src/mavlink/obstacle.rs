//! OBSTACLE_DISTANCE (330): 72 distances around the body, to and from a [`Scan`].
//!
//! Layout: `time_usec u64, distances u16[72], min u16, max u16, sensor u8, increment u8 | increment_f f32,
//! angle_offset f32, frame u8` (behind the bar: extensions). Distances are centimetres; 65535 is no reading, max + 1
//! or more is nothing there, and 0 is no reading for ArduPilot and for us. Angles are degrees clockwise from the front
//! (frame 12, BODY_FRD); `increment_f` wins over `increment` and may be negative.

use super::raw::Raw;
use drover_contract::{Beam, Scan, Stamp};
use mavlink::dialects::common::{MavDistanceSensor, MavFrame, OBSTACLE_DISTANCE_DATA};

/// Distances in one message.
pub(crate) const BINS: usize = 72;
const UNKNOWN_CM: u16 = u16::MAX;
const FRAME_BODY_FRD: u8 = 12;
/// An array starts at a sector's edge, as near to this as its step allows: ArduPilot overwrites what is dead ahead if
/// it starts there (its 45 degree sectors are centred on 0).
const OFFSET_DEG: f64 = -20.0;

/// Why a message is no scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoScan {
    /// Its angles are not about the body's front: it would be drawn turned by the heading.
    Frame(u8),
    /// Its step, offset or range make no sense.
    Geometry,
}

/// What a sensor measures if its messages do not say: metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RangeLimits {
    pub(crate) range_m_min: f64,
    pub(crate) range_m_max: f64,
}

/// The scan in the message, in the body frame.
pub(crate) fn decode(stamp: Stamp, payload: &[u8], limits: RangeLimits) -> Result<Scan, NoScan> {
    let raw = Raw(payload);
    let frame = raw.u8(166);
    if frame != FRAME_BODY_FRD {
        return Err(NoScan::Frame(frame));
    }
    let step_f = raw.f32(158);
    let step_deg = if step_f == 0.0 { f64::from(raw.u8(157)) } else { f64::from(step_f) };
    let offset_deg = f64::from(raw.f32(162));
    // NaN fails both.
    if !(step_deg.abs() > 0.0 && step_deg.abs() <= 360.0 && offset_deg.abs() <= 720.0) {
        return Err(NoScan::Geometry);
    }
    let (min_cm, max_cm) = (raw.u16(152), raw.u16(154));
    let range_m_min = if min_cm == 0 { limits.range_m_min } else { f64::from(min_cm) * 0.01 };
    let range_m_max = if max_cm == 0 { limits.range_m_max } else { f64::from(max_cm) * 0.01 };
    if range_m_min >= range_m_max {
        return Err(NoScan::Geometry);
    }
    let count = BINS.min((360.0 / step_deg.abs()).round().max(1.0) as usize);
    let beams = (0..count).map(|index| beam(raw.u16(8 + 2 * index), range_m_max)).collect();
    let (angle_first_rad, angle_step_rad) = (0.0 - offset_deg.to_radians(), 0.0 - step_deg.to_radians());
    Ok(Scan { stamp, angle_first_rad, angle_step_rad, range_m_min, range_m_max, beams })
}

/// A reading nearer than the sensor's least range still is a thing that stands there.
fn beam(distance_cm: u16, range_m_max: f64) -> Beam {
    let range_m = f64::from(distance_cm) * 0.01;
    match distance_cm {
        0 | UNKNOWN_CM => Beam::Unknown,
        _ if range_m > range_m_max + 0.005 => Beam::Clear,
        _ => Beam::Hit(range_m),
    }
}

/// The message that says `scan`: more than 72 beams are thinned to 72 bins, each with the nearest of its hits.
pub(crate) fn encode(time_us: u64, scan: &Scan) -> OBSTACLE_DISTANCE_DATA {
    let step_deg = (scan.angle_step_rad.abs().to_degrees() * scan.beams.len() as f64 / bins(scan) as f64).max(1e-3);
    let offset_deg = offset_deg(scan, step_deg);
    let max_cm = centimetres(scan.range_m_max).min(UNKNOWN_CM - 2);
    let mut distances = [UNKNOWN_CM; BINS];
    let turn = (360.0 / step_deg).round().max(1.0) as i64;
    for (index, beam) in scan.beams.iter().enumerate() {
        let clockwise_deg = 0.0 - scan.angle_rad(index).to_degrees();
        let bin = (((clockwise_deg - offset_deg) / step_deg).round() as i64).rem_euclid(turn) as usize;
        if let Some(cell) = distances.get_mut(bin) {
            *cell = nearer(*cell, *beam, max_cm);
        }
    }
    OBSTACLE_DISTANCE_DATA {
        time_usec: time_us,
        distances,
        min_distance: centimetres(scan.range_m_min),
        max_distance: max_cm,
        sensor_type: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
        increment: step_deg.round().clamp(0.0, 255.0) as u8,
        increment_f: step_deg as f32,
        angle_offset: offset_deg as f32,
        frame: MavFrame::MAV_FRAME_BODY_FRD,
    }
}

/// Where the array starts, degrees clockwise. A full turn may start anywhere; a part of one starts at its own end.
fn offset_deg(scan: &Scan, step_deg: f64) -> f64 {
    let end_deg = |index: usize| 0.0 - scan.angle_rad(index).to_degrees();
    let (first_deg, last_deg) = (end_deg(0), end_deg(scan.beams.len().saturating_sub(1)));
    let is_part = (first_deg - last_deg).abs() + 1.5 * step_deg < 360.0;
    if is_part {
        return first_deg.min(last_deg);
    }
    first_deg + step_deg * ((OFFSET_DEG - first_deg) / step_deg).round()
}

fn bins(scan: &Scan) -> usize {
    scan.beams.len().clamp(1, BINS)
}

fn nearer(cell_cm: u16, beam: Beam, max_cm: u16) -> u16 {
    match beam {
        Beam::Hit(range_m) => cell_cm.min(centimetres(range_m).clamp(1, max_cm)),
        Beam::Clear => cell_cm.min(max_cm + 1),
        Beam::Unknown => cell_cm,
    }
}

fn centimetres(metres: f64) -> u16 {
    (metres * 100.0).round().clamp(0.0, f64::from(u16::MAX)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: RangeLimits = RangeLimits { range_m_min: 0.1, range_m_max: 8.0 };

    fn scan(beams: Vec<Beam>, angle_first_rad: f64) -> Scan {
        let angle_step_rad = std::f64::consts::TAU / beams.len() as f64;
        Scan { stamp: Stamp::ZERO, angle_first_rad, angle_step_rad, range_m_min: 0.1, range_m_max: 8.0, beams }
    }

    /// What arrives of `scan` at the other end.
    fn through(scan: &Scan) -> Scan {
        use mavlink::MessageData;
        let mut payload = [0; 255];
        let length = encode(0, scan).ser(mavlink::MavlinkVersion::V2, &mut payload);
        decode(Stamp::ZERO, &payload[..length], LIMITS).expect("a scan")
    }

    #[test]
    fn a_part_of_a_turn_arrives_whole_whatever_part_it_is() {
        for (beams, fov_deg) in [(72, 270.0), (40, 90.0), (72, 300.0), (11, 180.0)] {
            let step_rad = f64::to_radians(fov_deg) / f64::from(beams - 1);
            let hits = (0..beams).map(|index| Beam::Hit(1.0 + f64::from(index) * 0.05)).collect();
            let mut sent = scan(hits, -f64::to_radians(fov_deg) / 2.0);
            sent.angle_step_rad = step_rad;
            let got = through(&sent);
            for (index, beam) in sent.beams.iter().enumerate() {
                let at = |(other, _): &(usize, &Beam)| {
                    drover_contract::wrap(got.angle_rad(*other) - sent.angle_rad(index)).abs() < step_rad / 10.0
                };
                let arrived = got.beams.iter().enumerate().find(at).map(|(_, beam)| *beam);
                let (Beam::Hit(is_m), Some(Beam::Hit(got_m))) = (*beam, arrived) else {
                    panic!("beam {index} of {beams} over {fov_deg} degrees: {arrived:?}")
                };
                assert!((is_m - got_m).abs() < 0.006);
            }
        }
    }

    /// Direction and range of the nearest hit, degrees to the left.
    fn nearest(scan: &Scan) -> (f64, f64) {
        let hits = scan
            .points_b()
            .map(|(_, point)| (drover_contract::math::atan2(point.y, point.x).to_degrees(), point.norm()));
        hits.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a hit")
    }

    #[test]
    fn a_hit_stays_where_it_was_in_every_direction() {
        for index in 0..72 {
            let mut beams = vec![Beam::Hit(5.0); 72];
            beams[index] = Beam::Hit(2.5);
            let sent = scan(beams, -std::f64::consts::PI + 0.02);
            let (angle, range_m) = nearest(&through(&sent));
            let off = (angle - sent.angle_rad(index).to_degrees()).rem_euclid(360.0);
            assert!(off.min(360.0 - off) < 0.01, "beam {index} is {off} degrees off");
            assert!((range_m - 2.5).abs() < 1e-9);
        }
    }

    #[test]
    fn more_beams_than_bins_keep_the_nearest_of_each_bin() {
        let mut beams = vec![Beam::Clear; 360];
        beams[91] = Beam::Hit(3.0);
        beams[92] = Beam::Hit(2.0);
        beams[200] = Beam::Unknown;
        let got = through(&scan(beams, 0.0));
        assert_eq!(got.beams.len(), 72);
        let (angle, range_m) = nearest(&got);
        assert!((angle - 90.0).abs() < 2.6 && (range_m - 2.0).abs() < 1e-9, "{angle} {range_m}");
        assert_eq!(got.beams.iter().filter(|beam| **beam == Beam::Clear).count(), 71);
    }

    #[test]
    fn what_was_not_measured_does_not_become_clear() {
        let got = through(&scan(vec![Beam::Unknown; 36], 0.0));
        assert_eq!(got.beams, vec![Beam::Unknown; 36]);
        let _ = encode(0, &scan(Vec::new(), 0.0));
    }

    #[test]
    fn angles_and_ranges_without_sense_are_refused() {
        let good = |change: fn(&mut [u8])| {
            let mut payload = [0; 167];
            payload[152..154].copy_from_slice(&20_u16.to_le_bytes());
            payload[154..156].copy_from_slice(&800_u16.to_le_bytes());
            payload[157] = 5;
            payload[166] = FRAME_BODY_FRD;
            change(&mut payload);
            decode(Stamp::ZERO, &payload, LIMITS).map(|scan| scan.beams.len())
        };
        assert_eq!(good(|_| {}), Ok(72));
        assert_eq!(good(|bytes| bytes[157] = 0), Err(NoScan::Geometry));
        assert_eq!(good(|bytes| bytes[158..162].copy_from_slice(&f32::NAN.to_le_bytes())), Err(NoScan::Geometry));
        assert_eq!(good(|bytes| bytes[162..166].copy_from_slice(&f32::INFINITY.to_le_bytes())), Err(NoScan::Geometry));
        assert_eq!(good(|bytes| bytes[152..154].copy_from_slice(&900_u16.to_le_bytes())), Err(NoScan::Geometry));
        assert_eq!(good(|bytes| bytes[166] = 20), Err(NoScan::Frame(20)));
    }
}
