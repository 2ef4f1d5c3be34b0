//! What arrived last from the robot's own firmware. The newest replaces all older ones; nothing queues.

use drover_contract::{Battery, DriveState, Scan, Severity, Stamp};
use std::time::Duration;

/// The newest of everything that the estimator does not keep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mailbox {
    /// The newest scan.
    pub(crate) scan: Option<Scan>,
    /// The drive, as last heard.
    pub(crate) drive: DriveState,
    /// The supply, as last heard.
    pub(crate) battery: Option<Battery>,
    /// The newest words for the operator.
    pub(crate) text: Option<(Severity, String)>,
}

impl Mailbox {
    /// Keeps `scan` unless an equally new or newer one is there, or it cannot be read.
    pub(crate) fn put_scan(&mut self, scan: Scan) {
        let newer = self.scan.as_ref().is_none_or(|held| scan.stamp > held.stamp);
        if newer && readable(&scan) {
            self.scan = Some(scan);
        }
    }

    /// The newest scan's age.
    pub(crate) fn scan_age(&self, now: Stamp) -> Option<Duration> {
        self.scan.as_ref().map(|scan| now.since(scan.stamp))
    }
}

/// Whether a scan's numbers make sense. A codec never lets others through; here it costs little to be sure.
fn readable(scan: &Scan) -> bool {
    use drover_contract::Beam::{Clear, Hit, Unknown};
    let finite = scan.angle_first_rad.is_finite() && scan.angle_step_rad.is_finite();
    let beams = scan.beams.iter().all(|beam| match beam {
        Hit(range_m) => range_m.is_finite() && *range_m >= 0.0,
        Clear | Unknown => true,
    });
    finite && scan.angle_step_rad.abs() > 1e-4 && beams
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::Beam;

    fn scan(at_ms: u64, beam: Beam) -> Scan {
        Scan {
            stamp: Stamp::from_millis(at_ms),
            angle_first_rad: 0.0,
            angle_step_rad: 0.1,
            range_m_min: 0.1,
            range_m_max: 8.0,
            beams: vec![beam; 63],
        }
    }

    #[test]
    fn an_older_scan_never_replaces_a_newer_one() {
        let mut mailbox = Mailbox::default();
        mailbox.put_scan(scan(200, Beam::Clear));
        mailbox.put_scan(scan(100, Beam::Hit(1.0)));
        assert_eq!(mailbox.scan.unwrap().beams[0], Beam::Clear);
    }

    #[test]
    fn a_scan_with_a_nan_is_not_taken() {
        let mut mailbox = Mailbox::default();
        mailbox.put_scan(scan(200, Beam::Hit(f64::NAN)));
        assert_eq!(mailbox.scan, None);
        assert_eq!(mailbox.scan_age(Stamp::from_millis(300)), None);
    }
}
