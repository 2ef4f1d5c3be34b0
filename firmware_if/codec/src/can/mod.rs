//! What stands on the other side of a CAN bus.

pub mod agilex;
pub mod dronecan;
mod queue;
#[cfg(test)]
mod testing;

use drover_contract::{CanFrame, CanId};

/// A standard frame of `data` under one of this crate's own identifiers: 11 bits at most, so it always fits.
fn standard<const N: usize>(id: u16, data: [u8; N]) -> CanFrame {
    const { assert!(N <= 8, "classic CAN carries eight bytes") };
    own(CanId::Standard(id & 0x7FF), &data)
}

/// A frame that this crate made itself, from an identifier within its width and at most eight bytes.
fn own(id: CanId, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).expect("identifiers are masked to their width and data is at most eight bytes")
}
