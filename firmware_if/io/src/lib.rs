//! The only crate that opens a socket. Everything here stands behind the contract's traits `Clock`, `Link` and
//! `CanBus`, so that a robot cannot tell a socket from memory, nor notice a recorder or a middleman around it.
//!
//! | what | for |
//! |---|---|
//! | [`UdpLink`], [`UdpServer`] | MAVLink to an autopilot; the device side with many peers |
//! | [`SocketCanBus`], [`VcanInterface`] | a CAN bus of this kernel; interfaces made for a run |
//! | [`Tunnel`] | a CAN bus over loopback UDP where the kernel has none |
//! | [`BeaconSocket`] | multicast between robots |
//! | [`MemoryBus`], [`memory_link`] | the same without an operating system, also in virtual time |
//! | [`Tape`], [`Faulty`] | links around links: write everything down; lose some of it |
//!
//! Nothing here blocks: every call answers at once, and what cannot be sent now is dropped, never kept (invariant 3).
//! Sockets are watched through tokio only when somebody asks `poll_readable`; everything else works without a runtime.

mod beacon;
mod clock;
mod errno;
mod faulty;
mod listen;
mod memory;
mod open;
mod socketcan;
mod tape;
mod tunnel;
mod udp;
mod vcan;
mod watched;

pub use crate::socketcan::{IdFilter, SocketCanBus};
pub use beacon::BeaconSocket;
pub use clock::{ManualClock, OsClock, PacedClock};
pub use faulty::{FaultHandle, Faulty};
pub use listen::listen;
pub use memory::{MemoryBus, MemoryLink, MemoryNode, memory_link};
pub use open::{CanLink, OpenError, open_can};
pub use tape::{MemoryTapes, Tape, TapeEntry, TapeEvent, TapePort, TapeSink, Taped, WireFiles, frame_bytes, frame_of};
pub use tunnel::Tunnel;
pub use udp::{StopSender, UdpLink, UdpServer};
pub use vcan::{VcanInterface, kernel_has_can};
