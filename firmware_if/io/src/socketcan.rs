//! A CAN bus of this kernel, through SocketCAN.
//!
//! The interface may go down, come back, be unplugged and plugged in again: the bus lives on and says so. Opening it
//! anew after it was gone happens inside, at most every [`REOPEN_PERIOD`], whenever somebody reads, writes or waits.

mod state;

use crate::OpenError;
use crate::errno::{EACCES, EAFNOSUPPORT, ENODEV, EPERM, is_nothing_now};
use crate::watched::Watched;
use ::socketcan::{CanAddr, CanFilter, CanSocket, EmbeddedFrame, ExtendedId, Socket, SocketOptions, StandardId};
use drover_contract::{BusHealth, CanBus, CanFrame, CanId, LinkError};
use socket2::{Domain, Protocol, SockAddr, Type};
use state::BusState;
use std::future::Future;
use std::io;
use std::os::fd::OwnedFd;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

/// Between two attempts to open an interface that is gone.
pub(crate) const REOPEN_PERIOD: Duration = Duration::from_millis(250);
/// Frames passed over in one read (error frames, remote frames): a flood of them must not hold the caller.
const PASSED_OVER_MAX: usize = 256;

const AF_CAN: i32 = 29;
const CAN_RAW: i32 = 1;
const FLAG_EXTENDED: u32 = 1 << 31;
const FLAG_REMOTE: u32 = 1 << 30;
const MASK_STANDARD: u32 = 0x7FF;
const MASK_EXTENDED: u32 = 0x1FFF_FFFF;

/// Which data frames a bus takes. Standard and extended identifiers are never mixed up, and remote frames never pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdFilter {
    id: CanId,
    mask: u32,
}

impl IdFilter {
    /// Frames with exactly this identifier.
    #[must_use]
    pub const fn exact(id: CanId) -> Self {
        Self { id, mask: u32::MAX }
    }

    /// Frames of the format of `id` whose identifier has the bits of `id` wherever `mask` has a one.
    #[must_use]
    pub const fn masked(id: CanId, mask: u32) -> Self {
        Self { id, mask }
    }

    /// Identifier and mask as the kernel compares them, with the flags of the format.
    fn raw(self) -> (u32, u32) {
        let (id, mask) = match self.id {
            CanId::Standard(raw) => (u32::from(raw), self.mask & MASK_STANDARD),
            CanId::Extended(raw) => (raw | FLAG_EXTENDED, self.mask & MASK_EXTENDED),
        };
        (id, mask | FLAG_EXTENDED | FLAG_REMOTE)
    }
}

/// What a socket listens to.
#[derive(Clone)]
enum Ear {
    /// Every data frame.
    All,
    /// Data frames that one of these lets pass.
    Some(Vec<IdFilter>),
    /// Nothing: it only sends.
    Deaf,
}

/// A CAN bus of this kernel.
pub struct SocketCanBus {
    interface: String,
    ear: Ear,
    /// `None` while the interface is gone.
    socket: Option<Watched<CanSocket>>,
    state: BusState,
    reopen_at: Instant,
    alarm: Option<Pin<Box<tokio::time::Sleep>>>,
}

impl SocketCanBus {
    /// Open `interface`, for every data frame of others and for error frames. An interface that is down opens, and
    /// says [`LinkError::Down`] until it is up.
    ///
    /// # Errors
    /// [`OpenError`] with what to do if there is no such interface, or no CAN in this kernel.
    pub fn open(interface: &str) -> Result<Self, OpenError> {
        Self::open_with(interface, Ear::All)
    }

    /// Open `interface` for those data frames that one of `filters` lets pass (at most 512 of them).
    ///
    /// # Errors
    /// As [`SocketCanBus::open`].
    pub fn open_filtered(interface: &str, filters: &[IdFilter]) -> Result<Self, OpenError> {
        Self::open_with(interface, Ear::Some(filters.to_vec()))
    }

    /// A second way onto the same bus that hears nothing, for a thread that must be able to speak when this one hangs.
    ///
    /// # Errors
    /// As [`SocketCanBus::open`].
    pub fn send_only(&self) -> Result<Self, OpenError> {
        Self::open_with(&self.interface, Ear::Deaf)
    }

    fn open_with(interface: &str, ear: Ear) -> Result<Self, OpenError> {
        let socket = open_socket(interface, &ear).map_err(|error| explain(interface, &error))?;
        Ok(Self {
            interface: interface.to_owned(),
            ear,
            socket: Some(Watched::new(socket)),
            state: BusState::default(),
            reopen_at: Instant::now(),
            alarm: None,
        })
    }

    /// The socket, opened anew if it was gone and its time has come.
    fn live_socket(&mut self) -> Option<&mut Watched<CanSocket>> {
        // The clock is asked only when it matters: this runs for every frame.
        if self.socket.is_none() && Instant::now() >= self.reopen_at {
            self.reopen_at = Instant::now() + REOPEN_PERIOD;
            if let Ok(socket) = open_socket(&self.interface, &self.ear) {
                tracing::info!(interface = self.interface, "the CAN interface is back");
                self.state.handle_reopened();
                self.socket = Some(Watched::new(socket));
            }
        }
        self.socket.as_mut()
    }

    fn gone(&self) -> LinkError {
        LinkError::Gone(format!("the CAN interface {} is gone; it is opened again when it is back", self.interface))
    }

    /// What an error of the socket means; a socket whose interface is gone is closed.
    fn judge(&mut self, error: &io::Error) -> LinkError {
        match self.state.handle_error(Instant::now(), error) {
            LinkError::Gone(_) => {
                self.socket = None;
                self.reopen_at = Instant::now() + REOPEN_PERIOD;
                self.gone()
            }
            LinkError::Down(_) => {
                let name = &self.interface;
                LinkError::Down(format!(
                    "the CAN interface {name} is down: `ip link set {name} up` (a real one: `ip link set {name} up \
                     type can bitrate 500000 restart-ms 100`)"
                ))
            }
            other @ (LinkError::Full | LinkError::Os(_)) => other,
        }
    }

