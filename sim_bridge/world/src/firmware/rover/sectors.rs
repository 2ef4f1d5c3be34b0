//! The eight 45 degree sectors that the autopilot makes of a scan.

use drover_codec::mavlink::device::Sector;
use drover_contract::{Beam, Scan, Stamp};
use std::f64::consts::{FRAC_PI_4, TAU};
use std::time::Duration;

/// Without a scan for so long there are no sectors.
const SCAN_AGE_MAX: Duration = Duration::from_millis(500);
const SECTORS: usize = 8;

/// The autopilot's picture of what is around it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sectors {
    seen: Option<Stamp>,
    limits_m: [f64; 2],
    /// Outer: the sector was valid at least once. Inner: something is in it now.
    nearest_m: [Option<Option<f64>>; SECTORS],
}

impl Sectors {
    pub(super) fn handle_scan(&mut self, now: Stamp, scan: &Scan) {
        self.seen = Some(now);
        self.limits_m = [scan.range_m_min, scan.range_m_max];
        let mut fresh = [None; SECTORS];
        for (index, beam) in scan.beams.iter().enumerate() {
            let Beam::Hit(range_m) = beam else { continue };
            let nearest: &mut Option<f64> = &mut fresh[sector_of(scan.angle_rad(index))];
            *nearest = Some(nearest.map_or(*range_m, |so_far| so_far.min(*range_m)));
        }
        for (known, nearest) in self.nearest_m.iter_mut().zip(fresh) {
            if nearest.is_some() || known.is_some() {
                *known = Some(nearest);
            }
        }
    }

    /// Whether a scan came lately.
    pub(super) fn fresh(&self, now: Stamp) -> bool {
        self.seen.is_some_and(|seen| now.since(seen) <= SCAN_AGE_MAX)
    }

    /// The sectors to tell: those that were valid at least once.
    pub(super) fn readings(&self, now: Stamp) -> impl Iterator<Item = Sector> + '_ {
        let [range_m_min, range_m_max] = self.limits_m;
        let known = if self.fresh(now) { &self.nearest_m[..] } else { &[] };
        known.iter().enumerate().filter_map(move |(index, nearest)| {
            nearest.map(|nearest_m| Sector { index: index as u8, nearest_m, range_m_min, range_m_max })
        })
    }
}

/// Sector 0 is the front, give or take 22.5 degrees; then clockwise.
fn sector_of(angle_rad: f64) -> usize {
    let clockwise = (-angle_rad).rem_euclid(TAU);
    ((clockwise / FRAC_PI_4).round() as usize) % SECTORS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(beams: Vec<Beam>) -> Scan {
        let angle_step_rad = TAU / beams.len() as f64;
        Scan { stamp: Stamp::ZERO, angle_first_rad: 0.0, angle_step_rad, range_m_min: 0.2, range_m_max: 8.0, beams }
    }

    #[test]
    fn a_wall_on_the_left_is_in_the_sector_that_points_left() {
        let mut beams = vec![Beam::Clear; 72];
        beams[18] = Beam::Hit(2.0);
        beams[19] = Beam::Hit(1.5);
        let mut sectors = Sectors::default();
        sectors.handle_scan(Stamp::ZERO, &scan(beams));
        let told: Vec<_> = sectors.readings(Stamp::ZERO).collect();
        assert_eq!(told.len(), 1, "sectors that never saw anything stay silent");
        assert_eq!((told[0].index, told[0].nearest_m), (6, Some(1.5)), "270 degrees clockwise");
    }

    #[test]
    fn a_sector_that_empties_is_told_as_empty_and_all_end_half_a_second_after_the_last_scan() {
        let mut sectors = Sectors::default();
        sectors.handle_scan(Stamp::ZERO, &scan(vec![Beam::Hit(3.0); 8]));
        sectors.handle_scan(Stamp::from_millis(100), &scan(vec![Beam::Clear; 8]));
        let told: Vec<_> = sectors.readings(Stamp::from_millis(600)).collect();
        assert_eq!(told.len(), 8);
        assert!(told.iter().all(|sector| sector.nearest_m.is_none()));
        assert_eq!(sectors.readings(Stamp::from_millis(601)).count(), 0);
    }
}
