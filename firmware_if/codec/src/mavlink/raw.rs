//! Messages that hold enumerations, read at fixed offsets.
//!
//! MAVLink sends a message's fields by falling size, extensions last, and cuts zeros off the end; a byte that is not
//! there is therefore a zero. The typed parse of the `mavlink` crate fails on any enumeration value that it does not
//! know, and every autopilot has some.

/// A payload that reads as zeros behind its end.
#[derive(Clone, Copy)]
pub(crate) struct Raw<'a>(pub(crate) &'a [u8]);

impl Raw<'_> {
    fn bytes<const N: usize>(self, offset: usize) -> [u8; N] {
        std::array::from_fn(|index| self.u8(offset + index))
    }

    pub(crate) fn u8(self, offset: usize) -> u8 {
        self.0.get(offset).copied().unwrap_or(0)
    }

    pub(crate) fn u16(self, offset: usize) -> u16 {
        u16::from_le_bytes(self.bytes(offset))
    }

    pub(crate) fn i16(self, offset: usize) -> i16 {
        i16::from_le_bytes(self.bytes(offset))
    }

    pub(crate) fn u32(self, offset: usize) -> u32 {
        u32::from_le_bytes(self.bytes(offset))
    }

    pub(crate) fn u64(self, offset: usize) -> u64 {
        u64::from_le_bytes(self.bytes(offset))
    }

    pub(crate) fn i64(self, offset: usize) -> i64 {
        i64::from_le_bytes(self.bytes(offset))
    }

    pub(crate) fn f32(self, offset: usize) -> f32 {
        f32::from_le_bytes(self.bytes(offset))
    }
}

/// HEARTBEAT (0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heartbeat {
    pub(crate) custom_mode: u32,
    pub(crate) vehicle_type: u8,
    pub(crate) autopilot: u8,
    pub(crate) base_mode: u8,
}

impl Heartbeat {
    pub(crate) fn read(payload: &[u8]) -> Self {
        let raw = Raw(payload);
        Self { custom_mode: raw.u32(0), vehicle_type: raw.u8(4), autopilot: raw.u8(5), base_mode: raw.u8(6) }
    }

    /// MAV_MODE_FLAG_SAFETY_ARMED.
    pub(crate) const fn armed(self) -> bool {
        self.base_mode & 0x80 != 0
    }
}

/// COMMAND_ACK (77). Senders that know no extensions leave the target 0/0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CommandAck {
    pub(crate) command: u16,
    pub(crate) result: u8,
    pub(crate) target_system: u8,
    pub(crate) target_component: u8,
}

impl CommandAck {
    pub(crate) fn read(payload: &[u8]) -> Self {
        let raw = Raw(payload);
        Self { command: raw.u16(0), result: raw.u8(2), target_system: raw.u8(8), target_component: raw.u8(9) }
    }
}

/// STATUSTEXT (253): one piece of at most 50 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TextPiece<'a> {
    pub(crate) severity: u8,
    /// Without the zeros behind its end.
    pub(crate) text: &'a [u8],
    /// 0: the whole text stands in this piece.
    pub(crate) id: u16,
    pub(crate) chunk: u8,
}

impl<'a> TextPiece<'a> {
    pub(crate) const BYTES_MAX: usize = 50;

    pub(crate) fn read(payload: &'a [u8]) -> Self {
        let raw = Raw(payload);
        let field = payload.get(1..).unwrap_or_default();
        let field = &field[..field.len().min(Self::BYTES_MAX)];
        let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
        Self { severity: raw.u8(0), text: &field[..end], id: raw.u16(51), chunk: raw.u8(53) }
    }
}

/// SYS_STATUS (1), what of it concerns us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SysStatus {
    pub(crate) present: u32,
    pub(crate) health: u32,
    /// Millivolts; 65535: unknown.
    pub(crate) voltage_mv: u16,
    /// Hundredths of an ampere; -1: unknown.
    pub(crate) current_ca: i16,
    /// Percent; -1: unknown.
    pub(crate) remaining: i8,
}

impl SysStatus {
    /// MAV_SYS_STATUS_PREARM_CHECK.
    pub(crate) const PREARM: u32 = 1 << 28;

    pub(crate) fn read(payload: &[u8]) -> Self {
        let raw = Raw(payload);
        Self {
            present: raw.u32(0),
            health: raw.u32(8),
            voltage_mv: raw.u16(14),
            current_ca: raw.i16(16),
            remaining: raw.u8(30) as i8,
        }
    }
}

/// BATTERY_STATUS (147), what of it concerns us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BatteryStatus {
    pub(crate) id: u8,
    /// Sum of the cells that are known, millivolts.
    pub(crate) voltage_mv: Option<u32>,
    pub(crate) current_ca: i16,
    pub(crate) remaining: i8,
}

impl BatteryStatus {
    pub(crate) fn read(payload: &[u8]) -> Self {
        let raw = Raw(payload);
        let cells = (0..10).map(|cell| raw.u16(10 + 2 * cell)).filter(|mv| *mv != u16::MAX);
        let sum: u32 = cells.map(u32::from).sum();
        Self {
            id: raw.u8(32),
            voltage_mv: (sum > 0).then_some(sum),
            current_ca: raw.i16(30),
            remaining: raw.u8(35) as i8,
        }
    }
}

/// DISTANCE_SENSOR (132): one sector of the autopilot's eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DistanceSensor {
    pub(crate) min_cm: u16,
    pub(crate) max_cm: u16,
    pub(crate) current_cm: u16,
    /// MAV_SENSOR_ORIENTATION: 0 ahead, then clockwise by 45 degrees up to 7.
    pub(crate) orientation: u8,
}

impl DistanceSensor {
    pub(crate) fn read(payload: &[u8]) -> Self {
        let raw = Raw(payload);
        Self { min_cm: raw.u16(4), max_cm: raw.u16(6), current_cm: raw.u16(8), orientation: raw.u8(12) }
    }
}
