//! The firmware's ends of all links, and what the robots are told to connect to.

use drover_config::{Links, Swarm};
use drover_contract::CanBus;
use drover_io::{MemoryBus, MemoryNode, OpenError, SocketCanBus, Tunnel, UdpServer, VcanInterface};
use drover_world::PeerKey;
use std::net::SocketAddr;
use thiserror::Error;

/// Frames that a simulated bus keeps for a node that does not read.
const BUS_CAPACITY: usize = 4096;
/// Ground stations that one virtual autopilot's socket remembers.
const PEERS_MAX: usize = 32;

/// What stands for the CAN buses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanBacking {
    /// vcan interfaces of this kernel, one a bus.
    Vcan,
    /// Buses in this process' memory.
    Memory,
    /// Buses tunnelled over loopback UDP: for robots in processes of their own where the kernel has no CAN.
    Tunnel,
}

/// What stands for the CAN buses of a run, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanChoice {
    /// What stands for them.
    pub backing: CanBacking,
    /// The same for a person, with the reason if it is not vcan.
    pub words: String,
}

impl CanChoice {
    /// The best there is for `swarm`: vcan if this kernel has it and lets us make interfaces, else memory, or a tunnel
    /// if the robots are `processes`.
    #[must_use]
    pub fn best(swarm: &Swarm, processes: bool) -> Self {
        match vcan_refused(swarm) {
            None => Self { backing: CanBacking::Vcan, words: "vcan interfaces of this kernel".into() },
            Some(why) if processes => {
                Self { backing: CanBacking::Tunnel, words: format!("buses tunnelled over loopback UDP: {why}") }
            }
            Some(why) => Self { backing: CanBacking::Memory, words: format!("buses in memory: {why}") },
        }
    }
}

/// Why the buses of `swarm` cannot be vcan interfaces; none if they can. Tried with the first of them.
fn vcan_refused(swarm: &Swarm) -> Option<String> {
    if !drover_io::kernel_has_can() {
        return Some("this kernel has no CAN".into());
    }
    let interfaces = swarm.robots.iter().filter_map(|robot| match &robot.links {
        Links::Can { drive, .. } if !drive.starts_with("udp:") => Some(drive),
        Links::Can { .. } | Links::Mavlink { .. } => None,
    });
    let first = interfaces.into_iter().next()?;
    VcanInterface::create(first).err().map(|error| format!("{}; for vcan, {}", error.why, error.advice))
}

/// A virtual firmware's link could not be opened.
#[derive(Debug, Error)]
#[error("robot {robot}: {source}")]
pub struct BridgeError {
    /// Whose firmware.
    pub robot: u32,
    /// What went wrong and what to do.
    #[source]
    pub source: OpenError,
}

/// What one robot is to connect to.
pub enum NearSide {
    /// An address for a MAVLink link.
    Mavlink(String),
    /// Two CAN buses.
    Can {
        /// The chassis' bus.
        drive: CanEnd,
        /// The lidar's bus.
        lidar: CanEnd,
    },
}

/// The robot's end of a CAN bus.
pub enum CanEnd {
    /// An address to open: an interface or a tunnel.
    Address(String),
    /// A node of a bus in memory.
    Node(MemoryNode),
}

impl NearSide {
    /// The links of this side as a robot's file says them; a bus in memory has no address.
    #[must_use]
    pub fn links(&self) -> Option<Links> {
        match self {
            Self::Mavlink(autopilot) => Some(Links::Mavlink { autopilot: autopilot.clone() }),
            Self::Can { drive: CanEnd::Address(drive), lidar: CanEnd::Address(lidar) } => {
                Some(Links::Can { drive: drive.clone(), lidar: lidar.clone() })
            }
            Self::Can { .. } => None,
        }
    }
}

/// The firmware's end of one robot's links.
pub(crate) enum FarSide {
    Mavlink { server: UdpServer, peers: PeerTable },
    Can { drive: Box<dyn CanBus>, lidar: Box<dyn CanBus> },
}

/// Which address stands behind a peer key. Bounded: the peer heard longest ago makes room.
#[derive(Default)]
pub(crate) struct PeerTable {
    next: u64,
    peers: Vec<(PeerKey, SocketAddr)>,
}

