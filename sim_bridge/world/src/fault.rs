//! What can be broken on the far side of a robot's links, from outside and while the world runs.

/// A fault, or its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing passes on the drive's link any more, either way. On MAVLink that takes the scan away too.
    LinkCut,
    /// The drive's link is whole again; what was sent meanwhile is lost.
    LinkBack,
    /// The lidar stops. A bridge on the autopilot's link sends no OBSTACLE_DISTANCE; a DroneCAN node falls silent,
    /// NodeStatus and all.
    ScanCut,
    /// The lidar starts anew.
    ScanBack,
    /// The drive's firmware loses its power for a moment: it starts as after power-on and says nothing of it.
    PowerCycle,
    /// Somebody takes the drive by remote control (asking nothing of it), or gives it back.
    RemoteControl(bool),
    /// Somebody at a ground station sets the autopilot's mode (ArduPilot's number of it). A chassis has no station.
    StationMode(u32),
    /// Somebody presses the emergency stop, or releases it. A rover's button cuts the motors' power behind the
    /// autopilot's back: it drives on when the button is released, unless it was told otherwise.
    EStop(bool),
}
