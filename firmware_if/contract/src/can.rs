//! A classic CAN data frame, as codecs see it.

use std::fmt;
use thiserror::Error;

/// The identifier of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CanId {
    /// 11 bits.
    Standard(u16),
    /// 29 bits.
    Extended(u32),
}

/// A frame that classic CAN cannot carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CanFrameError {
    /// More than eight bytes.
    #[error("a classic CAN frame carries at most 8 bytes, not {0}")]
    TooLong(usize),
    /// An identifier wider than its format.
    #[error("identifier {0:?} is wider than its format allows (11 or 29 bits)")]
    IdRange(CanId),
}

/// A classic data frame. Remote and error frames never reach a codec: the bus counts them.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: CanId,
    len: u8,
    bytes: [u8; 8],
}

impl CanFrame {
    /// A frame with `data`.
    ///
    /// # Errors
    /// [`CanFrameError`] if the data or the identifier does not fit.
    pub fn new(id: CanId, data: &[u8]) -> Result<Self, CanFrameError> {
        let fits = match id {
            CanId::Standard(raw) => raw <= 0x7FF,
            CanId::Extended(raw) => raw <= 0x1FFF_FFFF,
        };
        if !fits {
            return Err(CanFrameError::IdRange(id));
        }
        if data.len() > 8 {
            return Err(CanFrameError::TooLong(data.len()));
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Ok(Self { id, len: data.len() as u8, bytes })
    }

    /// Who it is addressed to or comes from.
    #[must_use]
    pub const fn id(&self) -> CanId {
        self.id
    }

    /// The bytes.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }
}

impl fmt::Display for CanFrame {
    /// As candump logs write it: `111#0096000000000000`, `1055962A#496B0140A0510083`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            CanId::Standard(raw) => write!(f, "{raw:03X}#")?,
            CanId::Extended(raw) => write!(f, "{raw:08X}#")?,
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl fmt::Debug for CanFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
