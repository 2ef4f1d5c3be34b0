//! Everything on the far side of one robot's links: its virtual firmware, and what is broken there.

use crate::chance::{Use, generator};
use crate::fault::Fault;
use crate::firmware::{
    AgilexSimParams, BodyState, DronecanSimParams, PeerKey, RoverParams, VirtualAgilex, VirtualDronecanLidar,
    VirtualRover,
};
use crate::periodic::Periodic;
use crate::plant::{Packet, Port};
use drover_codec::can::agilex::Model;
use drover_config::{AgilexModel, Drive, Kind, LidarLink};
use drover_contract::{CanNode, Scan, Stamp, Twist};
use rand::Rng;
use rand_pcg::Pcg32;
use std::time::Duration;

/// One robot's firmware.
pub(crate) struct Station {
    firmware: Firmware,
    scan_turn: Periodic,
    link_cut: bool,
    scan_cut: bool,
    /// The button of a rover, whose autopilot does not know of it; a chassis knows of its own.
    rover_estop: bool,
}

/// What stands on the links. Its parts are boxed for their size.
enum Firmware {
    Rover { autopilot: Box<VirtualRover>, has_lidar: bool },
    Chassis { drive: Box<VirtualAgilex>, lidar: Option<LidarNode> },
}

/// A lidar node, and how to start it anew.
struct LidarNode {
    node: Box<VirtualDronecanLidar>,
    params: DronecanSimParams,
    seed: u64,
}

impl Station {
    /// The firmware of the robot `id`, switched on at `now`. Lidars of different robots turn out of step.
    pub(crate) fn new(kind: &Kind, id: u32, seed: u64, now: Stamp) -> Self {
        let mut rng = generator(seed, u64::from(id), Use::Firmware);
        let firmware = match &kind.drive {
            Drive::Mavlink { .. } => rover(kind, id, rng.random(), now),
            Drive::AgilexV2 { model } => chassis(kind, *model, rng.random()),
        };
        let scan_turn = scan_turn(kind, &mut rng, now);
        Self { firmware, scan_turn, link_cut: false, scan_cut: false, rover_estop: false }
    }

    /// Take a message, unless that link is cut. What does not belong on a port is not read.
    pub(crate) fn handle_input(&mut self, now: Stamp, port: Port, from: PeerKey, packet: &Packet) {
        if self.is_cut(port) {
            return;
        }
        match (&mut self.firmware, port, packet) {
            (Firmware::Rover { autopilot, .. }, Port::Autopilot, Packet::Datagram(bytes)) => {
                autopilot.handle_datagram(now, from, bytes);
            }
            (Firmware::Chassis { drive, .. }, Port::DriveBus, Packet::Frame(frame)) => drive.handle_frame(now, frame),
            (Firmware::Chassis { lidar: Some(lidar), .. }, Port::LidarBus, Packet::Frame(frame)) => {
                lidar.node.handle_frame(now, frame);
            }
            (Firmware::Rover { .. } | Firmware::Chassis { .. }, _, _) => {}
        }
    }

    /// Whether the lidar finishes a scan now; it is next due a period later.
    pub(crate) fn take_scan_turn(&mut self, now: Stamp) -> bool {
        if !self.scan_turn.take(now) {
            return false;
        }
        let has_lidar = match &self.firmware {
            Firmware::Rover { has_lidar, .. } => *has_lidar,
            Firmware::Chassis { lidar, .. } => lidar.is_some(),
        };
        has_lidar && !self.scan_cut
    }

    /// Let time pass: `body` is where the body is, `scan` what the lidar has just finished.
    pub(crate) fn step(&mut self, now: Stamp, body: &BodyState, scan: Option<&Scan>) {
        match &mut self.firmware {
            Firmware::Rover { autopilot, .. } => autopilot.step(now, body, scan),
            Firmware::Chassis { drive, lidar } => {
                drive.step(now, body);
                if let Some(lidar) = lidar.as_mut().filter(|_| !self.scan_cut) {
                    lidar.node.step(now, scan);
                }
            }
        }
    }

    /// What the body is asked to do.
    pub(crate) fn demand(&self) -> Twist {
        match &self.firmware {
            Firmware::Rover { .. } if self.rover_estop => Twist::ZERO,
            Firmware::Rover { autopilot, .. } => autopilot.demand(),
            Firmware::Chassis { drive, .. } => drive.demand(),
        }
    }

    /// The next message; what goes onto a link that is cut is lost.
    pub(crate) fn poll_output(&mut self) -> Option<(Port, PeerKey, Packet)> {
        loop {
            let (port, to, packet) = self.firmware.poll_output()?;
            if !self.is_cut(port) {
                return Some((port, to, packet));
            }
        }
    }

