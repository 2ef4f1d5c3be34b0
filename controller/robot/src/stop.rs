//! A latched stop, sent to the robots of a swarm over the beacon plane.

use drover_codec::beacon::{encode_stop, swarm_hash};
use drover_config::BeaconPlane;
use drover_contract::{Link, LinkError, RobotId};
use drover_io::{BeaconSocket, OpenError};
use std::time::Duration;
use thiserror::Error;

/// Multicast gets lost: a stop is sent this often.
const REPEATS: u8 = 20;
/// At this distance.
const SPACING: Duration = Duration::from_millis(50);

/// A stop could not be sent.
#[derive(Debug, Error)]
pub enum StopError {
    /// The beacon plane cannot be joined.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A message could not be sent.
    #[error("the stop could not be sent: {0}")]
    Send(#[from] LinkError),
}

/// The stop message for robot `robot` of `swarm`, or for all of them: `seq` tells repeats apart.
#[must_use]
pub fn stop_message(swarm: &str, robot: Option<RobotId>, seq: u8) -> Vec<u8> {
    encode_stop(swarm_hash(swarm), robot, seq)
}

/// Tell robot `robot` of `swarm`, or all of them, to stop at once and for good.
///
/// # Errors
/// [`StopError`] if the plane cannot be joined or a message cannot be sent.
pub async fn send_stop(swarm: &str, plane: &BeaconPlane, robot: Option<RobotId>) -> Result<(), StopError> {
    let mut socket = BeaconSocket::open(&plane.group, plane.port, &plane.interface)?;
    for seq in 0..REPEATS {
        socket.send(&stop_message(swarm, robot, seq))?;
        tokio::time::sleep(SPACING).await;
    }
    Ok(())
}
