//! Datagrams over UDP: a link to one peer, and a server with many.

use crate::OpenError;
use crate::errno::{EACCES, EADDRINUSE, EADDRNOTAVAIL, EINVAL, link_error};
use crate::watched::Watched;
use drover_contract::{Link, LinkError};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

/// Between two attempts to connect anew after the network took our address away.
const RECONNECT_PERIOD: Duration = Duration::from_millis(500);

/// Sends bytes over a link from any thread, whatever the link's owner is doing. It drops what cannot be sent now.
pub type StopSender = Box<dyn FnMut(&[u8]) + Send>;

/// A link to one peer.
///
/// `udpout:HOST:PORT` speaks first, from a port of the system's choice, and hears that peer alone.
/// `udpin:HOST:PORT` waits there, and answers whoever spoke last. Datagrams longer than the buffer are cut.
pub struct UdpLink {
    socket: Watched<UdpSocket>,
    shared: Arc<Mutex<Outlet>>,
    side: Side,
}

enum Side {
    /// We speak first, to `peer`. Not connected while the network has no way there.
    Out { peer: SocketAddr, connected: bool, retry_at: Instant },
    /// They speak first; the peer in the outlet is whom we heard last.
    In,
}

/// What a stop sender needs. Locked for moments only, never while anybody waits.
struct Outlet {
    socket: Arc<UdpSocket>,
    peer: Option<SocketAddr>,
}

impl Outlet {
    fn send(&self, bytes: &[u8]) -> io::Result<usize> {
        match self.peer {
            Some(peer) => self.socket.send_to(bytes, peer),
            None => self.socket.send(bytes),
        }
    }
}

fn lock(outlet: &Mutex<Outlet>) -> MutexGuard<'_, Outlet> {
    outlet.lock().unwrap_or_else(PoisonError::into_inner)
}

impl UdpLink {
    /// Open the link at `address`. A host name is looked up now, once.
    ///
    /// # Errors
    /// [`OpenError`] if the address cannot be read or its port is taken. A peer that is not there is no error.
    pub fn open(address: &str) -> Result<Self, OpenError> {
        if let Some(rest) = address.strip_prefix("udpout:") {
            Self::open_out(address, resolve(address, rest)?)
        } else if let Some(rest) = address.strip_prefix("udpin:") {
            Self::open_in(address, resolve(address, rest)?)
        } else {
            Err(OpenError::new(address, "not a UDP address", ADDRESS_ADVICE))
        }
    }

    fn open_out(address: &str, peer: SocketAddr) -> Result<Self, OpenError> {
        let socket = bind(any_port(peer)).map_err(|error| explain(address, &error))?;
        let connected = connect_only(&socket, peer).is_ok();
        let side = Side::Out { peer, connected, retry_at: Instant::now() + RECONNECT_PERIOD };
        Ok(Self::assemble(socket, side))
    }

    fn open_in(address: &str, local: SocketAddr) -> Result<Self, OpenError> {
        let socket = bind(local).map_err(|error| explain(address, &error))?;
        Ok(Self::assemble(socket, Side::In))
    }

    fn assemble(socket: UdpSocket, side: Side) -> Self {
        let socket = Watched::new(socket);
        let shared = Arc::new(Mutex::new(Outlet { socket: socket.share(), peer: None }));
        Self { socket, shared, side }
    }

    /// Where this end is bound.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.socket.get().local_addr()
    }

    /// A second way to the same peer, for a thread that must be able to speak when the owner of this link hangs.
    #[must_use]
    pub fn stop_sender(&self) -> StopSender {
        let (shared, out) = (Arc::clone(&self.shared), matches!(self.side, Side::Out { .. }));
        Box::new(move |bytes| {
            let outlet = lock(&shared);
            if out || outlet.peer.is_some() {
                // There is nobody to tell: the stop is repeated until the owner lives again.
                let _ = outlet.send(bytes);
            }
        })
    }

    fn reconnect(&mut self) -> Result<(), LinkError> {
        let Side::Out { peer, connected, retry_at } = &mut self.side else { return Ok(()) };
        let now = Instant::now();
        if *connected {
            return Ok(());
        }
        if now < *retry_at {
            return Err(LinkError::Down(format!("no way to {peer}")));
        }
        *retry_at = now + RECONNECT_PERIOD;
        let socket = bind(any_port(*peer)).map_err(|error| link_error(&error))?;
        connect_only(&socket, *peer).map_err(|error| link_error(&error))?;
        *connected = true;
        self.socket = Watched::new(socket);
        lock(&self.shared).socket = self.socket.share();
        Ok(())
    }

    /// A connected socket keeps the address it had; when the network no longer knows that one, only a new socket helps.
    fn doubt_connection(&mut self, error: &io::Error) {
        let lost_address = matches!(error.raw_os_error(), Some(EINVAL | EADDRNOTAVAIL));
        if let Side::Out { connected, .. } = &mut self.side {
            *connected &= !lost_address;
        }
    }
}

