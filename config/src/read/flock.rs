//! Reads what a swarm that flocks is to do.

use super::by_mode::{among, number, truth};
use crate::reader::Table;
use crate::report::Words;
use crate::{Avoidance, Flock, FlockGuard, FlockMode, LeaderLoss, LeaderWay, Party, WallFollowing};
use std::f64::consts::{PI, TAU};

/// Most waypoints.
const WAYPOINTS_MAX: usize = 10_000;
/// Most parties: each robot's file lists all of them.
const PARTIES_MAX: usize = 1_000;

/// Reads `[behaviour]` with `kind = "flock"`.
pub(crate) fn flock(table: &mut Table<'_>) -> Option<Flock> {
    // The method that ships: the paper's own lets robots reverse blindly and run into each other.
    let mode = table.choice("mode", &["safe", "literal"]).map(|index| match index {
        0 => FlockMode::Safe,
        _ => FlockMode::Literal,
    });
    let literal = mode == Some(FlockMode::Literal);
    let parties = parties(table);
    let (forces, walls, method) = (forces(table), walls(table, literal), method(table, literal));
    let (forces, walls, method) = (forces?, walls?, method?);
    Some(Flock {
        mode: mode?,
        parties: parties?,
        leader_speed_mps: forces.leader_speed_mps,
        waypoint_radius_m: forces.waypoint_radius_m,
        arrive_radius_m: forces.arrive_radius_m,
        speed_mps: forces.speed_mps,
        turn_radps: walls.turn_radps,
        spacing_m: forces.spacing_m,
        gain: forces.gain,
        obstacle_range_m: forces.obstacle_range_m,
        head_offset_m: forces.head_offset_m,
        damping_per_s: forces.damping_per_s,
        mass_kg: forces.mass_kg,
        inertia_kgm2: forces.inertia_kgm2,
        wall_speed_mps: walls.wall_speed_mps,
        wall_turn_radps: walls.wall_turn_radps,
        wall_distance_m: walls.wall_distance_m,
        avoid_m: walls.avoid_m,
        deadlock_mps: walls.deadlock_mps,
        deadlock_s: walls.deadlock_s,
        period_s: walls.period_s,
        reverse: method.reverse,
        laser_rad: method.laser_rad,
        walls: method.walls,
        side_latch: method.side_latch,
        right_of_way: method.right_of_way,
        trail: method.trail,
        lose_nobody: method.lose_nobody,
        leader_way: method.leader_way,
        guard: method.guard,
        avoidance: method.avoidance,
        link_range_m: method.link_range_m,
        solid: method.solid,
        leader_loss: method.leader_loss,
    })
}

/// Who follows whom: one party of all, or a list.
fn parties(table: &mut Table<'_>) -> Option<Vec<Party>> {
    let leader = table.optional_integer("leader", 1..=u64::from(u32::MAX), "none");
    let waypoints_m = table.optional_points("waypoints_m", 1..=WAYPOINTS_MAX);
    let (has_leader, has_waypoints) = (table.has("leader"), table.has("waypoints_m"));
    let parties = listed(table);
    if table.has("party") && !has_leader && !has_waypoints {
        if parties.as_ref().is_some_and(Vec::is_empty) {
            table.problem("party", Words::new("no party", "at least one", "add one, or leader and waypoints_m"));
        }
        return parties.filter(|parties| !parties.is_empty());
    }
    if table.has("party") {
        let found = "parties beside a leader or waypoints_m of everybody";
        let words = Words::new(found, "one of the two", "remove leader and waypoints_m, or every party");
        table.problem("party", words);
        return None;
    }
    if !has_leader {
        table.missing("leader", "the id of the robot that the others follow, or [[behaviour.party]] tables");
    }
    if !has_waypoints {
        table.missing("waypoints_m", "the leader's way, a list of points [x, y], or [[behaviour.party]] tables");
    }
    let leader = u32::try_from(leader??).ok()?;
    Some(vec![Party::of_all(leader, waypoints_m.filter(|_| has_waypoints)?)])
}

/// The parties of `[[behaviour.party]]`; `None` also if any of them is wrong.
fn listed(table: &mut Table<'_>) -> Option<Vec<Party>> {
    let mut count = 0;
    let parties = table.tables("party", PARTIES_MAX, |table| {
        count += 1;
        party(table)
    })?;
    (parties.len() == count).then(|| parties.into_iter().map(|(_, party)| party).collect())
}

