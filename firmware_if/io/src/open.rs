//! Opening a CAN bus by its address, and what to say when it does not open.

use crate::{SocketCanBus, Tunnel};
use drover_contract::{BusHealth, CanBus, CanFrame, LinkError};
use std::task::{Context, Poll};
use thiserror::Error;

/// A link that could not be opened: which, why, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("cannot open {address}: {why}; {advice}")]
pub struct OpenError {
    /// The address as the configuration gives it.
    pub address: String,
    /// What is wrong.
    pub why: String,
    /// What to do next.
    pub advice: String,
}

impl OpenError {
    /// An error that says all three things.
    #[must_use]
    pub fn new(address: impl Into<String>, why: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { address: address.into(), why: why.into(), advice: advice.into() }
    }
}

/// A CAN bus opened by address.
pub enum CanLink {
    /// An interface of this kernel.
    Kernel(SocketCanBus),
    /// A bus tunnelled over loopback.
    Tunnel(Tunnel),
}

/// Open the CAN bus at `address`: an interface name (`can0`), or `udp:LOCAL_PORT:REMOTE_PORT` for a bus tunnelled over
/// loopback. [`CanLink::open`] does the same and can make a stop sender.
///
/// # Errors
/// [`OpenError`] with what to do.
pub fn open_can(address: &str) -> Result<Box<dyn CanBus>, OpenError> {
    Ok(Box::new(CanLink::open(address)?))
}

impl CanLink {
    /// Open the CAN bus at `address`, as [`open_can`] does.
    ///
    /// # Errors
    /// [`OpenError`] with what to do.
    pub fn open(address: &str) -> Result<Self, OpenError> {
        match Tunnel::ports_of(address)? {
            Some((local, remote)) => Tunnel::open(local, remote).map(Self::Tunnel),
            None => SocketCanBus::open(address).map(Self::Kernel),
        }
    }

    /// A second way onto the same bus, for a thread that must be able to speak when the first user hangs. It only
    /// sends: it receives nothing.
    ///
    /// # Errors
    /// [`OpenError`] as for [`open_can`].
    pub fn stop_sender(&self) -> Result<Box<dyn CanBus>, OpenError> {
        match self {
            Self::Kernel(bus) => Ok(Box::new(bus.send_only()?)),
            Self::Tunnel(tunnel) => Ok(Box::new(tunnel.send_only())),
        }
    }

    fn as_bus(&mut self) -> &mut dyn CanBus {
        match self {
            Self::Kernel(bus) => bus,
            Self::Tunnel(tunnel) => tunnel,
        }
    }
}

impl CanBus for CanLink {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        self.as_bus().try_recv()
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        self.as_bus().send(frame)
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.as_bus().poll_readable(cx)
    }

    fn health(&self) -> BusHealth {
        match self {
            Self::Kernel(bus) => bus.health(),
            Self::Tunnel(tunnel) => tunnel.health(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::CanId;
    use std::time::Duration;

    #[test]
    fn an_address_of_two_ports_opens_a_tunnel_with_a_stop_sender() {
        let (mut far, address) = Tunnel::pair().unwrap();
        let near = CanLink::open(&address).unwrap();
        let frame = CanFrame::new(CanId::Standard(0x111), &[0; 8]).unwrap();
        near.stop_sender().unwrap().send(&frame).unwrap();
        let heard = (0..1_000).find_map(|_| {
            std::thread::sleep(Duration::from_millis(1));
            far.try_recv().unwrap()
        });
        assert_eq!(heard, Some(frame));
    }

    #[test]
    fn an_address_that_is_no_tunnel_is_an_interface_and_a_wrong_one_says_what_to_do() {
        for address in ["no-such-can", "udp:1:2", ""] {
            let error = open_can(address).err().unwrap();
            assert_eq!(error.address, address);
            assert!(!error.advice.is_empty());
        }
    }
}
