//! What a chassis' system state (0x211) means for its robot: the transition of the host's state machine, as one match.

use super::wire::{SystemState, Vehicle};
use super::{Mode, Model};
use drover_contract::{DriveState, Watchdog};
use std::time::Duration;

/// The maker's command watchdog: speed 0 this long after the last 0x111 (Scout manual, "communication protection").
const WATCHDOG: Duration = Duration::from_millis(500);

/// What the host does to get on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ask {
    /// Nothing: it is ready, or it is not ours to change.
    Nothing,
    /// Ask for CAN mode.
    Enable,
    /// Clear latched errors.
    ClearErrors,
    /// Both: in standby only a mode command is obeyed, so the clearing must come after it.
    EnableAndClear,
}

/// What a system state means for us: how far the drive is, and what to ask of it.
pub(super) fn verdict(model: Model, state: SystemState, mode: Mode) -> (DriveState, Ask) {
    let refused = |why: String, ask| (DriveState::Refused(why), ask);
    match (state.vehicle, mode) {
        (Vehicle::EmergencyStop, _) => {
            refused("emergency stop pressed: start this program anew once it is safe".into(), Ask::Nothing)
        }
        (Vehicle::Exception, _) => {
            let errors = error_text(model, state.errors);
            let ask = if mode == Mode::Can { Ask::ClearErrors } else { Ask::EnableAndClear };
            refused(format!("exception: {errors}; clearing it again and again"), ask)
        }
        (Vehicle::Other(other), _) => refused(format!("unlisted vehicle state {other}"), Ask::Nothing),
        (Vehicle::Normal, Mode::Can) => (DriveState::Ready(Watchdog::Fixed(WATCHDOG)), Ask::Nothing),
        (Vehicle::Normal, Mode::Standby) => (DriveState::BringUp("in standby: asking for CAN mode"), Ask::Enable),
        (Vehicle::Normal, Mode::RemoteControl) => {
            let ask = if model.starts_in_remote_control() { Ask::Enable } else { Ask::Nothing };
            refused("the remote control has it: switch it to command mode".into(), ask)
        }
        (Vehicle::Normal, Mode::Uart) => refused("under serial control: asking for CAN mode".into(), Ask::Enable),
        (Vehicle::Normal, Mode::Other(other)) => {
            refused(format!("in unlisted mode {other}: asking for CAN mode"), Ask::Enable)
        }
    }
}

/// What any other state means once an emergency stop was seen: somebody wanted the robot to stand, and nobody has said
/// since that it may drive.
pub(super) fn after_estop() -> (DriveState, Ask) {
    let why = "emergency stop was pressed: start this program anew once it is safe";
    (DriveState::Refused(why.into()), Ask::Nothing)
}

/// The names of error bits and, always, the bits themselves.
pub(super) fn error_text(model: Model, bits: u16) -> String {
    let names: Vec<_> = model.error_names(bits).collect();
    let names = if names.is_empty() { "no named error".to_owned() } else { names.join(", ") };
    format!("{names} (error bits 0x{bits:04X})")
}
