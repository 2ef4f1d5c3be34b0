//! A robot's firmware without its bytes: what the codecs would have said, as values.
//!
//! The direct fidelity drives a body through this. It keeps the times of the virtual firmware (when odometry comes,
//! when a scan is complete, when the drive is ready) and leaves out what only the wire adds: quantisation, handshakes,
//! retries. A scan of a robot behind CAN arrives as late as its last sector does.

use crate::chance::{Use, generator};
use crate::firmware::BodyState;
use crate::periodic::Periodic;
use crate::station::scan_turn;
use drover_config::{Drive, Kind, LidarLink};
use drover_contract::{DriveState, Event, Odometry, PoseFix, Scan, Stamp, Twist, Watchdog, WheelTravel};
use rand::Rng;
use std::time::Duration;

/// A chassis on CAN says its odometry this often.
const CHASSIS_ODOMETRY: Duration = Duration::from_millis(20);
/// A DroneCAN lidar spreads a scan's sectors over this share of a period.
const SECTORS_SPREAD: f64 = 0.5;

/// Ideal firmware of one robot.
#[derive(Clone, Debug)]
pub struct IdealDevice {
    /// From when on the drive obeys.
    ready_at: Stamp,
    told_ready: bool,
    odometry_turn: Option<Periodic>,
    odometry_period: Duration,
    /// Whether an autopilot knows the pose; else the wheels are counted.
    knows_pose: bool,
    track_m: f64,
    wheels: Option<(Stamp, WheelTravel)>,
    wheel_twist_b: Twist,
    scan_turn: Periodic,
    scan_delay: Duration,
    scan_on_its_way: Option<(Stamp, Scan)>,
    demand: Twist,
}

impl IdealDevice {
    /// The firmware of robot `id`, switched on at `now`.
    #[must_use]
    pub fn new(kind: &Kind, id: u32, seed: u64, now: Stamp) -> Self {
        let mut rng = generator(seed, u64::from(id), Use::Firmware);
        let _: u64 = rng.random(); // the virtual firmware's own seed: the lidar's phase is then the same as there
        let (knows_pose, odometry_period, ready_after_s) = match kind.drive {
            Drive::Mavlink { telemetry_hz, .. } => {
                (true, Duration::from_secs(1) / telemetry_hz.max(1), kind.sim.prearm_s.max(0.0))
            }
            Drive::AgilexV2 { .. } => (false, CHASSIS_ODOMETRY, 0.0),
        };
        let scan_turn = scan_turn(kind, &mut rng, now);
        Self {
            ready_at: now + Duration::from_secs_f64(ready_after_s),
            told_ready: false,
            odometry_turn: None,
            odometry_period,
            knows_pose,
            track_m: kind.body.track_m,
            wheels: None,
            wheel_twist_b: Twist::ZERO,
            scan_delay: scan_delay(kind, scan_turn.period()),
            scan_turn,
            scan_on_its_way: None,
            demand: Twist::ZERO,
        }
    }

    /// The drive obeys from `at` on and odometry comes from then on: what a handshake on a wire would have taken.
    pub fn set_ready_at(&mut self, at: Stamp) {
        self.ready_at = at;
    }

    /// What the body is asked to do.
    #[must_use]
    pub fn demand(&self) -> Twist {
        self.demand
    }

    /// The robot's command, which the drive obeys once it is ready.
    pub fn command(&mut self, now: Stamp, twist_b: Twist) {
        if now >= self.ready_at {
            self.demand = twist_b;
        }
    }

    /// Go on to `now`: `body` is where it stands, `cast` takes a scan. What the robot is told goes to `tell`.
    pub fn step(&mut self, now: Stamp, body: &BodyState, cast: impl FnOnce() -> Scan, tell: &mut impl FnMut(Event)) {
        self.feel_wheels(now, body.wheels);
        self.tell_motion(now, body, tell);
        if self.scan_turn.take(now) {
            self.scan_on_its_way = Some((now + self.scan_delay, cast()));
        }
        if let Some((_, scan)) = self.scan_on_its_way.take_if(|(due, _)| *due <= now) {
            tell(Event::Scan(scan));
        }
    }

    /// Heap bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let scan = self.scan_on_its_way.as_ref();
        scan.map_or(0, |(_, scan)| scan.beams.capacity() * size_of::<drover_contract::Beam>())
    }

    fn tell_motion(&mut self, now: Stamp, body: &BodyState, tell: &mut impl FnMut(Event)) {
        if now < self.ready_at {
            return;
        }
        let period = self.odometry_period;
        let due = self.odometry_turn.get_or_insert_with(|| Periodic::new(now, period)).take(now);
        if due && self.knows_pose {
            tell(Event::Pose(PoseFix { stamp: now, pose_wb: body.pose_wb }));
            tell(Event::Odometry(Odometry { stamp: now, twist_b: body.twist_b, wheels: None }));
        } else if due {
            tell(Event::Odometry(Odometry { stamp: now, twist_b: self.wheel_twist_b, wheels: Some(body.wheels) }));
        }
        if !std::mem::replace(&mut self.told_ready, true) {
            tell(Event::Drive(DriveState::Ready(Watchdog::Absent)));
        }
    }

    /// How the wheels turn, from how far they have rolled since the last step: what a chassis measures.
    fn feel_wheels(&mut self, now: Stamp, wheels: WheelTravel) {
        if let Some((then, before)) = self.wheels {
            let dt_s = now.since(then).as_secs_f64();
            if dt_s <= 0.0 {
                return;
            }
            let (left_mps, right_mps) =
                ((wheels.left_m - before.left_m) / dt_s, (wheels.right_m - before.right_m) / dt_s);
            self.wheel_twist_b = Twist::new((left_mps + right_mps) / 2.0, (right_mps - left_mps) / self.track_m);
        }
        self.wheels = Some((now, wheels));
    }
}

/// From when the world casts a scan until all of it has arrived.
fn scan_delay(kind: &Kind, period: Duration) -> Duration {
    match kind.lidar.link {
        LidarLink::ObstacleDistance { .. } => Duration::ZERO,
        LidarLink::Dronecan { .. } => {
            let beams = f64::from(kind.lidar.beams.max(1));
            period.mul_f64(SECTORS_SPREAD * (beams - 1.0) / beams)
        }
    }
}