    /// Break or mend something.
    pub(crate) fn inject(&mut self, now: Stamp, fault: Fault) {
        match fault {
            Fault::LinkCut => self.link_cut = true,
            Fault::LinkBack => self.link_cut = false,
            Fault::ScanCut => self.scan_cut = true,
            Fault::ScanBack => {
                self.scan_cut = false;
                self.firmware.restart_lidar();
            }
            Fault::PowerCycle => self.firmware.power_cycle(now),
            Fault::RemoteControl(on) => self.firmware.set_remote_control(on),
            Fault::StationMode(custom_mode) => match &mut self.firmware {
                Firmware::Rover { autopilot, .. } => autopilot.station_mode(custom_mode),
                Firmware::Chassis { .. } => {}
            },
            Fault::EStop(pressed) => match &mut self.firmware {
                Firmware::Rover { .. } => self.rover_estop = pressed,
                Firmware::Chassis { drive, .. } => drive.set_estop(pressed),
            },
        }
    }

    fn is_cut(&self, port: Port) -> bool {
        match port {
            Port::Autopilot | Port::DriveBus => self.link_cut,
            Port::LidarBus => self.scan_cut,
        }
    }
}

impl Firmware {
    fn poll_output(&mut self) -> Option<(Port, PeerKey, Packet)> {
        match self {
            Self::Rover { autopilot, .. } => {
                let (to, bytes) = autopilot.poll_output()?;
                Some((Port::Autopilot, to, Packet::Datagram(bytes)))
            }
            Self::Chassis { drive, lidar } => {
                let on_drive_bus = drive.poll_output().map(|frame| (Port::DriveBus, frame));
                let on_lidar_bus = || Some((Port::LidarBus, lidar.as_mut()?.node.poll_output()?));
                let (port, frame) = on_drive_bus.or_else(on_lidar_bus)?;
                Some((port, BUS, Packet::Frame(frame)))
            }
        }
    }

    /// A node that comes back knows nothing of the scan that it was sending when it went.
    fn restart_lidar(&mut self) {
        match self {
            Self::Chassis { lidar: Some(lidar), .. } => {
                *lidar.node = VirtualDronecanLidar::new(lidar.params, lidar.seed);
            }
            Self::Chassis { lidar: None, .. } | Self::Rover { .. } => {}
        }
    }

    fn power_cycle(&mut self, now: Stamp) {
        match self {
            Self::Rover { autopilot, .. } => autopilot.power_cycle(now),
            Self::Chassis { drive, .. } => drive.power_cycle(now),
        }
    }

    fn set_remote_control(&mut self, on: bool) {
        match self {
            Self::Rover { autopilot, .. } if on => autopilot.rc_takeover(),
            Self::Rover { autopilot, .. } => autopilot.rc_release(),
            Self::Chassis { drive, .. } => drive.set_remote_control(on),
        }
    }
}

/// When a lidar finishes its scans: at its rate, from some moment of its first turn on.
pub(crate) fn scan_turn(kind: &Kind, rng: &mut Pcg32, now: Stamp) -> Periodic {
    let period = Duration::from_secs_f64(1.0 / kind.lidar.rate_hz.max(0.1));
    Periodic::new(now + period.mul_f64(rng.random()), period)
}

/// A frame on a bus is for everybody there.
const BUS: PeerKey = PeerKey(0);

/// The configuration lets a MAVLink robot have no id above 250.
fn rover(kind: &Kind, id: u32, seed: u64, now: Stamp) -> Firmware {
    let (has_lidar, lidar_component) = match kind.lidar.link {
        LidarLink::ObstacleDistance { component } => (true, component),
        LidarLink::Dronecan { .. } => (false, 0),
    };
    let params = RoverParams {
        system_id: u8::try_from(id).unwrap_or(u8::MAX),
        lidar_component,
        prearm_after: Duration::from_secs_f64(kind.sim.prearm_s.max(0.0)),
    };
    let mut autopilot = Box::new(VirtualRover::new(params, seed));
    autopilot.power_cycle(now);
    Firmware::Rover { autopilot, has_lidar }
}

fn chassis(kind: &Kind, model: AgilexModel, seed: u64) -> Firmware {
    let drive = Box::new(VirtualAgilex::new(AgilexSimParams::new(model_of(model), kind.body.track_m), seed));
    let lidar = match kind.lidar.link {
        LidarLink::ObstacleDistance { .. } => None,
        LidarLink::Dronecan { node, silent_is_clear } => {
            let params = DronecanSimParams {
                node: CanNode(node),
                sensor_id: 0,
                sectors: kind.lidar.beams,
                rate_hz: kind.lidar.rate_hz,
                silent_is_clear,
            };
            Some(LidarNode { node: Box::new(VirtualDronecanLidar::new(params, seed)), params, seed })
        }
    };
    Firmware::Chassis { drive, lidar }
}

fn model_of(model: AgilexModel) -> Model {
    match model {
        AgilexModel::Scout => Model::Scout,
        AgilexModel::ScoutMini => Model::ScoutMini,
        AgilexModel::Tracer => Model::Tracer,
        AgilexModel::Hunter => Model::Hunter,
        AgilexModel::Bunker => Model::Bunker,
    }
}
