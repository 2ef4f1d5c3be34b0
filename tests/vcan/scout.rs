//! One AgileX chassis with its lidar on two interfaces of this kernel.

use crate::common::{Place, signal};
use crate::support::{Driven, alone, faster_than};
use drover_bridge::{CanEnd, NearSide};
use drover_config::Kind;
use drover_io::kernel_has_can;
use std::process::Command;

/// The scout of the shipped swarm, alone, not driven yet.
pub(crate) struct Scout {
    pub(crate) place: Place,
    /// Interface of its chassis.
    pub(crate) drive: String,
    /// Interface of its lidar.
    pub(crate) lidar: String,
}

impl Scout {
    /// The world with it, its interfaces up.
    pub(crate) fn open() -> Self {
        assert!(kernel_has_can(), "this kernel has no CAN: run tests/run-vcan");
        let folder = tempfile::tempdir().expect("a folder");
        let place = Place::open(alone(folder.path(), 3), folder);
        let NearSide::Can { drive: CanEnd::Address(drive), lidar: CanEnd::Address(lidar) } = &place.near_sides[0]
        else {
            panic!("robot 3 is a CAN robot on interfaces");
        };
        let (drive, lidar) = (drive.clone(), lidar.clone());
        assert!(!drive.contains(':') && !lidar.contains(':'), "tunnels, not interfaces: {drive}, {lidar}");
        Self { place, drive, lidar }
    }

    /// The same, and its process drives it.
    pub(crate) fn driving() -> (Self, Driven) {
        let scout = Self::open();
        let robot = Driven::start(&scout.place.robot_file(0));
        robot.wait_view("it drives", 30.0, faster_than(0.4));
        (scout, robot)
    }

    pub(crate) fn kind(&self) -> &Kind {
        self.place.swarm().kind_of(&self.place.swarm().robots[0])
    }

    /// Its body's speed now, m/s.
    pub(crate) fn speed_mps(&self) -> f64 {
        self.place.speed_mps(0)
    }

    /// How long it brakes from its speed now, s.
    pub(crate) fn braking_s(&self) -> f64 {
        self.speed_mps() / self.kind().motion.brake_mps2
    }

    /// Whether the body touches or has touched a wall.
    pub(crate) fn touched(&self) -> bool {
        self.place.plant.with(|plant| plant.truth(0).gap_wall_m_min.is_some_and(|gap_m| gap_m <= 0.0))
    }
}

/// `ip link set INTERFACE up` or `down`.
pub(crate) fn set_link(interface: &str, state: &str) {
    let done = Command::new("ip").args(["link", "set", interface, state]).status().expect("ip runs");
    assert!(done.success(), "ip link set {interface} {state}");
}

/// Whether a process is there and not a zombie.
pub(crate) fn lives(robot: &Driven) -> bool {
    signal("0", robot.running.id());
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", robot.running.id())).expect("its state");
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim_start().starts_with('Z'))
}
