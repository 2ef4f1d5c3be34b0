//! Reads a swarm.

use super::fleet::FleetParts;
use super::kind::{KindParts, Tightening};
use super::robot::{MAVLINK_PORT_BASE, ROBOTS_MAX, RobotParts};
use super::world::WorldParts;
use super::{behaviour, fleet, kind, plane, robot, world};
use crate::reader::{FOLDER, NAME, Table};
use crate::{BeaconPlane, Behaviour, Kind, Radio};
use std::collections::BTreeMap;

/// The seed of a swarm that has none, and of a world on its own: any fixed one, so that the same file does the same
/// twice.
pub(crate) const SEED: u64 = 1;

/// What could be read of a swarm.
#[derive(Debug)]
pub(crate) struct SwarmParts {
    pub(crate) name: Option<String>,
    pub(crate) seed: Option<u64>,
    pub(crate) duration_s: Option<f64>,
    pub(crate) step_ms: Option<u32>,
    pub(crate) record_dir: Option<String>,
    pub(crate) mavlink_port_base: Option<u16>,
    pub(crate) world: Option<WorldParts>,
    pub(crate) kinds: BTreeMap<String, KindParts>,
    pub(crate) robots: Vec<RobotParts>,
    pub(crate) fleets: Vec<FleetParts>,
    pub(crate) behaviour: Option<Behaviour>,
    pub(crate) beacon: Option<BeaconPlane>,
    pub(crate) radio: Option<Radio>,
    pub(crate) tightening: Tightening,
}

/// Reads what there is.
pub(crate) fn swarm(table: &mut Table<'_>) -> Option<SwarmParts> {
    let name = table.text("name", &NAME, None);
    let seed = table.integer("seed", 0..=u64::MAX, Some(SEED));
    let duration_s = table.number("duration_s", 0.1..=86_400.0, None);
    // Ten steps a tick at the default tick: the body's motion between ticks is smooth.
    let step_ms = table.integer_u32("step_ms", 1..=50, Some(5));
    let record_dir = table.text("record_dir", &FOLDER, Some("recordings"));
    let mavlink_port_base = table.integer_u16("mavlink_port_base", 1_024..=65_285, MAVLINK_PORT_BASE);
    let world = table.table("world", |table| world::world(table, seed.unwrap_or(SEED)));
    let kinds = table.named_tables("kinds", |name, table| kind::kind(table, Some(name)));
    let kinds: BTreeMap<String, KindParts> = kinds.unwrap_or_default().into_iter().collect();
    let motion = table.optional_table("motion", kind::tighter_motion).flatten();
    let timeouts = table.optional_table("timeouts", kind::tighter_timeouts).flatten();
    let robots = table.tables("robot", ROBOTS_MAX, |table| {
        robot::robot(table, mavlink_port_base, |kind| kinds.get(kind).and_then(|kind| kind.drive))
    });
    let robots = robots.unwrap_or_default().into_iter().map(|(_, robot)| robot).collect();
    let fleets = table.tables("fleet", fleet::FLEETS_MAX, fleet::fleet).unwrap_or_default();
    let fleets = fleets.into_iter().map(|(_, fleet)| fleet).collect();
    let behaviour = table.table("behaviour", behaviour::behaviour);
    let beacon = table.section("beacon", plane::beacon);
    let radio = table.section("radio", plane::radio);
    let tightening = Tightening { motion: motion.unwrap_or_default(), timeouts: timeouts.unwrap_or_default() };
    Some(SwarmParts {
        name,
        seed,
        duration_s,
        step_ms,
        record_dir,
        mavlink_port_base,
        world,
        kinds,
        robots,
        fleets,
        behaviour,
        beacon,
        radio,
        tightening,
    })
}

impl SwarmParts {
    /// The kinds that could be read whole, as the swarm-wide tables leave them.
    pub(crate) fn tightened_kinds(&self) -> BTreeMap<String, Kind> {
        let tightened = |(name, mut kind): (String, Kind)| {
            self.tightening.apply(&mut kind);
            (name, kind)
        };
        self.whole_kinds().map(tightened).collect()
    }

    /// The swarm-wide keys that tighten none of its kinds; none while a kind could not be read.
    pub(crate) fn idle_keys(&self) -> Vec<String> {
        let kinds: Vec<Kind> = self.whole_kinds().map(|(_, kind)| kind).collect();
        if kinds.len() == self.kinds.len() { self.tightening.idle_keys(&kinds) } else { Vec::new() }
    }

    fn whole_kinds(&self) -> impl Iterator<Item = (String, Kind)> + '_ {
        self.kinds.iter().filter_map(|(name, parts)| Some((name.clone(), parts.kind()?)))
    }
}
