//! A robot's loop, put together from its file and its hardware.

use crate::adapter::Adapter;
use crate::guard::StopAction;
use crate::params::{KindParams, kind_params, misfit};
use crate::robot_loop::{LoopParts, RobotLoop};
use drover_codec::can::agilex::AgilexHost;
use drover_codec::can::dronecan::DronecanLidarHost;
use drover_codec::mavlink::MavHost;
use drover_config::{Links, RobotFile};
use drover_contract::{CanBus, Clock, Link, Stamp};
use drover_io::{CanLink, OpenError, Recorder, UdpLink, open_can};
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
pub struct Assembly<'a> {
    /// Who it drives and how.
    pub file: RobotFile,
    /// The links to its firmware.
    pub hardware: Hardware,
    /// The beacon plane.
    pub beacons: Box<dyn Link>,
    /// Which life of this robot: greater after every restart.
    pub epoch: u32,
    /// What records its links; none: nothing is recorded.
    pub recorder: Option<&'a Recorder>,
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
/// [`OpenError`] if a recording cannot be made, or the hardware does not fit the robot's kind.
pub fn assemble<C>(assembly: Assembly<'_>, clock: &C) -> Result<Assembled, OpenError>
where
    C: Clock + Clone + Send + Sync + 'static,
{
    let now = clock.now();
    let tick = Duration::from_millis(u64::from(assembly.file.kind.timeouts.tick_ms));
    let recording = Recording { recorder: assembly.recorder, clock, id: assembly.file.robot.id };
    let (adapter, stop) = equip(&assembly.file, assembly.hardware, &recording, now)?;
    let parts = LoopParts { file: assembly.file, adapter, beacons: assembly.beacons, epoch: assembly.epoch };
    Ok(Assembled { robot: RobotLoop::new(parts, now), stop, hang_limit: tick * HANG_TICKS })
}

/// Wraps links into recorders, if there is one.
struct Recording<'a, C> {
    recorder: Option<&'a Recorder>,
    clock: &'a C,
    id: u32,
}

impl<C: Clock + Clone + Send + Sync + 'static> Recording<'_, C> {
    fn link(&self, link: Box<dyn Link>) -> Result<Box<dyn Link>, OpenError> {
        let Some(recorder) = self.recorder else { return Ok(link) };
        Ok(Box::new(recorder.link(&format!("robot-{}", self.id), link, self.clock.clone())?))
    }

    fn bus(&self, bus: Box<dyn CanBus>, which: &str) -> Result<Box<dyn CanBus>, OpenError> {
        let Some(recorder) = self.recorder else { return Ok(bus) };
        Ok(Box::new(recorder.can(&format!("robot-{}-{which}", self.id), bus, self.clock.clone())?))
    }
}

fn equip<C: Clock + Clone + Send + Sync + 'static>(
    file: &RobotFile,
    hardware: Hardware,
    recording: &Recording<'_, C>,
    now: Stamp,
) -> Result<(Adapter, StopAction), OpenError> {
    match (hardware, kind_params(file)?) {
        (Hardware::Mavlink { link, mut stop }, KindParams::Mavlink(params)) => {
            let host = MavHost::new(params, now);
            let bytes = host.stop_bytes().to_vec();
            let action = Box::new(move || stop(&bytes));
            Ok((Adapter::Mavlink { host: Box::new(host), link: recording.link(link)? }, action))
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
                drive_bus: recording.bus(drive_bus, "drive")?,
                lidar: Box::new(DronecanLidarHost::new(lidar, now)),
                lidar_bus: recording.bus(lidar_bus, "lidar")?,
            };
            Ok((adapter, action))
        }
        (Hardware::Mavlink { .. } | Hardware::Can { .. }, KindParams::Mavlink(_) | KindParams::Can(_)) => {
            Err(misfit(file, "its links are not those of its kind's drive"))
        }
    }
}
