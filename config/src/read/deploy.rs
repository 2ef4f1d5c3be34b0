//! Reads what a swarm that deploys is to do.

use super::by_mode::{among, number, truth};
use crate::reader::{COORDINATE_M_MAX, Table};
use crate::report::Words;
use crate::{Assignment, Deploy, DeployGuard, DeployMode, DeploySteer, Escape, Exchange, Forces, KeptLinks, Rotation};
use std::f64::consts::{FRAC_PI_4, PI};

/// Most targets, and so most robots: each robot's file lists all of them.
const TARGETS_MAX: u32 = 10_000;
/// Most hops: what a robot has to hear of others grows with them, and nobody measured more than a handful.
const HOPS_MAX: u64 = 16;

/// Reads `[behaviour]` with `kind = "deploy"`.
pub(crate) fn deploy(table: &mut Table<'_>) -> Option<Deploy> {
    // The method that ships: the paper's own lets robots meet and walk through walls.
    let mode = table.choice("mode", &["safe", "literal"]).map(|index| match index {
        0 => DeployMode::Safe,
        _ => DeployMode::Literal,
    });
    let targets_m = targets(table);
    let method = method(table, mode.unwrap_or(DeployMode::Safe));
    let numbers = numbers(table, mode.unwrap_or(DeployMode::Safe));
    let (method, numbers) = (method?, numbers?);
    Some(Deploy {
        mode: mode?,
        targets_m: targets_m?,
        range_m: numbers.range_m,
        speed_mps: numbers.speed_mps,
        period_s: numbers.period_s,
        exchange: method.exchange,
        links: method.links,
        hops: method.hops,
        goalward: method.goalward,
        spread: method.spread,
        assignment: method.assignment,
        rotation: method.rotation,
        forces: method.forces,
        guard: method.guard,
        steer: method.steer,
        follow: method.follow,
        detours: method.detours,
        escape: method.escape,
        goal_gain: numbers.goal_gain,
        link_gain: numbers.link_gain,
        repel_gain: numbers.repel_gain,
        view_rad: numbers.view_rad,
        epsilon_m: numbers.epsilon_m,
        avoid_m_min: numbers.avoid_m_min,
        interval_m: numbers.interval_m,
        robot_gap_m: numbers.robot_gap_m,
        wall_gap_m: numbers.wall_gap_m,
        arrive_m: numbers.arrive_m,
        peer_lost_s: numbers.peer_lost_s,
    })
}

/// What is done, by words.
struct Method {
    exchange: Exchange,
    links: KeptLinks,
    hops: u32,
    goalward: f64,
    spread: f64,
    assignment: Assignment,
    rotation: Rotation,
    forces: Forces,
    guard: DeployGuard,
    steer: DeploySteer,
    follow: bool,
    detours: bool,
    escape: Escape,
}

