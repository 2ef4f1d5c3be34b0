//! A CAN bus over loopback UDP, for robots in processes of their own on a kernel without CAN.
//!
//! The datagrams are cannelloni's, format version 2 (`doc/udp_format.md` of github.com/mguentner/cannelloni), all
//! numbers big-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 1 | version: 2 |
//! | 1 | kind of packet: 0, data |
//! | 1 | sequence number |
//! | 2 | how many frames follow |
//! | 4 | of each frame: identifier with Linux' flags (bit 31 extended, 30 remote, 29 error) |
//! | 1 | of each frame: length, 0..=8; with bit 7 set it is CAN FD and one byte of flags follows |
//! | 0..=64 | of each frame, unless remote: the data |
//!
//! We write one frame a packet, and read any number.

use crate::OpenError;
use crate::errno::link_error;
use crate::udp::{bind, connect_only, explain};
use crate::watched::Watched;
use drover_contract::{BusHealth, CanBus, CanFrame, CanId, LinkError};
use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::task::{Context, Poll};

const VERSION: u8 = 2;
const DATA: u8 = 0;
const HEADER_LEN: usize = 5;
const FLAG_EXTENDED: u32 = 1 << 31;
const FLAG_REMOTE: u32 = 1 << 30;
const FLAG_ERROR: u32 = 1 << 29;
const FLAG_FD: u8 = 0x80;
/// Longest datagram that is read; a longer one is cut and then refused.
const DATAGRAM_MAX: usize = 2048;

const ADVICE: &str = "write udp:LOCAL_PORT:REMOTE_PORT with two different ports from 1024 to 65535";

/// One end of a tunnelled bus. Like a node of a real bus it does not hear itself.
pub struct Tunnel {
    socket: Watched<UdpSocket>,
    sequence: Arc<AtomicU8>,
    heard: VecDeque<CanFrame>,
    health: BusHealth,
}

impl Tunnel {
    /// The local and the remote port of `address`, or `None` if it does not begin with `udp:`.
    ///
    /// # Errors
    /// [`OpenError`] if it begins so and is not a tunnel's address.
    pub fn ports_of(address: &str) -> Result<Option<(u16, u16)>, OpenError> {
        let Some(ports) = address.strip_prefix("udp:") else { return Ok(None) };
        let port = |text: &str| text.parse::<u16>().ok().filter(|port| *port >= 1024);
        let pair = ports.split_once(':').and_then(|(local, remote)| Some((port(local)?, port(remote)?)));
        match pair {
            Some((local, remote)) if local != remote => Ok(Some((local, remote))),
            Some(_) | None => Err(OpenError::new(address, "not a tunnel's address", ADVICE)),
        }
    }

    /// Open the end at `local`; the other end is at `remote`, both on 127.0.0.1.
    ///
    /// # Errors
    /// [`OpenError`] if the local port is taken. It is no error if the other end is not there yet.
    pub fn open(local: u16, remote: u16) -> Result<Self, OpenError> {
        let address = format!("127.0.0.1:{local}");
        let socket = bind(loopback(local)).map_err(|error| explain(&address, &error))?;
        Self::connect(socket, remote).map_err(|error| explain(&address, &error))
    }

    /// A new tunnel over ports that are free: its end that is opened here, and the address at which another process
    /// opens the other one.
    ///
    /// # Errors
    /// [`OpenError`] if the system has no port left.
    pub fn pair() -> Result<(Self, String), OpenError> {
        let explain = |error: std::io::Error| explain("127.0.0.1:0", &error);
        let here = bind(loopback(0)).map_err(explain)?;
        let there = bind(loopback(0)).map_err(explain)?;
        let (here_port, there_port) =
            (here.local_addr().map_err(explain)?.port(), there.local_addr().map_err(explain)?.port());
        drop(there);
        let tunnel = Self::connect(here, there_port).map_err(explain)?;
        Ok((tunnel, format!("udp:{there_port}:{here_port}")))
    }

    fn connect(socket: UdpSocket, remote: u16) -> std::io::Result<Self> {
        connect_only(&socket, loopback(remote))?;
        Ok(Self {
            socket: Watched::new(socket),
            sequence: Arc::default(),
            heard: VecDeque::new(),
            health: BusHealth::default(),
        })
    }

    /// A second way to the other end that only sends, for a thread that must be able to speak when this one hangs.
    #[must_use]
    pub fn send_only(&self) -> impl CanBus + use<> {
        SendOnly { socket: self.socket.share(), sequence: Arc::clone(&self.sequence) }
    }

    fn take(&mut self, datagram: &[u8]) -> Result<(), LinkError> {
        let health = &mut self.health;
        let heard = &mut self.heard;
        parse(datagram, |item| match item {
            Item::Data(frame) => heard.push_back(frame),
            Item::Error => health.error_frames += 1,
            Item::NotClassicData => {}
        })
        .map_err(|malformed| LinkError::Os(format!("not a cannelloni packet: {}", malformed.0)))
    }
}

fn loopback(port: u16) -> SocketAddr {
    (Ipv4Addr::LOCALHOST, port).into()
}

