//! Ways to move bytes and CAN frames, and the clock. Sockets stand behind these; so do memory and middlemen.

use crate::{CanFrame, Stamp};
use std::task::{Context, Poll};
use std::time::Duration;
use thiserror::Error;

/// Where a robot's time comes from.
pub trait Clock {
    /// The present moment, never before an earlier answer.
    fn now(&self) -> Stamp;

    /// How long the wall clock takes for `span` of this clock's time: the same, unless time is paced.
    fn wall(&self, span: Duration) -> Duration {
        span
    }
}

/// Why a link did not do what was asked. Losing a link is a normal state with a way back, never the end.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkError {
    /// The other side or the interface is away for now; keep trying.
    #[error("link down: {0}")]
    Down(String),
    /// The interface is gone: the link must be opened anew.
    #[error("link gone: {0}")]
    Gone(String),
    /// The queue is full: this message was dropped, not kept (invariant 3).
    #[error("link queue full: message dropped")]
    Full,
    /// Anything else that the operating system said.
    #[error("link error: {0}")]
    Os(String),
}

/// A point-to-point way for datagrams. Nothing here blocks.
pub trait Link: Send {
    /// The next datagram, written to `buf`: its length, or `None` if there is none now.
    ///
    /// # Errors
    /// [`LinkError`]; the caller counts it and goes on.
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError>;

    /// Send one datagram now, or drop it.
    ///
    /// # Errors
    /// [`LinkError`]; the datagram is then dropped, never queued for later.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError>;

    /// Ready when `try_recv` may have something; else wakes the task later. Virtual time never asks.
    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()>;
}

/// A CAN bus, seen from one node. Nothing here blocks.
pub trait CanBus: Send {
    /// The next data frame that another node sent, or `None` if there is none now.
    ///
    /// # Errors
    /// [`LinkError`]; the caller counts it and goes on.
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError>;

    /// Send one frame now, or drop it.
    ///
    /// # Errors
    /// [`LinkError`]; the frame is then dropped, never queued for later.
    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError>;

    /// Ready when `try_recv` may have something; else wakes the task later. Virtual time never asks.
    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()>;

    /// What the bus has been through.
    fn health(&self) -> BusHealth;
}

/// What a bus has been through since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusHealth {
    /// Frames dropped because the transmit queue was full (ENOBUFS).
    pub dropped_full: u64,
    /// Error frames received.
    pub error_frames: u64,
    /// The controller has left the bus and has not come back.
    pub bus_off: bool,
    /// The controller is error-passive: nobody acknowledges, or the wiring is bad.
    pub error_passive: bool,
    /// The interface is down or gone.
    pub down: bool,
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        (**self).try_recv(buf)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        (**self).send(bytes)
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        (**self).poll_readable(cx)
    }
}

impl<B: CanBus + ?Sized> CanBus for Box<B> {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        (**self).try_recv()
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        (**self).send(frame)
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        (**self).poll_readable(cx)
    }

    fn health(&self) -> BusHealth {
        (**self).health()
    }
}