    /// The frame if it is one for a codec; others are looked at and passed over.
    fn take(&mut self, frame: &::socketcan::CanFrame) -> Option<CanFrame> {
        match frame {
            ::socketcan::CanFrame::Data(data) => {
                self.state.handle_data();
                from_kernel(data)
            }
            ::socketcan::CanFrame::Error(error) => {
                self.state.handle_error_frame(&error.into_error());
                None
            }
            ::socketcan::CanFrame::Remote(_) => None,
        }
    }
}

impl CanBus for SocketCanBus {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        for _ in 0..PASSED_OVER_MAX {
            let Some(socket) = self.live_socket() else { return Ok(None) };
            match socket.try_read(Socket::read_frame) {
                Ok(None) => return Ok(None),
                Ok(Some(frame)) => {
                    if let Some(frame) = self.take(&frame) {
                        return Ok(Some(frame));
                    }
                }
                Err(error) => return Err(self.judge(&error)),
            }
        }
        Ok(None)
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        if self.live_socket().is_none() {
            return Err(self.gone());
        }
        if self.state.is_held() && !self.state.may_send(Instant::now()) {
            return Err(LinkError::Full);
        }
        let Some(frame) = to_kernel(frame) else { return Err(LinkError::Os(format!("{frame} is no CAN frame"))) };
        let Some(socket) = &self.socket else { return Err(self.gone()) };
        match socket.get().write_frame(&frame) {
            Ok(()) => {
                self.state.handle_sent();
                Ok(())
            }
            Err(error) => Err(self.judge(&error)),
        }
    }

    /// Must be called within a tokio runtime that has I/O and time enabled.
    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        loop {
            if let Some(socket) = self.live_socket() {
                return socket.poll_readable(cx);
            }
            let at = tokio::time::Instant::from_std(self.reopen_at);
            let alarm = self.alarm.get_or_insert_with(|| Box::pin(tokio::time::sleep_until(at)));
            if alarm.deadline() != at {
                alarm.as_mut().reset(at);
            }
            if alarm.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
    }

    fn health(&self) -> BusHealth {
        self.state.health()
    }
}

fn from_kernel(frame: &::socketcan::CanDataFrame) -> Option<CanFrame> {
    let id = match frame.id() {
        ::socketcan::Id::Standard(id) => CanId::Standard(id.as_raw()),
        ::socketcan::Id::Extended(id) => CanId::Extended(id.as_raw()),
    };
    CanFrame::new(id, frame.data()).ok()
}

fn to_kernel(frame: &CanFrame) -> Option<::socketcan::CanFrame> {
    match frame.id() {
        CanId::Standard(raw) => ::socketcan::CanFrame::new(StandardId::new(raw)?, frame.data()),
        CanId::Extended(raw) => ::socketcan::CanFrame::new(ExtendedId::new(raw)?, frame.data()),
    }
}

/// Filters are set before the socket is bound: no frame of before them can be waiting in it.
fn open_socket(interface: &str, ear: &Ear) -> io::Result<CanSocket> {
    let raw = raw_socket()?;
    raw.set_nonblocking(true)?;
    let socket = CanSocket::from(OwnedFd::from(raw));
    match ear {
        Ear::All => socket.set_filters(&[CanFilter::new(0, FLAG_REMOTE)])?,
        Ear::Some(filters) => {
            let filters: Vec<_> = filters.iter().map(|filter| CanFilter::from(filter.raw())).collect();
            socket.set_filters(&filters)?;
        }
        Ear::Deaf => socket.set_filter_drop_all()?,
    }
    if !matches!(ear, Ear::Deaf) {
        socket.set_error_filter_accept_all()?;
    }
    socket.set_recv_own_msgs(false)?;
    let address = CanAddr::from_iface(interface)?;
    socket.as_raw_socket().bind(&SockAddr::from(address))?;
    Ok(socket)
}

/// A socket for raw CAN, not yet bound.
pub(crate) fn raw_socket() -> io::Result<socket2::Socket> {
    socket2::Socket::new(Domain::from(AF_CAN), Type::RAW, Some(Protocol::from(CAN_RAW)))
}

/// Say what a failed opening means.
fn explain(interface: &str, error: &io::Error) -> OpenError {
    match error.raw_os_error() {
        Some(EAFNOSUPPORT) => no_can(interface),
        Some(ENODEV) => OpenError::new(
            interface,
            "this computer has no such CAN interface",
            format!(
                "see `ip -brief link`; a real one: `ip link set {interface} up type can bitrate 500000`; a virtual \
                 one: `ip link add dev {interface} type vcan && ip link set {interface} up`"
            ),
        ),
        Some(EPERM | EACCES) => OpenError::new(
            interface,
            "this user may not open raw CAN sockets here",
            "run outside the sandbox, or as a user who may",
        ),
        _ if is_nothing_now(error) => OpenError::new(interface, "the kernel is busy", "try again"),
        _ => OpenError::new(interface, error.to_string(), "see `ip -details link show`"),
    }
}

/// What to do about a kernel without CAN.
pub(crate) fn no_can(interface: &str) -> OpenError {
    OpenError::new(
        interface,
        "this kernel has no CAN",
        "load it with `modprobe can-raw vcan`; where there is no such module, run the command as \
         `tests/with-vcan COMMAND`, or use an address udp:LOCAL_PORT:REMOTE_PORT",
    )
}

#[cfg(test)]
mod tests;
