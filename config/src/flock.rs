//! Flocking: robots keep together behind a leader, and get out of traps.

use serde::Serialize;

/// Parameters of sequential flocking with wall following (Cheng 2011). Symbols are the paper's. Lengths, speeds and
/// gains default to its values, scaled from 100 mm to metres; what kind of robot and method it is (the second half)
/// defaults to what `mode` stands for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flock {
    /// Whose defaults count.
    pub mode: FlockMode,
    /// Who follows whom: one party, or several that keep apart.
    #[serde(rename = "party")]
    pub parties: Vec<Party>,
    /// A leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// A leader has reached a point at this distance, metres.
    pub waypoint_radius_m: f64,
    /// A follower has reached the leader's end at this distance from the last point, metres; one that is farther than
    /// this from its leader when a run ends is lost.
    pub arrive_radius_m: f64,
    /// v_max: followers ask for no more, m/s; the kind's own limit holds as well.
    pub speed_mps: f64,
    /// omega_max: the same of turning while flocking, rad/s.
    pub turn_radps: f64,
    /// L: distance between neighbours at which they neither attract nor repel, metres.
    pub spacing_m: f64,
    /// A: strength of the pair potential (eq. 3), m^2/s^2.
    pub gain: f64,
    /// S: an obstacle nearer than this is sensed, and repels, metres from the reference point.
    pub obstacle_range_m: f64,
    /// d: the reference point lies this far ahead of the wheels' axis (eq. 6), metres.
    pub head_offset_m: f64,
    /// Gain on the velocity difference to the leader (eq. 2), 1/s. The paper's is 1.
    pub damping_per_s: f64,
    /// m: mass in eq. 6, kg.
    pub mass_kg: f64,
    /// I: moment of inertia in eq. 6, kg m^2.
    pub inertia_kgm2: f64,
    /// Speed along a wall, m/s.
    pub wall_speed_mps: f64,
    /// Turning along a wall, and what ships: along the leader's trail, rad/s.
    pub wall_turn_radps: f64,
    /// d_s0: distance that is kept along a wall, metres; 0: that of the moment when the following began.
    pub wall_distance_m: f64,
    /// D: another robot nearer than this, centre to centre, is made way for along a wall, metres.
    pub avoid_m: f64,
    /// Slower than this over `deadlock_s`, a robot in front of an obstacle is in a deadlock, m/s.
    pub deadlock_mps: f64,
    /// That window, s.
    pub deadlock_s: f64,
    /// Delta t: simulated points decide this often, s; robots with bodies have their kind's `tick_ms`.
    pub period_s: f64,

    /// Whether followers may drive backwards on their own account.
    pub reverse: bool,
    /// The laser looks this far around, half of it to either side of the heading, radians.
    pub laser_rad: f64,
    /// How a robot in a deadlock follows the wall.
    pub walls: WallFollowing,
    /// Whether a wall follower keeps the side that it chose at first.
    pub side_latch: bool,
    /// Whether wall followers that meet give way by a rule.
    pub right_of_way: bool,
    /// Whether a follower that cannot go straight to its leader goes where that went.
    pub trail: bool,
    /// Whether a leader waits, even for ever, for its worst link: nobody is lost.
    pub lose_nobody: bool,
    /// How a leader gets along its way.
    pub leader_way: LeaderWay,
    /// What the last layer holds back of simulated points.
    pub guard: FlockGuard,
    /// How the law avoids other robots.
    pub avoidance: Avoidance,
    /// r_c: with `guard = "full"`, links are kept this short, metres.
    pub link_range_m: f64,
    /// Whether walls stop simulated points.
    pub solid: bool,
    /// What followers do when their leader is lost.
    pub leader_loss: LeaderLoss,
}

/// By how much each body's position may be wrong, as links between bodies reckon with it, metres.
pub const POSE_ERROR_M: f64 = 0.3;

/// A link is begun only if it is no longer than this share of what one may be: both ends have some room at first.
pub const LINK_BEGUN_SHARE: f64 = 0.95;

/// Those who follow one leader.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Party {
    /// The robot that the others follow.
    pub leader: u32,
    /// Its members have ids from this one ...
    pub first_id: u32,
    /// ... to this one, both included.
    pub last_id: u32,
    /// The leader's way, metres, world frame, at least one point.
    pub waypoints_m: Vec<[f64; 2]>,
}

impl Party {
    /// Everybody behind `leader`.
    #[must_use]
    pub fn of_all(leader: u32, waypoints_m: Vec<[f64; 2]>) -> Self {
        Self { leader, first_id: 1, last_id: u32::MAX, waypoints_m }
    }

    /// Whether robot `id` is one of it.
    #[must_use]
    pub fn has(&self, id: u32) -> bool {
        (self.first_id..=self.last_id).contains(&id)
    }

    /// Where everybody of it is to end, metres.
    #[must_use]
    pub fn end_m(&self) -> [f64; 2] {
        self.waypoints_m.last().copied().unwrap_or_default()
    }
}

impl Flock {
    /// The party of robot `id`; checked when the file was read.
    #[must_use]
    pub fn party_of(&self, id: u32) -> Option<&Party> {
        self.parties.iter().find(|party| party.has(id))
    }
}

/// Whose defaults count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FlockMode {
    /// The method that ships.
    Safe,
    /// The paper as printed, blind reversing and all: for comparison, refused on anything but simulated points.
    Literal,
}

/// How a robot in a deadlock follows the wall, and when it stops to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallFollowing {
    /// It does not.
    None,
    /// The paper's section 3: until no wall is seen, or wall and attractor push the same way.
    Literal,
    /// Until the turns along the wall are undone (Pledge).
    Pledge,
}

/// How a leader gets along its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LeaderWay {
    /// Pure pursuit along the legs between its points.
    Pursuit,
    /// An improved potential field with a target point that moves along the legs.
    Potential,
}

/// What the last layer holds back of simulated points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FlockGuard {
    /// Nothing.
    None,
    /// Collisions: R and O.
    Collision,
    /// Collisions and lost links: C, R and O.
    Full,
}

/// How the law avoids other robots, beneath the last layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Avoidance {
    /// Repulsion alone; the last layer's buffered Voronoi cells do the rest.
    Voronoi,
    /// Non-holonomic optimal reciprocal collision avoidance.
    Orca,
}

/// What followers do when their leader is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LeaderLoss {
    /// They stop until it is back.
    Stop,
    /// The lowest id of the party that is heard claims the lead, says so, and goes on along the way.
    Elect,
}
