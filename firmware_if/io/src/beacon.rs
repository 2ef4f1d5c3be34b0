//! Multicast between robots: everybody of the group hears everybody, the sender's own messages too.

use crate::OpenError;
use crate::errno::{EADDRNOTAVAIL, ENODEV, link_error};
use crate::udp::explain;
use crate::watched::Watched;
use drover_contract::{Link, LinkError};
use socket2::{Domain, Protocol, Socket, Type};
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::task::{Context, Poll};

/// One robot's ear and mouth on the beacon plane. Several processes of one computer can share group and port.
pub struct BeaconSocket {
    socket: Watched<UdpSocket>,
    group: SocketAddrV4,
}

impl BeaconSocket {
    /// Join `group` (224.0.0.0/4) at `port`, over the interface that has the address `interface`; 127.0.0.1 keeps
    /// everything on this computer.
    ///
    /// # Errors
    /// [`OpenError`] if an address is none, or the group cannot be joined there.
    pub fn open(group: &str, port: u16, interface: &str) -> Result<Self, OpenError> {
        let address = format!("beacon plane {group}:{port} on {interface}");
        let group: Ipv4Addr = group.parse().map_err(|_| not_a_group(&address, group))?;
        if !group.is_multicast() {
            return Err(not_a_group(&address, &group.to_string()));
        }
        let interface: Ipv4Addr = interface.parse().map_err(|_| no_interface(&address, interface))?;
        let group = SocketAddrV4::new(group, port);
        let socket = join(group, interface).map_err(|error| match error.raw_os_error() {
            Some(ENODEV | EADDRNOTAVAIL) => no_interface(&address, &interface.to_string()),
            _ => explain(&address, &error),
        })?;
        Ok(Self { socket: Watched::new(socket), group })
    }
}

fn join(group: SocketAddrV4, interface: Ipv4Addr) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    socket.set_reuse_address(true)?;
    socket.set_reuse_port(true)?;
    // Without this, Linux also delivers groups that only other sockets of this computer have joined.
    socket.set_multicast_all_v4(false)?;
    socket.set_multicast_loop_v4(true)?;
    socket.set_multicast_if_v4(&interface)?;
    // Bound to the group, not to every address: a unicast datagram to this port is not a beacon.
    socket.bind(&group.into())?;
    socket.join_multicast_v4(group.ip(), &interface)?;
    Ok(socket.into())
}

fn not_a_group(address: &str, group: &str) -> OpenError {
    OpenError::new(
        address,
        format!("{group} is not an IPv4 multicast group"),
        "set beacon.group to one of 239.0.0.0 to 239.255.255.255",
    )
}

fn no_interface(address: &str, interface: &str) -> OpenError {
    OpenError::new(
        address,
        format!("no interface of this computer has the address {interface}"),
        "set beacon.interface to one that `ip -brief -4 address` shows; 127.0.0.1 for one computer alone",
    )
}

impl Link for BeaconSocket {
    fn try_recv(&mut self, buf: &mut [u8]) -> Result<Option<usize>, LinkError> {
        self.socket.try_read(|socket| socket.recv(buf)).map_err(|error| link_error(&error))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.socket.get().send_to(bytes, self.group).map(|_len| ()).map_err(|error| link_error(&error))
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        self.socket.poll_readable(cx)
    }
}

#[cfg(test)]
mod tests;
