//! What does not change while a run goes on: the swarm, the place, and what may be asked of the run.

use serde::{Deserialize, Serialize};

/// What does not change while a run goes on. A live view is told it first; a recording holds it once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// The swarm's name.
    pub swarm: String,
    /// Its behaviour's name, as in the swarm file: "flock", "diffuse".
    pub behaviour: String,
    /// Seed of everything random in the simulation.
    pub seed: u64,
    /// Where what is seen comes from.
    pub source: Source,
    /// When the run began, microseconds since the Unix epoch.
    pub started_unix_us: u64,
    /// The run ends after this long at the latest, s; `None`: when somebody ends it.
    pub duration_s: Option<f64>,
    /// The robots, in the file's order.
    pub robots: Vec<RobotSetting>,
    /// The place; empty in the field.
    pub place: PlaceSetting,
    /// The leader's way, if there is one (of several the first): points in the world frame, metres.
    pub route_m: Vec<[f64; 2]>,
    /// Where that way's followers are to end, and how near counts as there; `None` for a behaviour without an end.
    pub goal: Option<GoalSetting>,
}

/// Where what is seen comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A simulator.
    #[default]
    Simulation,
    /// Real robots.
    Field,
}

/// One robot of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotSetting {
    /// Its id.
    pub id: u32,
    /// Its kind's name.
    pub kind: String,
    /// Radius of the disc that holds its body, metres.
    pub radius_m: f64,
    /// Corners of its body, body frame, metres; empty: the disc itself.
    pub footprint_m: Vec<[f64; 2]>,
    /// Where its lidar sits in the body frame: x, y in metres, yaw in radians.
    pub lidar_mount: [f64; 3],
    /// What its supervisor lets it drive at most, m/s.
    pub speed_mps_max: f64,
    /// A scan older than this stops it, ms.
    pub scan_ms: u32,
    /// Odometry older than this stops it, ms.
    pub odometry_ms: u32,
    /// A peer whose beacon is older than this is not followed, ms.
    pub peer_ms: u32,
}

/// Where everybody is to end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GoalSetting {
    /// The place, metres.
    pub at_m: [f64; 2],
    /// This near counts as there, metres.
    pub within_m: f64,
}

/// Walls and obstacles, world frame, metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaceSetting {
    /// Its name.
    pub name: String,
    /// The outer wall, closed: robots are inside; empty if there is none.
    pub enclosure_m: Vec<[f64; 2]>,
    /// Solid obstacles, closed outlines.
    pub polygons_m: Vec<Vec<[f64; 2]>>,
    /// Round obstacles: centre x, centre y, radius.
    pub circles_m: Vec<[f64; 3]>,
    /// Chains of thin walls.
    pub polylines_m: Vec<Vec<[f64; 2]>>,
    /// A grid map.
    pub map: Option<MapSetting>,
    /// Round obstacles that move.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub movers: Vec<MoverSetting>,
}

/// A round obstacle that moves. Where it is, each moment tells: it waits for robots, so its way and the time do not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MoverSetting {
    /// Its radius, metres.
    pub radius_m: f64,
    /// Its way: from the first of these points, where it starts, to the next, and from the last to the first, metres.
    pub round_m: Vec<[f64; 2]>,
}

/// A grid map whose solid cells are obstacles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapSetting {
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// South-west corner of the south-west cell, metres.
    pub origin_m: [f64; 2],
    /// How the map is turned about that corner, radians, counter-clockwise.
    pub origin_yaw_rad: f64,
    /// Cells from west to east.
    pub width: usize,
    /// Cells from south to north.
    pub height: usize,
    /// Lengths of runs of equal cells, row by row from the south, each row from the west; the first run is free (it may
    /// be 0 long), the next solid, and so on in turn.
    pub runs: Vec<u32>,
}

impl MapSetting {
    /// Whether each cell is solid: `solid[y * width + x]`, y counted from the south. Never more cells than the map has.
    #[must_use]
    pub fn solid(&self) -> Vec<bool> {
        let cells = self.width.saturating_mul(self.height);
        let runs = self.runs.iter().enumerate();
        let all = runs.flat_map(|(index, run)| std::iter::repeat_n(index % 2 == 1, *run as usize));
        all.take(cells).collect()
    }
}

/// What somebody who looks on may ask of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Control {
    /// Stop every robot, at once and for good (latched), as `drover stop` does.
    Stop,
    /// Let time stand still.
    Pause,
    /// Let it go on.
    Resume,
    /// Let it go on this fast: simulated or replayed seconds per second.
    Speed {
        /// How fast.
        rate: f64,
    },
    /// Begin anew.
    Restart,
    /// Go to this moment of a recording.
    Seek {
        /// Seconds since it began.
        time_s: f64,
    },
}

/// What may be asked of this run: what of [`Control`] makes sense.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Controls {
    /// Stop.
    pub stop: bool,
    /// Pause, resume and speed.
    pub pace: bool,
    /// Restart.
    pub restart: bool,
    /// Seek: it is a recording.
    pub seek: bool,
}
