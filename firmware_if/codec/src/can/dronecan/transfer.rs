//! Transfers on classic CAN: tail byte, CRC, and cutting a payload into frames.
//!
//! Up to 7 bytes go in one frame. More go in several: the first begins with the CRC (little-endian), and every frame
//! ends with a tail byte: start(1) end(1) toggle(1) transfer id(5); the toggle is 0 in the first frame.

use super::FrameId;
use crate::can::own;
use drover_contract::CanFrame;

/// Payload bytes in a frame beside its tail byte.
pub(super) const BYTES_PER_FRAME: usize = 7;
/// The longest transfer sent or accepted: GetNodeInfo's answer, the longest of ours, may have 377 bytes.
pub const TRANSFER_MAX: usize = 512;

/// The last byte of every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tail {
    pub(super) start: bool,
    pub(super) end: bool,
    pub(super) toggle: bool,
    pub(super) transfer_id: u8,
}

impl Tail {
    pub(super) fn parse(byte: u8) -> Self {
        let bit = |mask: u8| byte & mask != 0;
        Self { start: bit(0x80), end: bit(0x40), toggle: bit(0x20), transfer_id: byte & 0x1F }
    }

    pub(super) fn emit(self) -> u8 {
        u8::from(self.start) << 7 | u8::from(self.end) << 6 | u8::from(self.toggle) << 5 | self.transfer_id & 0x1F
    }
}

/// CRC-16-CCITT-FALSE over the data type's signature (little-endian) and then `payload`.
#[must_use]
pub fn transfer_crc(signature: u64, payload: &[u8]) -> u16 {
    let bytes = signature.to_le_bytes().into_iter().chain(payload.iter().copied());
    bytes.fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(byte) << 8, |crc, _| if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 })
    })
}

/// Cut `payload` into the frames of one transfer. Bytes beyond [`TRANSFER_MAX`] are left off.
#[must_use]
pub fn split(id: FrameId, signature: u64, transfer_id: u8, payload: &[u8]) -> Vec<CanFrame> {
    let payload = &payload[..payload.len().min(TRANSFER_MAX)];
    if payload.len() <= BYTES_PER_FRAME {
        let tail = Tail { start: true, end: true, toggle: false, transfer_id };
        return vec![frame(id, payload, tail)];
    }
    let mut bytes = transfer_crc(signature, payload).to_le_bytes().to_vec();
    bytes.extend_from_slice(payload);
    let count = bytes.len().div_ceil(BYTES_PER_FRAME);
    let numbered = bytes.chunks(BYTES_PER_FRAME).enumerate();
    let tail = |i: usize| Tail { start: i == 0, end: i + 1 == count, toggle: i % 2 == 1, transfer_id };
    numbered.map(|(i, chunk)| frame(id, chunk, tail(i))).collect()
}

fn frame(id: FrameId, chunk: &[u8], tail: Tail) -> CanFrame {
    let mut data = [0; BYTES_PER_FRAME + 1];
    let len = chunk.len().min(BYTES_PER_FRAME);
    data[..len].copy_from_slice(&chunk[..len]);
    data[len] = tail.emit();
    own(id.emit(), &data[..=len])
}

#[cfg(test)]
mod tests {
    use super::{Tail, transfer_crc};

    #[test]
    fn the_crc_after_a_signature_alone_is_the_published_base() {
        assert_eq!(transfer_crc(0x99DD_3985_FB32_22CE, &[]), 0x96AC);
        assert_eq!(transfer_crc(0x68FF_FE70_FC77_1952, &[]), 0x049C);
        assert_eq!(transfer_crc(0x0F08_68D0_C1A7_C6F1, &[]), 0xBE5F);
    }

    #[test]
    fn every_tail_byte_is_read_and_written_back() {
        for byte in 0..=u8::MAX {
            assert_eq!(Tail::parse(byte).emit(), byte);
        }
    }
}
