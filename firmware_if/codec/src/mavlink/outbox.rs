//! What waits to be sent: the newest setpoint, and everything else in order.

use super::wire::Emitter;
use super::{AUTOPILOT_COMPONENT, request::Request};
use drover_contract::{MavId, Stamp, Twist};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavFrame, MavMessage, MavModeFlag, MavState, MavType,
    PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use std::collections::VecDeque;

const QUEUE_MAX: usize = 64;
/// Velocity and yaw rate, nothing else: the one mask that drives a skid-steer rover (0x5C7).
pub(crate) const MASK_TWIST: u16 = 1479;
/// MAVLink's own version number, which HEARTBEAT carries.
const PROTOCOL_VERSION: u8 = 3;

/// Messages are turned into frames when they leave, so that sequence numbers have no gaps.
#[derive(Debug)]
pub(crate) struct Outbox {
    emitter: Emitter,
    robot: u8,
    setpoint: Option<MavMessage>,
    queue: VecDeque<MavMessage>,
    dropped: u64,
}

impl Outbox {
    pub(crate) const fn new(own: MavId) -> Self {
        Self { emitter: Emitter::new(own), robot: own.system, setpoint: None, queue: VecDeque::new(), dropped: 0 }
    }

    /// The newest setpoint replaces one that has not left yet: an aged one is never sent.
    pub(crate) fn set_setpoint(&mut self, now: Stamp, twist_b: Twist) {
        self.setpoint = Some(setpoint(self.robot, now, twist_b));
    }

    pub(crate) fn clear_setpoint(&mut self) {
        self.setpoint = None;
    }

    pub(crate) fn push(&mut self, message: MavMessage) {
        if self.queue.len() == QUEUE_MAX {
            self.queue.pop_front();
            self.dropped += 1;
        }
        self.queue.push_back(message);
    }

    pub(crate) fn push_request(&mut self, request: Request, confirmation: u8) {
        self.push(command(self.robot, request, confirmation));
    }

    pub(crate) fn pop(&mut self) -> Option<Vec<u8>> {
        let message = self.setpoint.take().or_else(|| self.queue.pop_front())?;
        Some(self.emitter.encode(&message))
    }

    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }
}

/// Our own heartbeat: an onboard controller, not an autopilot.
pub(crate) fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: PROTOCOL_VERSION,
    })
}

/// Drive with `twist_b`: SET_POSITION_TARGET_LOCAL_NED in the body frame, where a positive yaw rate turns right.
pub(crate) fn setpoint(robot: u8, now: Stamp, twist_b: Twist) -> MavMessage {
    let (forward, right) = (twist_b.speed_mps as f32, (0.0 - twist_b.yaw_rate_radps) as f32);
    // A NaN or an infinity ends an ArduPilot (a number too large for f32 becomes one): it is a stop instead.
    let (vx, yaw_rate) = if forward.is_finite() && right.is_finite() { (forward, right) } else { (0.0, 0.0) };
    MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms: now.as_millis() as u32,
        vx,
        yaw_rate,
        type_mask: PositionTargetTypemask::from_bits_retain(MASK_TWIST),
        target_system: robot,
        target_component: AUTOPILOT_COMPONENT,
        coordinate_frame: body_ned(),
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
    })
}

/// BODY_NED (8) is deprecated in favour of BODY_FRD (12), which ArduPilot Rover silently ignores.
#[allow(deprecated)]
const fn body_ned() -> MavFrame {
    MavFrame::MAV_FRAME_BODY_NED
}

pub(crate) fn command(robot: u8, request: Request, confirmation: u8) -> MavMessage {
    let (command, param1, param2) = match request {
        Request::Mode(custom_mode) => (MavCmd::MAV_CMD_DO_SET_MODE, 1.0, custom_mode as f32),
        Request::Arm(arm) => (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, if arm { 1.0 } else { 0.0 }, 0.0),
        Request::Interval { message, hz } => {
            (MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, message as f32, (1.0e6 / f64::from(hz.max(1))) as f32)
        }
    };
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        command,
        target_system: robot,
        target_component: AUTOPILOT_COMPONENT,
        confirmation,
        ..COMMAND_LONG_DATA::default()
    })
}

/// The frame that stops the robot: a zero setpoint.
pub(crate) fn stop_frame(own: MavId) -> Vec<u8> {
    Emitter::new(own).encode(&setpoint(own.system, Stamp::ZERO, Twist::ZERO))
}