fn send(socket: &UdpSocket, sequence: &AtomicU8, frame: &CanFrame) -> Result<(), LinkError> {
    let mut packet = [0; HEADER_LEN + 4 + 1 + 8];
    let len = emit(sequence.fetch_add(1, Ordering::Relaxed), frame, &mut packet);
    socket.send(&packet[..len]).map(|_len| ()).map_err(|error| link_error(&error))
}

impl CanBus for Tunnel {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        // Packets without a data frame are passed over, a bounded number of them.
        const PACKETS_MAX: usize = 64;
        let mut buf = [0; DATAGRAM_MAX];
        for _ in 0..PACKETS_MAX {
            if let Some(frame) = self.heard.pop_front() {
                return Ok(Some(frame));
            }
            let received = self.socket.try_read(|socket| socket.recv(&mut buf));
            self.health.down = received.is_err();
            match received.map_err(|error| link_error(&error))? {
                Some(len) => self.take(&buf[..len])?,
                None => return Ok(None),
            }
        }
        Ok(None)
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        let sent = send(self.socket.get(), &self.sequence, frame);
        self.health.down = matches!(sent, Err(LinkError::Down(_) | LinkError::Gone(_)));
        self.health.dropped_full += u64::from(sent == Err(LinkError::Full));
        sent
    }

    fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        if self.heard.is_empty() { self.socket.poll_readable(cx) } else { Poll::Ready(()) }
    }

    fn health(&self) -> BusHealth {
        self.health
    }
}

struct SendOnly {
    socket: Arc<UdpSocket>,
    sequence: Arc<AtomicU8>,
}

impl CanBus for SendOnly {
    fn try_recv(&mut self) -> Result<Option<CanFrame>, LinkError> {
        Ok(None)
    }

    fn send(&mut self, frame: &CanFrame) -> Result<(), LinkError> {
        send(&self.socket, &self.sequence, frame)
    }

    fn poll_readable(&mut self, _cx: &mut Context<'_>) -> Poll<()> {
        Poll::Pending
    }

    fn health(&self) -> BusHealth {
        BusHealth::default()
    }
}

/// What stands in a packet.
#[derive(Debug, PartialEq, Eq)]
enum Item {
    /// A classic data frame.
    Data(CanFrame),
    /// An error frame of the other side's controller.
    Error,
    /// A remote frame or one of CAN FD: no codec of ours speaks them.
    NotClassicData,
}

/// Why a packet cannot be read to its end.
#[derive(Debug, PartialEq, Eq)]
struct Malformed(&'static str);

/// Write `frame` as one packet; answers its length.
fn emit(sequence: u8, frame: &CanFrame, packet: &mut [u8; HEADER_LEN + 13]) -> usize {
    let id = match frame.id() {
        CanId::Standard(raw) => u32::from(raw),
        CanId::Extended(raw) => raw | FLAG_EXTENDED,
    };
    let data = frame.data();
    packet[..HEADER_LEN].copy_from_slice(&[VERSION, DATA, sequence, 0, 1]);
    packet[5..9].copy_from_slice(&id.to_be_bytes());
    // A classic frame carries at most 8 bytes.
    packet[9] = data.len() as u8;
    packet[10..10 + data.len()].copy_from_slice(data);
    10 + data.len()
}

/// Read a packet; what stands before a fault in it is good.
fn parse(packet: &[u8], mut found: impl FnMut(Item)) -> Result<(), Malformed> {
    let Some((&[version, kind, _sequence, high, low], mut rest)) = packet.split_first_chunk::<HEADER_LEN>() else {
        return Err(Malformed("shorter than its header"));
    };
    if version != VERSION {
        return Err(Malformed("not version 2"));
    }
    if kind != DATA {
        return Err(Malformed("not a data packet"));
    }
    for _ in 0..u16::from_be_bytes([high, low]) {
        let (item, after) = parse_frame(rest)?;
        found(item);
        rest = after;
    }
    Ok(())
}

fn parse_frame(bytes: &[u8]) -> Result<(Item, &[u8]), Malformed> {
    const CUT: Malformed = Malformed("shorter than its frames");
    let (id, rest) = bytes.split_first_chunk::<4>().ok_or(CUT)?;
    let (&len_field, rest) = rest.split_first().ok_or(CUT)?;
    let id = u32::from_be_bytes(*id);
    let (fd, len) = (len_field & FLAG_FD != 0, usize::from(len_field & !FLAG_FD));
    let rest = if fd { rest.split_first().ok_or(CUT)?.1 } else { rest };
    if len > if fd { 64 } else { 8 } {
        return Err(Malformed("a frame longer than CAN allows"));
    }
    if id & FLAG_REMOTE != 0 {
        return Ok((Item::NotClassicData, rest));
    }
    let (data, rest) = rest.split_at_checked(len).ok_or(CUT)?;
    if id & FLAG_ERROR != 0 {
        return Ok((Item::Error, rest));
    }
    if fd {
        return Ok((Item::NotClassicData, rest));
    }
    let id = if id & FLAG_EXTENDED != 0 {
        CanId::Extended(id & !FLAG_EXTENDED)
    } else {
        CanId::Standard(u16::try_from(id).map_err(|_| Malformed("a standard identifier wider than 11 bits"))?)
    };
    let frame = CanFrame::new(id, data).map_err(|_| Malformed("a standard identifier wider than 11 bits"))?;
    Ok((Item::Data(frame), rest))
}

#[cfg(test)]
mod tests;