fn party(table: &mut Table<'_>) -> Option<Party> {
    let leader = table.integer_u32("leader", 1..=u32::MAX, None);
    let first_id = table.integer_u32("first_id", 1..=u32::MAX, None);
    let last_id = table.integer_u32("last_id", 1..=u32::MAX, None);
    let waypoints_m = table.points("waypoints_m", 1..=WAYPOINTS_MAX);
    let party = Party { leader: leader?, first_id: first_id?, last_id: last_id?, waypoints_m: waypoints_m? };
    if party.first_id > party.last_id {
        let expected = format!("at least first_id, {}", party.first_id);
        table.problem("last_id", Words::new(party.last_id.to_string(), expected, "swap the two?"));
        return None;
    }
    Some(party)
}

/// What draws and pushes a robot, and how fast it may follow.
struct Forces {
    leader_speed_mps: f64,
    waypoint_radius_m: f64,
    arrive_radius_m: f64,
    speed_mps: f64,
    spacing_m: f64,
    gain: f64,
    obstacle_range_m: f64,
    head_offset_m: f64,
    damping_per_s: f64,
    mass_kg: f64,
    inertia_kgm2: f64,
}

/// Defaults are the paper's values, scaled from its 100 mm spacing to 1.8 m (lengths times 18, times kept), unless
/// a comment says otherwise. The least values leave room for the paper's own robots of 10 mm.
fn forces(table: &mut Table<'_>) -> Option<Forces> {
    // Half of what the shipped robots can do: followers must be able to catch up.
    let leader_speed_mps = table.number("leader_speed_mps", 0.001..=10.0, Some(0.8));
    // About a body's length: nearer, and a leader circles around a point that it cannot hit.
    let waypoint_radius_m = table.number("waypoint_radius_m", 0.005..=100.0, Some(0.5));
    // Two rings of neighbours around the leader.
    let arrive_radius_m = table.number("arrive_radius_m", 0.01..=1_000.0, Some(4.0));
    // The greatest speed that a kind can have: the kind's own limit decides.
    let speed_mps = table.number("speed_mps", 0.001..=10.0, Some(10.0));
    let spacing_m = table.number("spacing_m", 0.01..=100.0, Some(1.8));
    let gain = table.number("gain", 0.0..=1_000.0, Some(0.3));
    // More than the paper's half of the spacing: these bodies fill a third of it.
    let obstacle_range_m = table.number("obstacle_range_m", 0.005..=100.0, Some(1.2));
    let head_offset_m = table.number("head_offset_m", 0.0005..=5.0, Some(0.3));
    let damping_per_s = table.number("damping_per_s", 0.0..=100.0, Some(1.0));
    // dt/m = 0.1 as in the paper, at a tick of 50 ms.
    let mass_kg = table.number("mass_kg", 0.001..=10_000.0, Some(0.5));
    // d^2 dt/I = 0.2 as in the paper, at a tick of 50 ms: well under 2, where the heading's loop would diverge. For the
    // paper's d of 2 mm and its 10 ms that is 2e-7.
    let inertia_kgm2 = table.number("inertia_kgm2", 1e-9..=10_000.0, Some(0.0225));
    Some(Forces {
        leader_speed_mps: leader_speed_mps?,
        waypoint_radius_m: waypoint_radius_m?,
        arrive_radius_m: arrive_radius_m?,
        speed_mps: speed_mps?,
        spacing_m: spacing_m?,
        gain: gain?,
        obstacle_range_m: obstacle_range_m?,
        head_offset_m: head_offset_m?,
        damping_per_s: damping_per_s?,
        mass_kg: mass_kg?,
        inertia_kgm2: inertia_kgm2?,
    })
}

/// How it turns, and how it follows a wall.
struct Walls {
    turn_radps: f64,
    wall_speed_mps: f64,
    wall_turn_radps: f64,
    wall_distance_m: f64,
    avoid_m: f64,
    deadlock_mps: f64,
    deadlock_s: f64,
    period_s: f64,
}

