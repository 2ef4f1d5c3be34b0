//! Numbers as exactly as anybody looks at them, so that a recording stays small.
//!
//! Lengths, speeds and angles are rounded to multiples of 2^-12 (0.24 mm, 0.014 degrees), ranges to 2^-8 (4 mm): as
//! binary numbers these end in zeros, which take no room when compressed. What was on the wire is recorded to the bit.

use crate::foxglove::Decision;
use crate::moment::{Moment, Place, RobotMoment, ScanMoment};

const PER_UNIT: f64 = 4096.0;
const RANGES_PER_M: f64 = 256.0;

fn coarse(value: f64) -> f64 {
    // A small negative number becomes 0.0 and not -0.0, which protobuf does not carry.
    (value * PER_UNIT).round() / PER_UNIT + 0.0
}

fn coarsen<'a>(values: impl IntoIterator<Item = &'a mut f64>) {
    values.into_iter().for_each(|value| *value = coarse(*value));
}

fn coarsen_place(place: &mut Place) {
    coarsen([&mut place.x_m, &mut place.y_m, &mut place.yaw_rad]);
}

/// The robots and movers of `moment`, rounded; without what else hangs on them.
pub(crate) fn coarse_moment(moment: &Moment) -> Moment {
    let mut robots: Vec<RobotMoment> = moment.robots.clone();
    for robot in &mut robots {
        if let Some(truth) = &mut robot.truth {
            coarsen_place(&mut truth.place);
            coarsen(&mut truth.twist_b);
        }
        robot.believed.iter_mut().for_each(coarsen_place);
        coarsen(robot.twist_b.iter_mut().chain(&mut robot.command_b));
        coarsen(robot.request_b.iter_mut().chain(&mut robot.target_w).flatten());
        coarsen([&mut robot.pos_bound_m, &mut robot.progress]);
        coarsen(robot.nearest_m.iter_mut().chain(&mut robot.charge));
    }
    let mut movers_m = moment.movers_m.clone();
    coarsen(movers_m.iter_mut().flatten());
    Moment { robots, movers_m, ..moment.clone() }
}

/// The scan with ranges rounded.
pub(crate) fn coarse_scan(scan: &ScanMoment) -> ScanMoment {
    let round = |range_m: f64| (range_m * RANGES_PER_M).round() / RANGES_PER_M;
    let ranges_m = scan.ranges_m.iter().map(|range_m| range_m.map(round)).collect();
    ScanMoment { ranges_m, ..scan.clone() }
}

impl Decision {
    /// The same with numbers as a recording holds them.
    #[must_use]
    pub fn coarse(mut self) -> Self {
        coarsen([&mut self.command_speed_mps, &mut self.command_yaw_rate_radps]);
        coarsen([&mut self.x_m, &mut self.y_m, &mut self.yaw_rad, &mut self.pos_bound_m, &mut self.progress]);
        let asked = [&mut self.request_speed_mps, &mut self.request_yaw_rate_radps, &mut self.nearest_m];
        coarsen(asked.into_iter().flatten());
        self
    }
}
