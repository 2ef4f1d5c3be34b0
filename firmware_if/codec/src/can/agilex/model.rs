//! What differs from one chassis to the next: mode byte, error bits, scales, limits.

/// Chassis whose tables are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Scout 2.0.
    Scout,
    /// Scout Mini.
    ScoutMini,
    /// Tracer.
    Tracer,
    /// Hunter: Ackermann steering, listed for its tables.
    Hunter,
    /// Bunker: its own manual was not at hand; it is taken to share the Scout's tables, as in ugv_sdk.
    Bunker,
}

/// Who commands the chassis: byte 1 of frame 0x211.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Nobody: only a mode command is obeyed.
    Standby,
    /// The CAN bus: us.
    Can,
    /// The serial port.
    Uart,
    /// The remote control, which has the highest authority.
    RemoteControl,
    /// A value that this model's manual does not list.
    Other(u8),
}

impl Mode {
    /// Its name, for operators.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Standby => "standby",
            Self::Can => "CAN control",
            Self::Uart => "serial control",
            Self::RemoteControl => "remote control",
            Self::Other(_) => "an unlisted mode",
        }
    }
}

/// Names of error bits, bit 0 first; `None` where the manual says "reserved".
type BitNames = [Option<&'static str>; 8];

const SCOUT_ERRORS_BYTE_4: BitNames = [
    Some("battery undervoltage fault"),
    Some("battery undervoltage warning"),
    Some("remote control lost"),
    None,
    None,
    None,
    None,
    None,
];
const HUNTER_ERRORS_BYTE_4: BitNames = [
    None,
    Some("steering encoder fault"),
    Some("remote control lost"),
    None,
    Some("host communication lost"),
    None,
    Some("motor driver fault"),
    None,
];
const HUNTER_ERRORS_BYTE_5: BitNames = [
    Some("battery undervoltage"),
    None,
    None,
    Some("steering motor communication lost"),
    Some("rear right motor communication lost"),
    Some("rear left motor communication lost"),
    Some("motor driver over-temperature"),
    Some("over-current"),
];
const RESERVED: BitNames = [None; 8];
const SCOUT_MOTOR_STATE: BitNames = [
    Some("undervoltage"),
    Some("motor over-temperature"),
    Some("over-current"),
    Some("driver over-temperature"),
    Some("CAN lost"),
    Some("driver fault"),
    None,
    None,
];
const HUNTER_MOTOR_STATE: BitNames = [
    Some("undervoltage"),
    Some("motor over-temperature"),
    Some("over-current"),
    Some("driver over-temperature"),
    Some("sensor fault"),
    Some("driver fault"),
    Some("disabled"),
    Some("reset"),
];

impl Model {
    /// What `byte` of 0x211 means. Only 1 means the same on every chassis.
    #[must_use]
    pub const fn mode(self, byte: u8) -> Mode {
        match (self, byte) {
            (_, 1) => Mode::Can,
            (Self::Tracer, 0) | (Self::Hunter, 2) => Mode::RemoteControl,
            (Self::Scout | Self::ScoutMini | Self::Bunker, 3) => Mode::RemoteControl,
            (Self::Scout | Self::ScoutMini | Self::Bunker | Self::Hunter, 0) => Mode::Standby,
            (Self::Scout | Self::ScoutMini | Self::Bunker | Self::Tracer, 2) => Mode::Uart,
            (_, other) => Mode::Other(other),
        }
    }

    /// Whether remote control is also what the mode byte shows right after power-on: the Tracer lists no standby.
    #[must_use]
    pub const fn starts_in_remote_control(self) -> bool {
        matches!(self, Self::Tracer)
    }

    /// Names of the bits set in the error field of 0x211, `bits` being byte 4 then byte 5, big-endian.
    ///
    /// By the manuals of each chassis; ugv_sdk reads the same 16 bits with one mask for all, which on a Scout would
    /// take an undervoltage fault for a driver fault.
    pub fn error_names(self, bits: u16) -> impl Iterator<Item = &'static str> {
        let [byte_4, byte_5] = bits.to_be_bytes();
        let (names_4, names_5) = match self {
            Self::Scout | Self::ScoutMini | Self::Tracer | Self::Bunker => (&SCOUT_ERRORS_BYTE_4, &RESERVED),
            Self::Hunter => (&HUNTER_ERRORS_BYTE_4, &HUNTER_ERRORS_BYTE_5),
        };
        set_bits(byte_4, names_4).chain(set_bits(byte_5, names_5))
    }

    /// Names of the bits set in a motor's state byte (byte 5 of 0x261..0x268).
    pub fn motor_fault_names(self, state: u8) -> impl Iterator<Item = &'static str> {
        let names = match self {
            Self::Scout | Self::ScoutMini | Self::Tracer | Self::Bunker => &SCOUT_MOTOR_STATE,
            Self::Hunter => &HUNTER_MOTOR_STATE,
        };
        set_bits(state, names)
    }

    /// Volts per count of the battery monitor (0x361).
    #[must_use]
    pub const fn bms_volts_per_count(self) -> f64 {
        match self {
            Self::Scout | Self::ScoutMini | Self::Tracer | Self::Bunker => 0.1,
            Self::Hunter => 0.01,
        }
    }

    /// Fastest that a wheel can go, m/s, generously: a greater step of the odometer was not driven. Twice the chassis'
    /// own top speed, to leave room for turning on the spot and for wheels that slip.
    #[must_use]
    pub const fn wheel_mps_bound(self) -> f64 {
        match self {
            Self::Scout | Self::Hunter => 3.0,
            Self::Tracer => 4.6, // 2.3 m/s without a load, says its manual
            Self::ScoutMini | Self::Bunker => 6.0,
        }
    }
}

fn set_bits(byte: u8, names: &'static BitNames) -> impl Iterator<Item = &'static str> {
    (0..8).filter(move |bit| byte & (1 << bit) != 0).filter_map(|bit: usize| names[bit])
}

#[cfg(test)]
mod tests {
    use super::{Mode, Model};

    const ALL: [Model; 5] = [Model::Scout, Model::ScoutMini, Model::Tracer, Model::Hunter, Model::Bunker];

    #[test]
    fn only_mode_one_is_ours_on_every_chassis() {
        for model in ALL {
            let ours: Vec<u8> = (0..=255).filter(|byte| model.mode(*byte) == Mode::Can).collect();
            assert_eq!(ours, [1], "{model:?}");
        }
    }

    #[test]
    fn the_same_mode_byte_means_different_things_by_model() {
        assert_eq!([Model::Scout.mode(0), Model::Tracer.mode(0)], [Mode::Standby, Mode::RemoteControl]);
        assert_eq!([Model::Scout.mode(2), Model::Hunter.mode(2)], [Mode::Uart, Mode::RemoteControl]);
        assert_eq!([Model::Scout.mode(3), Model::Hunter.mode(3)], [Mode::RemoteControl, Mode::Other(3)]);
    }

    #[test]
    fn an_undervoltage_fault_of_a_scout_is_not_read_as_a_driver_fault() {
        let names = |model: Model| model.error_names(0x0100).collect::<Vec<_>>();
        assert_eq!(names(Model::Scout), ["battery undervoltage fault"]);
        assert!(names(Model::Hunter).is_empty());
        let both: Vec<_> = Model::Hunter.error_names(0x0481).collect();
        assert_eq!(both, ["remote control lost", "battery undervoltage", "over-current"]);
    }
}