/// Where two defaults stand, the second is the paper's.
fn walls(table: &mut Table<'_>, literal: bool) -> Option<Walls> {
    // Half a turn a second: with the paper's 18 degrees a second no robot turns within its own flock. The kind's own
    // limit decides where it is less.
    let turn_radps = number(table, literal, "turn_radps", 0.01..=200.0, (PI, PI / 10.0));
    let wall_speed_mps = table.number("wall_speed_mps", 0.001..=10.0, Some(0.6));
    // The paper turns by 15 degrees every 10 ms.
    let wall_turn_radps = table.derived_number("wall_turn_radps", 0.01..=200.0, "turn_radps (literal: 26.2)");
    let otherwise = if literal { Some(26.2) } else { turn_radps };
    let wall_turn_radps = wall_turn_radps.and_then(|turn| turn.or(otherwise));
    // The paper keeps the distance that it had when the following began; what ships keeps half a margin more than it
    // must.
    let wall_distance_m = table.number("wall_distance_m", 0.0..=100.0, Some(0.0));
    let avoid_m = table.number("avoid_m", 0.0..=100.0, Some(1.4));
    let deadlock_mps = table.number("deadlock_mps", 0.0001..=10.0, Some(0.05));
    // A body needs most of a second to speed up: until then it is slow, and in no deadlock.
    let deadlock_s = number(table, literal, "deadlock_s", 0.01..=60.0, (1.0, 0.1));
    // The paper's.
    let period_s = table.number("period_s", 0.005..=1.0, Some(0.01));
    Some(Walls {
        turn_radps: turn_radps?,
        wall_speed_mps: wall_speed_mps?,
        wall_turn_radps: wall_turn_radps?,
        wall_distance_m: wall_distance_m?,
        avoid_m: avoid_m?,
        deadlock_mps: deadlock_mps?,
        deadlock_s: deadlock_s?,
        period_s: period_s?,
    })
}

/// What kind of robot and method it is.
struct Method {
    reverse: bool,
    laser_rad: f64,
    walls: WallFollowing,
    side_latch: bool,
    right_of_way: bool,
    trail: bool,
    lose_nobody: bool,
    leader_way: LeaderWay,
    guard: FlockGuard,
    avoidance: Avoidance,
    link_range_m: f64,
    solid: bool,
    leader_loss: LeaderLoss,
}

/// Where two defaults stand, the first is what ships, the second what the paper does.
fn method(table: &mut Table<'_>, literal: bool) -> Option<Method> {
    let reverse = truth(table, literal, "reverse", (false, true));
    let laser_rad = number(table, literal, "laser_rad", 0.1..=TAU, (TAU, PI));
    const WALLS: [(&str, WallFollowing); 3] =
        [("pledge", WallFollowing::Pledge), ("literal", WallFollowing::Literal), ("none", WallFollowing::None)];
    let walls = among(table, literal, "walls", WALLS, 1);
    let side_latch = truth(table, literal, "side_latch", (true, false));
    let right_of_way = truth(table, literal, "right_of_way", (true, false));
    let trail = truth(table, literal, "trail", (true, false));
    let lose_nobody = table.bool("lose_nobody", Some(false));
    const WAYS: [(&str, LeaderWay); 2] = [("pursuit", LeaderWay::Pursuit), ("potential", LeaderWay::Potential)];
    let leader_way = among(table, literal, "leader_way", WAYS, 0);
    // Links are not kept unless somebody says how long they may be.
    const GUARDS: [(&str, FlockGuard); 3] =
        [("collision", FlockGuard::Collision), ("full", FlockGuard::Full), ("none", FlockGuard::None)];
    let guard = among(table, literal, "guard", GUARDS, 2);
    const AVOIDANCES: [(&str, Avoidance); 2] = [("voronoi", Avoidance::Voronoi), ("orca", Avoidance::Orca)];
    let avoidance = among(table, literal, "avoidance", AVOIDANCES, 0);
    let link_range_m = table.number("link_range_m", 0.0..=100_000.0, Some(0.0));
    let solid = table.bool("solid", Some(true));
    const LOSSES: [(&str, LeaderLoss); 2] = [("stop", LeaderLoss::Stop), ("elect", LeaderLoss::Elect)];
    let leader_loss = among(table, literal, "leader_loss", LOSSES, 0);
    Some(Method {
        reverse: reverse?,
        laser_rad: laser_rad?,
        walls: walls?,
        side_latch: side_latch?,
        right_of_way: right_of_way?,
        trail: trail?,
        lose_nobody: lose_nobody?,
        leader_way: leader_way?,
        guard: guard?,
        avoidance: avoidance?,
        link_range_m: link_range_m?,
        solid: solid?,
        leader_loss: leader_loss?,
    })
}