/// Where two defaults stand, the first is what ships, chosen by a prototype's runs on the paper's scenes; the second is
/// what the paper does.
fn method(table: &mut Table<'_>, mode: DeployMode) -> Option<Method> {
    let literal = mode == DeployMode::Literal;
    // The paper's assumption.
    const EXCHANGES: [(&str, Exchange); 2] = [("snapshot", Exchange::Snapshot), ("beacons", Exchange::Beacons)];
    let exchange = among(table, literal, "exchange", EXCHANGES, 0);
    // A ring around an obstacle has no triangle: only minimum spanning trees open it.
    const LINKS: [(&str, KeptLinks); 3] = [("lmst", KeptLinks::Lmst), ("rng", KeptLinks::Rng), ("all", KeptLinks::All)];
    let links = among(table, literal, "links", LINKS, 1);
    // A ring around large obstacles is longer than any few hops; all of a network can be told through it. The paper's
    // robots know their neighbours alone.
    let hops = table.optional_integer("hops", 0..=HOPS_MAX, "0 (literal: 1)");
    let hops = hops.and_then(|hops| u32::try_from(hops.unwrap_or(u64::from(literal))).ok());
    // Between 0.3 and 1 it makes no great difference; 0 are the plain lengths of the paper.
    let goalward = number(table, literal, "goalward", 0.0..=100.0, (0.6, 0.0));
    // Robots that keep some of their order on the way have less to sort out at its end.
    let spread = number(table, literal, "spread", 0.0..=1.0, (0.5, 0.0));
    // Shorter ways, and a quarter less time in the open. The paper gives each robot its target beforehand.
    const ASSIGNMENTS: [(&str, Assignment); 2] = [("hungarian", Assignment::Hungarian), ("given", Assignment::Given)];
    let assignment = among(table, literal, "assignment", ASSIGNMENTS, 1);
    // The paper's robots turn in place.
    const ROTATIONS: [(&str, Rotation); 2] = [("independent", Rotation::Independent), ("coupled", Rotation::Coupled)];
    let rotation = among(table, literal, "rotation", ROTATIONS, 0);
    // The paper's method; the sum is what it compares itself with.
    let forces = among(table, literal, "forces", [("sslp", Forces::Sslp), ("sum", Forces::Sum)], 0);
    // All that keeps theorems 2 and 3 true. The paper holds nothing back.
    const GUARDS: [(&str, DeployGuard); 3] =
        [("full", DeployGuard::Full), ("collision", DeployGuard::Collision), ("none", DeployGuard::None)];
    let guard = among(table, literal, "guard", GUARDS, 2);
    // The nearest allowed point sticks to the faces of obstacles.
    const STEERS: [(&str, DeploySteer); 2] = [("heading", DeploySteer::Heading), ("project", DeploySteer::Project)];
    let steer = among(table, literal, "steer", STEERS, 0);
    // A chain that hangs over an obstacle comes free only if robots follow each other.
    let follow = truth(table, literal, "follow", (true, false));
    // Safe robots can hold each other up.
    let detours = truth(table, literal, "detours", (true, false));
    // The other one needs a map that is known.
    let escape = among(table, literal, "escape", [("none", Escape::None), ("geodesic", Escape::Geodesic)], 0);
    Some(Method {
        exchange: exchange?,
        links: links?,
        hops: hops?,
        goalward: goalward?,
        spread: spread?,
        assignment: assignment?,
        rotation: rotation?,
        forces: forces?,
        guard: guard?,
        steer: steer?,
        follow: follow?,
        detours: detours?,
        escape: escape?,
    })
}

/// What is done, by numbers.
struct Numbers {
    range_m: f64,
    speed_mps: f64,
    period_s: f64,
    goal_gain: f64,
    link_gain: f64,
    repel_gain: f64,
    view_rad: f64,
    epsilon_m: f64,
    avoid_m_min: f64,
    interval_m: f64,
    robot_gap_m: f64,
    wall_gap_m: f64,
    arrive_m: f64,
    peer_lost_s: f64,
}

