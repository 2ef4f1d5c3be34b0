//! What a DroneCAN frame's 29-bit identifier says.

use drover_contract::{CanId, CanNode};

/// Who speaks about what.
///
/// Message: priority(5) type(16) 0 source(7) · anonymous: priority(5) discriminator(14) type(2) 0 0(7) · service:
/// priority(5) type(8) request(1) destination(7) 1 source(7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FrameId {
    /// A broadcast message.
    Message {
        /// 0 is the highest, 31 the lowest.
        priority: u8,
        /// Its data type.
        type_id: u16,
        /// Its sender.
        source: CanNode,
    },
    /// A message of a node that has no id yet.
    Anonymous {
        /// 0 is the highest, 31 the lowest.
        priority: u8,
        /// 14 bits that keep two such nodes apart.
        discriminator: u16,
        /// The lowest two bits of its data type.
        type_id: u8,
    },
    /// A request to one node, or its answer.
    Service {
        /// 0 is the highest, 31 the lowest.
        priority: u8,
        /// Its data type.
        type_id: u8,
        /// A request, not an answer.
        request: bool,
        /// Whom it is for.
        destination: CanNode,
        /// Who sends it.
        source: CanNode,
    },
}

impl FrameId {
    /// Read an identifier; `None` for a standard one, and for a service that comes from or goes to node 0.
    #[must_use]
    pub fn parse(id: CanId) -> Option<Self> {
        let CanId::Extended(raw) = id else { return None };
        let (priority, source) = ((raw >> 24 & 0x1F) as u8, CanNode((raw & 0x7F) as u8));
        if raw & 0x80 != 0 {
            let destination = CanNode((raw >> 8 & 0x7F) as u8);
            let (type_id, request) = ((raw >> 16 & 0xFF) as u8, raw & 0x8000 != 0);
            let named = source.0 != 0 && destination.0 != 0;
            return named.then_some(Self::Service { priority, type_id, request, destination, source });
        }
        if source.0 == 0 {
            let (discriminator, type_id) = ((raw >> 10 & 0x3FFF) as u16, (raw >> 8 & 3) as u8);
            return Some(Self::Anonymous { priority, discriminator, type_id });
        }
        Some(Self::Message { priority, type_id: (raw >> 8 & 0xFFFF) as u16, source })
    }

    /// The identifier. Values wider than their field are cut to it.
    #[must_use]
    pub fn emit(self) -> CanId {
        let top = |priority: u8| u32::from(priority & 0x1F) << 24;
        let node = |node: CanNode| u32::from(node.0 & 0x7F);
        CanId::Extended(match self {
            Self::Message { priority, type_id, source } => top(priority) | u32::from(type_id) << 8 | node(source),
            Self::Anonymous { priority, discriminator, type_id } => {
                top(priority) | u32::from(discriminator & 0x3FFF) << 10 | u32::from(type_id & 3) << 8
            }
            Self::Service { priority, type_id, request, destination, source } => {
                let kind = u32::from(type_id) << 16 | u32::from(request) << 15;
                top(priority) | kind | node(destination) << 8 | 0x80 | node(source)
            }
        })
    }

    /// The same identifier with priority 0: a transfer's frames belong together whatever their priority.
    #[must_use]
    pub(super) fn without_priority(self) -> Self {
        match self {
            Self::Message { type_id, source, .. } => Self::Message { priority: 0, type_id, source },
            Self::Anonymous { discriminator, type_id, .. } => Self::Anonymous { priority: 0, discriminator, type_id },
            Self::Service { type_id, request, destination, source, .. } => {
                Self::Service { priority: 0, type_id, request, destination, source }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::FrameId;
    use drover_contract::CanId;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_identifier_that_can_be_read_is_written_back_bit_by_bit(raw in 0_u32..=0x1FFF_FFFF) {
            let id = CanId::Extended(raw);
            if let Some(parsed) = FrameId::parse(id) {
                prop_assert_eq!(parsed.emit(), id);
            }
        }
    }

    #[test]
    fn standard_identifiers_and_services_of_node_0_are_not_dronecan() {
        assert_eq!(FrameId::parse(CanId::Standard(0x2A)), None);
        assert_eq!(FrameId::parse(CanId::Extended(0x1E01_AA80)), None);
    }
}
