//! What is seen of a swarm, moment by moment: written to MCAP files, and read back.

mod coarse;
mod convert;
pub mod foxglove;
mod measure;
mod moment;
mod onlooker;
mod read;
mod setting;
mod wire;
mod write;

pub use measure::{
    COVERAGE_CELL_M, Connectivity, Coverage, FAR_M, Gaps, MOVING_MPS, PlaceIndex, connectivity, gaps, gaps_per_robot,
    hearing, speed_mps, velocity_order,
};
pub use moment::{CLEAR, Heard, Moment, Phase, Place, RobotMoment, RunState, ScanMoment, StopState, Truth};
pub use onlooker::Onlooker;
pub use read::{ReadError, RecordingFile};
pub use setting::{
    Control, Controls, GoalSetting, MapSetting, MoverSetting, PlaceSetting, RobotSetting, Setting, Source,
};
pub use write::{Begin, Pace, Recorder, RecorderOptions, RecorderState};