/// Of the numbers the paper gives range, speed and period; the others are those with which its scenes went best.
fn numbers(table: &mut Table<'_>, mode: DeployMode) -> Option<Numbers> {
    let range_m = table.number("range_m", 0.1..=100_000.0, Some(7.0));
    // The same key and default as in diffusion: here v_max.
    let speed_mps = table.number("speed_mps", 0.01..=10.0, Some(0.5));
    let period_s = table.number("period_s", 0.05..=60.0, Some(1.0));
    // Only the ratios of gains count while the step is as long as it may be; near the target 1/T gets there in one
    // step. The paper gives none: its scenes went best with a fifth of these.
    let mut gain = |key, range, (paper, safe): (f64, f64), shown| {
        let default = if mode == DeployMode::Literal { paper } else { safe };
        table.derived_number(key, range, shown).map(|gain| gain.unwrap_or(default))
    };
    let in_one_step = 1.0 / period_s.unwrap_or(1.0);
    let goal_gain = gain("goal_gain", 0.001..=100.0, (0.2, in_one_step), "1 / period_s (literal: 0.2)");
    let link_gain = gain("link_gain", 0.0..=1_000.0, (0.4, 2.0), "2 (literal: 0.4)");
    let repel_gain = gain("repel_gain", 0.0..=1_000.0, (0.4, 2.0), "2 (literal: 0.4)");
    // An eighth of a turn to either side: as good as a quarter; 0 would have no meaning for points.
    let view_rad = table.number("view_rad", 0.01..=PI, Some(FRAC_PI_4));
    // d_a = 1.2 m at the paper's speed and period, half of the least spacing that it allows in a layout.
    let epsilon_m = table.number("epsilon_m", 0.0..=100.0, Some(0.2));
    // Much less than d_a, as the paper asks.
    let avoid_m_min = table.number("avoid_m_min", 0.0..=100.0, Some(0.2));
    // One step of a layout at 2.5 m.
    let interval_m = table.number("interval_m", 0.0..=1_000.0, Some(2.5));
    // Nobody touches, and still they pass between each other: with twice as much, scenes took up to a third longer.
    let robot_gap_m = table.number("robot_gap_m", 0.0..=100.0, Some(0.3));
    let wall_gap_m = table.number("wall_gap_m", 0.0..=100.0, Some(0.3));
    // Half of a step.
    let arrive_m = table.number("arrive_m", 0.01..=100.0, Some(0.25));
    // Thirty beacons at 10 Hz: whoever is given up earlier may still hold the net together.
    let peer_lost_s = table.number("peer_lost_s", 0.1..=3_600.0, Some(3.0));
    Some(Numbers {
        range_m: range_m?,
        speed_mps: speed_mps?,
        period_s: period_s?,
        goal_gain: goal_gain?,
        link_gain: link_gain?,
        repel_gain: repel_gain?,
        view_rad: view_rad?,
        epsilon_m: epsilon_m?,
        avoid_m_min: avoid_m_min?,
        interval_m: interval_m?,
        robot_gap_m: robot_gap_m?,
        wall_gap_m: wall_gap_m?,
        arrive_m: arrive_m?,
        peer_lost_s: peer_lost_s?,
    })
}

/// The targets, one by one or as a lattice.
fn targets(table: &mut Table<'_>) -> Option<Vec<[f64; 2]>> {
    let listed = table.optional_points("targets_m", 1..=TARGETS_MAX as usize);
    let lattice = table.optional_table("layout", lattice);
    match (table.has("targets_m"), table.has("layout")) {
        (true, true) => {
            let words = Words::new("a layout beside targets_m", "one of the two", "remove one of them");
            table.problem("layout", words);
            None
        }
        (true, false) => listed,
        (false, true) => lattice?,
        (false, false) => {
            table.missing("targets_m", "a list of points [x, y], or layout = { origin_m, columns, rows, spacing_m }");
            None
        }
    }
}

/// Columns and rows: from west to east, the southernmost first.
fn lattice(table: &mut Table<'_>) -> Option<Vec<[f64; 2]>> {
    let origin_m = table.point("origin_m");
    let columns = table.integer_u32("columns", 1..=TARGETS_MAX, None);
    let rows = table.integer_u32("rows", 1..=TARGETS_MAX, None);
    let spacing_m = table.number("spacing_m", 0.01..=1_000.0, None);
    let ([x_m, y_m], columns, rows, spacing_m) = (origin_m?, columns?, rows?, spacing_m?);
    let count = u64::from(columns) * u64::from(rows);
    if count > u64::from(TARGETS_MAX) {
        let found = format!("{rows}, which makes {count} targets");
        table.problem("rows", Words::new(found, format!("at most {TARGETS_MAX} targets"), "lower columns or rows"));
        return None;
    }
    let end_m = [x_m + f64::from(columns - 1) * spacing_m, y_m + f64::from(rows - 1) * spacing_m];
    if end_m.iter().any(|end_m| *end_m > COORDINATE_M_MAX) {
        let found = format!("{spacing_m}, with the last target at [{}, {}]", end_m[0], end_m[1]);
        let expected = format!("targets with both coordinates up to {COORDINATE_M_MAX}");
        table.problem("spacing_m", Words::new(found, expected, "lower it, or move origin_m"));
        return None;
    }
    let row = |y: u32| (0..columns).map(move |x| [x_m + f64::from(x) * spacing_m, y_m + f64::from(y) * spacing_m]);
    Some((0..rows).flat_map(row).collect())
}
