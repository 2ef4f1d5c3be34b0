//! A robot's loop, put together from its file and its hardware.

use crate::adapter::Adapter;
use crate::guard::StopAction;
use crate::params::{KindParams, kind_params, misfit};
use crate::robot_loop::{LoopParts, RobotLoop};
use crate::witness::Recording;
use drover_codec::can::agilex::AgilexHost;
use drover_codec::can::dronecan::DronecanLidarHost;
use drover_codec::mavlink::MavHost;
use drover_config::{Links, RobotFile};
use drover_contract::{CanBus, Link, Stamp};
use drover_io::{CanLink, OpenError, Tape, TapePort, UdpLink, open_can};
use std::time::Duration;

/// A loop that has not turned for this many ticks hangs.
const HANG_TICKS: u32 = 5;

/// Sends a datagram, from any thread.
pub type DatagramSender = Box<dyn FnMut(&[u8]) + Send>;

/// The links to a robot's firmware, open, each with a second way to send a stop when the loop hangs.
pub enum Hardware {
    /// One MAVLink link.
    Mavlink {
        /// The link.
        link: Box<dyn Link>,
        /// Sends a datagram past the loop.
        stop: DatagramSender,
    },
    /// Two CAN buses.
    Can {
        /// The chassis' bus.
        drive: Box<dyn CanBus>,
        /// The lidar's bus.
        lidar: Box<dyn CanBus>,
        /// The chassis' bus again, to send a frame past the loop.
        stop: Box<dyn CanBus>,
    },
}

impl Hardware {
    /// Open the links as a robot's file gives them.
    ///
    /// # Errors
    /// [`OpenError`]: which link, why, and what to do.
    pub fn open(links: &Links) -> Result<Self, OpenError> {
        match links {
            Links::Mavlink { autopilot } => {
                let link = UdpLink::open(autopilot)?;
                Ok(Self::Mavlink { stop: link.stop_sender(), link: Box::new(link) })
            }
            Links::Can { drive, lidar } => {
                let drive = CanLink::open(drive)?;
                let stop = drive.stop_sender()?;
                Ok(Self::Can { drive: Box::new(drive), lidar: open_can(lidar)?, stop })
            }
        }
    }
}

/// What a robot's loop is assembled from.
pub struct Assembly {
    /// Who it drives and how.
    pub file: RobotFile,
    /// The links to its firmware.
    pub hardware: Hardware,
    /// The beacon plane.
    pub beacons: Box<dyn Link>,
    /// Which life of this robot: greater after every restart.
    pub epoch: u32,
    /// What records it; none: nothing is recorded.
    pub recording: Option<Recording>,
}

/// A loop, and what the guard needs to stop its robot from outside.
pub struct Assembled {
    /// The loop, not turned yet.
    pub robot: RobotLoop,
    /// Sends the robot's stop past the loop.
    pub stop: StopAction,
    /// How long the loop may stand still before the guard does so.
    pub hang_limit: Duration,
}

/// Assemble a loop that begins now.
///
/// # Errors
/// [`OpenError`] if the hardware does not fit the robot's kind.
pub fn assemble(assembly: Assembly, now: Stamp) -> Result<Assembled, OpenError> {
    let Assembly { file, hardware, beacons, epoch, recording } = assembly;
    let tick = Duration::from_millis(u64::from(file.kind.timeouts.tick_ms));
    let tape = recording.as_ref().map(|recording| recording.tape.clone());
    let (adapter, stop) = equip(&file, hardware, tape.as_ref(), now)?;
    let beacons = taped_link(tape.as_ref(), TapePort::Beacons, beacons);
    let parts = LoopParts { file, adapter, beacons, epoch, recording };
    Ok(Assembled { robot: RobotLoop::new(parts, now), stop, hang_limit: tick * HANG_TICKS })
}

fn taped_link(tape: Option<&Tape>, port: TapePort, link: Box<dyn Link>) -> Box<dyn Link> {
    match tape {
        Some(tape) => Box::new(tape.link(port, link)),
        None => link,
    }
}

fn taped_bus(tape: Option<&Tape>, port: TapePort, bus: Box<dyn CanBus>) -> Box<dyn CanBus> {
    match tape {
        Some(tape) => Box::new(tape.bus(port, bus)),
        None => bus,
    }
}

fn equip(
    file: &RobotFile,
    hardware: Hardware,
    tape: Option<&Tape>,
    now: Stamp,
) -> Result<(Adapter, StopAction), OpenError> {
    match (hardware, kind_params(file)?) {
        (Hardware::Mavlink { link, mut stop }, KindParams::Mavlink(params)) => {
            let host = MavHost::new(params, now);
            let bytes = host.stop_bytes().to_vec();
            let action = Box::new(move || stop(&bytes));
            let link = taped_link(tape, TapePort::Autopilot, link);
            Ok((Adapter::Mavlink { host: Box::new(host), link }, action))
        }
        (Hardware::Can { drive: drive_bus, lidar: lidar_bus, stop: mut stop_bus }, KindParams::Can(params)) => {
            let (drive, lidar) = *params;
            let frames = AgilexHost::stop_frames();
            let action = Box::new(move || {
                // A full queue or a bus that is down leaves the drive's own watchdog; the guard tries again soon.
                frames.iter().for_each(|frame| drop(stop_bus.send(frame)));
            });
            let adapter = Adapter::Can {
                drive: Box::new(AgilexHost::new(drive, now)),
                drive_bus: taped_bus(tape, TapePort::DriveBus, drive_bus),
                lidar: Box::new(DronecanLidarHost::new(lidar, now)),
                lidar_bus: taped_bus(tape, TapePort::LidarBus, lidar_bus),
            };
            Ok((adapter, action))
        }
        (Hardware::Mavlink { .. } | Hardware::Can { .. }, KindParams::Mavlink(_) | KindParams::Can(_)) => {
            Err(misfit(file, "its links are not those of its kind's drive"))
        }
    }
}
