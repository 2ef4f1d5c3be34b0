//! The sectors of one turn: readings in, beams out.

use drover_contract::{Beam, Stamp};
use std::f64::consts::TAU;
use std::time::Duration;

/// The newest reading of every direction, first sector straight ahead, counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Sectors {
    readings: Vec<Option<Reading>>,
    heard: usize,
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    at: Stamp,
    beam: Beam,
    this_round: bool,
}

impl Sectors {
    /// `count` sectors of a full turn.
    pub(super) fn new(count: u32) -> Self {
        Self { readings: vec![None; count as usize], heard: 0 }
    }

    /// From one sector to the next, radians.
    pub(super) fn step_rad(&self) -> f64 {
        TAU / self.readings.len().max(1) as f64
    }

    /// The sector whose centre is nearest to `bearing_rad`, counter-clockwise from ahead.
    pub(super) fn index(&self, bearing_rad: f64) -> usize {
        let turned = (bearing_rad.rem_euclid(TAU) / self.step_rad()).round() as usize;
        turned % self.readings.len().max(1)
    }

    /// Whether sector `index` was heard in this round.
    pub(super) fn has(&self, index: usize) -> bool {
        self.readings.get(index).copied().flatten().is_some_and(|reading| reading.this_round)
    }

    /// Take a reading. Of two in one round the one that holds the robot back more stays.
    pub(super) fn set(&mut self, index: usize, at: Stamp, beam: Beam) {
        let repeated = self.has(index);
        let Some(slot) = self.readings.get_mut(index) else { return };
        let worst = slot.filter(|_| repeated).map_or(beam, |old| more_cautious(old.beam, beam));
        *slot = Some(Reading { at, beam: worst, this_round: true });
        self.heard += usize::from(!repeated);
    }

    /// Whether every sector was heard in this round.
    pub(super) fn complete(&self) -> bool {
        self.heard == self.readings.len()
    }

    /// Whether any sector was heard in this round.
    pub(super) fn any(&self) -> bool {
        self.heard > 0
    }

    /// The beams of this round, and a new round begins. A sector not heard in it keeps a reading younger than `hold`;
    /// without one it is `silent`.
    pub(super) fn take(&mut self, now: Stamp, hold: Duration, silent: Beam) -> Vec<Beam> {
        self.heard = 0;
        let beam = |slot: &mut Option<Reading>| {
            let reading = slot.filter(|reading| reading.this_round || now.since(reading.at) < hold);
            *slot = reading.map(|reading| Reading { this_round: false, ..reading });
            reading.map_or(silent, |reading| reading.beam)
        };
        self.readings.iter_mut().map(beam).collect()
    }

    /// Forget everything.
    pub(super) fn clear(&mut self) {
        self.heard = 0;
        self.readings.fill(None);
    }
}

fn more_cautious(a: Beam, b: Beam) -> Beam {
    match (a, b) {
        (Beam::Hit(a), Beam::Hit(b)) => Beam::Hit(a.min(b)),
        (Beam::Hit(range_m), _) | (_, Beam::Hit(range_m)) => Beam::Hit(range_m),
        (Beam::Unknown, _) | (_, Beam::Unknown) => Beam::Unknown,
        (Beam::Clear, Beam::Clear) => Beam::Clear,
    }
}

#[cfg(test)]
mod tests {
    use super::Sectors;
    use drover_contract::{Beam, Stamp};
    use std::f64::consts::{PI, TAU};
    use std::time::Duration;

    #[test]
    fn a_bearing_belongs_to_the_sector_with_the_nearest_centre() {
        let sectors = Sectors::new(36);
        let bearings = [0.0, 0.08, 0.09, -0.09, PI, -PI, TAU - 0.01];
        assert_eq!(bearings.map(|bearing| sectors.index(bearing)), [0, 0, 1, 35, 18, 18, 0]);
    }

    #[test]
    fn of_two_readings_in_a_round_the_nearer_one_stays() {
        let mut sectors = Sectors::new(2);
        for beam in [Beam::Clear, Beam::Hit(2.0), Beam::Hit(3.0), Beam::Unknown] {
            sectors.set(0, Stamp::ZERO, beam);
        }
        assert!(sectors.any() && !sectors.complete());
        assert_eq!(sectors.take(Stamp::ZERO, Duration::ZERO, Beam::Unknown), [Beam::Hit(2.0), Beam::Unknown]);
    }

    #[test]
    fn an_unheard_sector_keeps_its_reading_only_while_it_is_young() {
        let mut sectors = Sectors::new(1);
        let hold = Duration::from_millis(200);
        sectors.set(0, Stamp::ZERO, Beam::Hit(1.0));
        let take = |sectors: &mut Sectors, ms| sectors.take(Stamp::from_millis(ms), hold, Beam::Clear);
        assert_eq!(take(&mut sectors, 100), [Beam::Hit(1.0)]);
        assert_eq!(take(&mut sectors, 199), [Beam::Hit(1.0)]);
        assert_eq!(take(&mut sectors, 200), [Beam::Clear]);
    }
}
