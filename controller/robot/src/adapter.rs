//! One robot's hardware: the host-side codecs, each with the link it speaks over.

use drover_codec::can::agilex::AgilexHost;
use drover_codec::can::dronecan::DronecanLidarHost;
use drover_codec::mavlink::MavHost;
use drover_contract::{CanBus, Event, Link, LinkError, SafeCommand, Stamp};
use serde::{Deserialize, Serialize};
use std::task::{Context, Poll};

/// At most so many messages are read from a link in one turn: a flood must not starve the tick.
const READS_PER_TURN: usize = 256;
/// Longest datagram that a MAVLink peer sends: several frames of at most 280 bytes.
const DATAGRAM_BYTES: usize = 2048;

/// The way to a robot's drive and lidar.
pub enum Adapter {
    /// One MAVLink link to an autopilot, with a lidar bridge on the same link.
    Mavlink {
        /// The protocol.
        host: Box<MavHost>,
        /// The link.
        link: Box<dyn Link>,
    },
    /// Two CAN buses (their bit rates differ).
    Can {
        /// The chassis' protocol.
        drive: Box<AgilexHost>,
        /// The chassis' bus.
        drive_bus: Box<dyn CanBus>,
        /// The lidar's protocol.
        lidar: Box<DronecanLidarHost>,
        /// The lidar's bus.
        lidar_bus: Box<dyn CanBus>,
    },
}

/// What a robot's links have been through.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkCounters {
    /// Messages received (datagrams or frames).
    pub received: u64,
    /// Messages sent.
    pub sent: u64,
    /// Messages that a full queue dropped.
    pub dropped_full: u64,
    /// Other failures to send or receive.
    pub errors: u64,
    /// The newest failure, in words.
    pub last_error: Option<String>,
}

impl LinkCounters {
    fn fail(&mut self, error: &LinkError) {
        match error {
            LinkError::Full => self.dropped_full += 1,
            LinkError::Down(_) | LinkError::Gone(_) | LinkError::Os(_) => self.errors += 1,
        }
        let words = error.to_string();
        if self.last_error.as_ref() != Some(&words) {
            tracing::warn!(error = %words, "link");
            self.last_error = Some(words);
        }
    }
}

impl Adapter {
    /// Read what has come, up to a bound, and let the codecs digest it.
    pub fn receive(&mut self, now: Stamp, counters: &mut LinkCounters) {
        match self {
            Self::Mavlink { host, link } => {
                let mut buf = [0; DATAGRAM_BYTES];
                for _ in 0..READS_PER_TURN {
                    match link.try_recv(&mut buf) {
                        Ok(Some(len)) => {
                            counters.received += 1;
                            host.handle_datagram(now, &buf[..len]);
                        }
                        Ok(None) => break,
                        // A refused datagram shows up once here; what follows it may still be good.
                        Err(error) => counters.fail(&error),
                    }
                }
            }
            Self::Can { drive, drive_bus, lidar, lidar_bus } => {
                receive_frames(drive_bus.as_mut(), counters, |frame| drive.handle_frame(now, frame));
                receive_frames(lidar_bus.as_mut(), counters, |frame| lidar.handle_frame(now, frame));
            }
        }
    }

    /// Let the codecs do what time asks of them.
    pub fn handle_timeout(&mut self, now: Stamp) {
        match self {
            Self::Mavlink { host, .. } => host.handle_timeout(now),
            Self::Can { drive, lidar, .. } => {
                drive.handle_timeout(now);
                lidar.handle_timeout(now);
            }
        }
    }

    /// What the codecs learned, oldest first.
    pub fn poll_event(&mut self) -> Option<Event> {
        match self {
            Self::Mavlink { host, .. } => host.poll_event(),
            Self::Can { drive, lidar, .. } => drive.poll_event().or_else(|| lidar.poll_event()),
        }
    }

    /// Hand a command to the drive's codec.
    pub fn command(&mut self, now: Stamp, command: SafeCommand) {
        match self {
            Self::Mavlink { host, .. } => host.command(now, command),
            Self::Can { drive, .. } => drive.command(now, command),
        }
    }

    /// Stand still, then let go of the drive.
    pub fn shutdown(&mut self, now: Stamp) {
        match self {
            Self::Mavlink { host, .. } => host.shutdown(now),
            Self::Can { drive, .. } => drive.shutdown(now),
        }
    }

    /// Send what the codecs have ready. What cannot be sent now is dropped, never kept (invariant 3).
    pub fn flush(&mut self, counters: &mut LinkCounters) {
        match self {
            Self::Mavlink { host, link } => {
                while let Some(bytes) = host.poll_output() {
                    match link.send(&bytes) {
                        Ok(()) => counters.sent += 1,
                        Err(error) => counters.fail(&error),
                    }
                }
            }
            Self::Can { drive, drive_bus, lidar, lidar_bus } => {
                flush_frames(drive_bus.as_mut(), counters, || drive.poll_output());
                flush_frames(lidar_bus.as_mut(), counters, || lidar.poll_output());
            }
        }
    }

    /// When [`Adapter::handle_timeout`] wants to be called next, and why.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        match self {
            Self::Mavlink { host, .. } => host.poll_timeout(),
            Self::Can { drive, lidar, .. } => [drive.poll_timeout(), lidar.poll_timeout()].into_iter().flatten().min(),
        }
    }

    /// Ready when any link may have something.
    pub fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let ready = match self {
            Self::Mavlink { link, .. } => link.poll_readable(cx).is_ready(),
            // Both are asked, so that both wake us.
            Self::Can { drive_bus, lidar_bus, .. } => {
                let drive = drive_bus.poll_readable(cx).is_ready();
                let lidar = lidar_bus.poll_readable(cx).is_ready();
                drive || lidar
            }
        };
        if ready { Poll::Ready(()) } else { Poll::Pending }
    }
}

fn receive_frames(
    bus: &mut dyn CanBus,
    counters: &mut LinkCounters,
    mut handle: impl FnMut(&drover_contract::CanFrame),
) {
    for _ in 0..READS_PER_TURN {
        match bus.try_recv() {
            Ok(Some(frame)) => {
                counters.received += 1;
                handle(&frame);
            }
            Ok(None) => break,
            Err(error) => {
                counters.fail(&error);
                break;
            }
        }
    }
}

fn flush_frames(
    bus: &mut dyn CanBus,
    counters: &mut LinkCounters,
    mut next: impl FnMut() -> Option<drover_contract::CanFrame>,
) {
    while let Some(frame) = next() {
        match bus.send(&frame) {
            Ok(()) => counters.sent += 1,
            Err(error) => counters.fail(&error),
        }
    }
}
