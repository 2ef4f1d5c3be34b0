//! Deployment: from where the swarm is to a commanded layout, connected at every moment.

use serde::Serialize;

/// Parameters of deployment (Fan 2010). Symbols are the paper's. With `mode = "literal"` the defaults are the paper's,
/// with `mode = "safe"` those that ship; each can be set by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Deploy {
    /// Whose defaults count.
    pub mode: DeployMode,
    /// The layout, metres, world frame: one target a robot at least.
    pub targets_m: Vec<[f64; 2]>,
    /// r_c: robots this near hear each other, metres.
    pub range_m: f64,
    /// v_max, m/s.
    pub speed_mps: f64,
    /// T: the law decides this often, s.
    pub period_s: f64,
    /// What a robot knows of its peers when it decides.
    pub exchange: Exchange,
    /// Which links attract and are kept.
    pub links: KeptLinks,
    /// k: a robot knows the positions of peers this many hops away (links = "lmst"); 0: of the whole network.
    pub hops: u32,
    /// Trees prefer links near to the layout: this share of the distance to its centre is added to a link's length.
    pub goalward: f64,
    /// Stage 1 leads to the layout's centre (0), to the own target (1) or between them.
    pub spread: f64,
    /// Who goes to which target.
    pub assignment: Assignment,
    /// Whether a robot turns first and moves then, or both at once.
    pub rotation: Rotation,
    /// Which repulsions act.
    pub forces: Forces,
    /// What the last layer holds back.
    pub guard: DeployGuard,
    /// Which allowed move stands for a forbidden one.
    pub steer: DeploySteer,
    /// Whether robots of stage 1 follow their parent in a tree towards the goal, and only it.
    pub follow: bool,
    /// Whether a robot that gets nowhere goes around what is in its way (mode = "safe").
    pub detours: bool,
    /// How robots get out of concave pockets.
    pub escape: Escape,
    /// k_goal, 1/s.
    pub goal_gain: f64,
    /// k_com, 1/s.
    pub link_gain: f64,
    /// k_rep, m^4/s.
    pub repel_gain: f64,
    /// phi: "in the direction of a force" is within this angle of it, radians.
    pub view_rad: f64,
    /// epsilon in d_a = 2 v_max T + epsilon, metres.
    pub epsilon_m: f64,
    /// d_a^min: nearer than this, repulsion goes before everything else, metres.
    pub avoid_m_min: f64,
    /// d_interval: the box of stage 2 reaches this far beyond the targets, metres.
    pub interval_m: f64,
    /// d_s: the last layer keeps robots this far apart, metres, centre to centre for points and body to body else.
    pub robot_gap_m: f64,
    /// d_o: and this far from obstacles, metres.
    pub wall_gap_m: f64,
    /// A robot this near to its target has arrived, metres.
    pub arrive_m: f64,
    /// A peer silent for longer is given up, s (exchange = "beacons").
    pub peer_lost_s: f64,
}

/// Whose defaults count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeployMode {
    /// The method that ships.
    Safe,
    /// The paper as printed, tunnelling and all: for comparison, refused on anything but simulated points.
    Literal,
}

/// What a robot knows of its peers when it decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Exchange {
    /// All decide at once and know where the others within range are at that moment: the paper's assumption.
    Snapshot,
    /// What beacons have told, late and with losses; each robot decides in a moment of its own.
    Beacons,
}

/// Which links attract in stage 1 and are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum KeptLinks {
    /// All within range: no optimisation.
    All,
    /// Relative neighbourhood graph: the longest link of each triangle is left out.
    Rng,
    /// Local minimum spanning tree of the `hops`-hop neighbourhood, of links that both ends keep.
    Lmst,
}

/// Who goes to which target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Assignment {
    /// The first robot to the first target, and so on.
    Given,
    /// The least sum of squared distances from the starts.
    Hungarian,
}

/// Whether a robot turns first and moves then, or both at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotation {
    /// Turns in place, then moves straight (steps 1, 2, 3, 6).
    Independent,
    /// Turns while it moves (steps 1, 4, 5, 6).
    Coupled,
}

/// Which repulsions act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Forces {
    /// Single-step location prediction: only what lies in the direction of the next step.
    Sslp,
    /// Everything within d_a, summed: the classical collective potential field.
    Sum,
}

/// What the last layer holds back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeployGuard {
    /// Nothing.
    None,
    /// Collisions: R and O.
    Collision,
    /// Collisions and lost links: C, R and O.
    Full,
}

/// Which allowed move stands for a forbidden one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeploySteer {
    /// The one with the least deviation in direction.
    Heading,
    /// The nearest point.
    Project,
}

/// How robots get out of concave pockets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Escape {
    /// They do not.
    None,
    /// Along the shortest way on the known map.
    Geodesic,
}