impl Link for UdpLink {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        match self.side {
            Side::Out { connected: false, .. } => Ok(None),
            Side::Out { .. } => self.socket.try_read(|socket| socket.recv(buf)).map_err(|error| link_error(&error)),
            Side::In => {
                let heard = self.socket.try_read(|socket| socket.recv_from(buf)).map_err(|error| link_error(&error))?;
                if let Some((_, from)) = heard {
                    lock(&self.shared).peer = Some(from);
                }
                Ok(heard.map(|(len, _)| len))
            }
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.reconnect()?;
        let sent = {
            let outlet = lock(&self.shared);
            if matches!(self.side, Side::In) && outlet.peer.is_none() {
                return Err(LinkError::Down("no peer heard yet".into()));
            }
            outlet.send(bytes)
        };
        sent.map(|_len| ()).map_err(|error| {
            self.doubt_connection(&error);
            link_error(&error)
        })
    }

    /// While the network has no way to the peer nothing can come; the next send looks for a way, and after it one asks
    /// again.
    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        match self.side {
            Side::Out { connected: false, .. } => Poll::Pending,
            Side::Out { .. } | Side::In => self.socket.poll_readable(cx),
        }
    }
}

/// The device's side: one port, many peers.
pub struct UdpServer {
    socket: Watched<UdpSocket>,
}

impl UdpServer {
    /// Bind `address` (`HOST:PORT`; port 0 lets the system choose, see [`UdpServer::local_addr`]).
    ///
    /// # Errors
    /// [`OpenError`] if the address cannot be read or its port is taken.
    pub fn open(address: &str) -> Result<Self, OpenError> {
        let local = resolve(address, address)?;
        let socket = bind(local).map_err(|error| explain(address, &error))?;
        Ok(Self { socket: Watched::new(socket) })
    }

    /// Where it is bound.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.socket.get().local_addr()
    }

    /// The next datagram, written to `buf`: its length and sender, or `None` if there is none now.
    ///
    /// # Errors
    /// [`LinkError`]; the caller counts it and goes on.
    pub fn try_recv_from(&mut self, buf: &mut [u8]) -> Result<Option<(usize, SocketAddr)>, LinkError> {
        self.socket.try_read(|socket| socket.recv_from(buf)).map_err(|error| link_error(&error))
    }

    /// Send one datagram to `peer` now, or drop it.
    ///
    /// # Errors
    /// [`LinkError`]; the datagram is then dropped.
    pub fn send_to(&mut self, bytes: &[u8], peer: SocketAddr) -> Result<(), LinkError> {
        self.socket.get().send_to(bytes, peer).map(|_len| ()).map_err(|error| link_error(&error))
    }

    /// Ready when [`UdpServer::try_recv_from`] may have something; else wakes the task later.
    pub fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.socket.poll_readable(cx)
    }
}

const ADDRESS_ADVICE: &str = "write udpout:HOST:PORT (we speak first) or udpin:HOST:PORT (the other side does)";

fn resolve(address: &str, host_port: &str) -> Result<SocketAddr, OpenError> {
    let found = host_port.to_socket_addrs().map_err(|error| OpenError::new(address, error.to_string(), ADDRESS_ADVICE));
    let no_host = || OpenError::new(address, "the host name has no address", "give an address, or fix the name");
    // IPv4 first: autopilots and simulators that say "localhost" listen there.
    let mut all: Vec<_> = found?.collect();
    all.sort_by_key(SocketAddr::is_ipv6);
    all.first().copied().ok_or_else(no_host)
}

fn any_port(peer: SocketAddr) -> SocketAddr {
    match peer {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    }
}

pub(crate) fn bind(local: SocketAddr) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind(local)?;
    socket.set_nonblocking(true)?;
    Ok(socket)
}

/// From now on hear `peer` alone; what others sent between the binding and now is thrown away.
pub(crate) fn connect_only(socket: &UdpSocket, peer: SocketAddr) -> io::Result<()> {
    const STRANGERS_MAX: usize = 1_000;
    socket.connect(peer)?;
    (0..STRANGERS_MAX).take_while(|_| socket.recv(&mut [0; 1]).is_ok()).for_each(drop);
    Ok(())
}

/// Say what a failed bind means.
pub(crate) fn explain(address: &str, error: &io::Error) -> OpenError {
    let port = address.rsplit(':').next().unwrap_or(address);
    match error.raw_os_error() {
        Some(EADDRINUSE) => OpenError::new(
            address,
            format!("UDP port {port} is in use by another program"),
            format!("see which with `ss -ulpn 'sport = :{port}'`, and end it or configure another port"),
        ),
        Some(EACCES) => {
            OpenError::new(address, format!("this user may not use port {port}"), "choose a port from 1024 up")
        }
        Some(EADDRNOTAVAIL) => OpenError::new(
            address,
            "no interface of this computer has that address",
            "see `ip -brief address`; 0.0.0.0 means all of them",
        ),
        _ => OpenError::new(address, error.to_string(), "see `ip -brief address` and `ss -ulpn`"),
    }
}

#[cfg(test)]
mod tests;