impl PeerTable {
    pub(crate) fn key_of(&mut self, address: SocketAddr) -> PeerKey {
        if let Some(at) = self.peers.iter().position(|(_, known)| *known == address) {
            let peer = self.peers.remove(at);
            self.peers.push(peer);
            return peer.0;
        }
        if self.peers.len() == PEERS_MAX {
            self.peers.remove(0);
        }
        let key = PeerKey(self.next);
        self.next += 1;
        self.peers.push((key, address));
        key
    }

    pub(crate) fn address_of(&self, key: PeerKey) -> Option<SocketAddr> {
        self.peers.iter().find(|(known, _)| *known == key).map(|(_, address)| *address)
    }
}

/// Interfaces made for a run; they go when this is dropped.
#[derive(Default)]
pub(crate) struct Interfaces(Vec<VcanInterface>);

impl Interfaces {
    fn vcan(&mut self, name: &str) -> Result<Box<dyn CanBus>, OpenError> {
        self.0.push(VcanInterface::create(name)?);
        Ok(Box::new(SocketCanBus::open(name)?))
    }

    /// Open the firmware's end of the links of the swarm's robot `index`.
    pub(crate) fn open(
        &mut self,
        swarm: &Swarm,
        index: usize,
        backing: CanBacking,
    ) -> Result<(FarSide, NearSide), OpenError> {
        match &swarm.robots[index].links {
            Links::Mavlink { autopilot } => open_mavlink(autopilot),
            Links::Can { drive, lidar } => {
                let first_lane = index * 2;
                let (far_drive, drive) = self.open_bus(swarm, drive, backing, first_lane)?;
                let (far_lidar, lidar) = self.open_bus(swarm, lidar, backing, first_lane + 1)?;
                Ok((FarSide::Can { drive: far_drive, lidar: far_lidar }, NearSide::Can { drive, lidar }))
            }
        }
    }

    fn open_bus(
        &mut self,
        swarm: &Swarm,
        address: &str,
        backing: CanBacking,
        lane: usize,
    ) -> Result<(Box<dyn CanBus>, CanEnd), OpenError> {
        if let Some((near, far)) = Tunnel::ports_of(address)? {
            return Ok((Box::new(Tunnel::open(far, near)?), CanEnd::Address(address.to_owned())));
        }
        match backing {
            CanBacking::Vcan => Ok((self.vcan(address)?, CanEnd::Address(address.to_owned()))),
            CanBacking::Memory => {
                let bus = MemoryBus::new(BUS_CAPACITY);
                Ok((Box::new(bus.node()), CanEnd::Node(bus.node())))
            }
            CanBacking::Tunnel => {
                let (near, far) = tunnel_ports(swarm.mavlink_port_base, address, lane)?;
                Ok((Box::new(Tunnel::open(far, near)?), CanEnd::Address(format!("udp:{near}:{far}"))))
            }
        }
    }
}

/// The autopilot's end: the robot's address turned round.
fn open_mavlink(address: &str) -> Result<(FarSide, NearSide), OpenError> {
    let Some(host_port) = address.strip_prefix("udpout:") else {
        let advice = "in a simulation the virtual autopilot is the one that listens: use udpout:127.0.0.1:PORT";
        return Err(OpenError::new(address, "not an address that a robot can speak to first", advice));
    };
    let server = UdpServer::open(host_port)?;
    Ok((FarSide::Mavlink { server, peers: PeerTable::default() }, NearSide::Mavlink(address.to_owned())))
}

/// The two ports of bus number `lane`, the robot's first. They lie above those of all virtual autopilots.
fn tunnel_ports(port_base: u16, address: &str, lane: usize) -> Result<(u16, u16), OpenError> {
    /// Virtual autopilots take the first ports: their ids end at 250.
    const ABOVE_AUTOPILOTS: usize = 256;
    let near = usize::from(port_base) + ABOVE_AUTOPILOTS + 2 * lane;
    match (u16::try_from(near), u16::try_from(near + 1)) {
        (Ok(near), Ok(far)) => Ok((near, far)),
        (Err(_), _) | (_, Err(_)) => {
            let why = format!("its tunnel would need UDP port {near}, and ports end at 65535");
            Err(OpenError::new(address, why, "set a lower mavlink_port_base, or fewer robots"))
        }
    }
}
