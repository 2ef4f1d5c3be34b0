//! Reads `[generate]` of a world and makes what it says.

use crate::Polygon;
use crate::generate::{
    Cave, Comb, ConvexField, Corridor, Door, Generate, Layout, Maze, Office, Pocket, Rooms, Spiral, Tee, U, Warehouse,
    generate,
};
use crate::reader::Table;
use std::f64::consts::{FRAC_PI_6, PI};

/// How a layout's own keys are read.
type Read = fn(&mut Table<'_>) -> Option<Layout>;

/// A layout in which chance has no part has no seed.
const KINDS: [(&str, Read, bool); 13] = [
    ("convex_field", convex_field, true),
    ("rooms", rooms, true),
    ("office", office, true),
    ("warehouse", warehouse, true),
    ("maze", maze, true),
    ("cave", cave, true),
    ("corridor", corridor, false),
    ("u", u, false),
    ("pocket", pocket, true),
    ("t", tee, false),
    ("spiral", spiral, false),
    ("comb", comb, false),
    ("door", door, false),
];

/// The outlines of `[generate]`; `seed` counts where it has none of its own.
pub(crate) fn outlines(table: &mut Table<'_>, seed: u64) -> Option<Vec<Polygon>> {
    let params = params(table)?;
    match generate(&params, seed) {
        Ok(outlines) => Some(outlines),
        Err(misfit) => {
            table.problem(misfit.key, misfit.words);
            None
        }
    }
}

fn params(table: &mut Table<'_>) -> Option<Generate> {
    let (_, read, random) = KINDS.get(table.word("kind", &KINDS.map(|(kind, _, _)| kind))?)?;
    let width_m = table.number("width_m", 2.0..=1_000.0, None);
    let height_m = table.number("height_m", 2.0..=1_000.0, None);
    let seed = if *random { table.optional_integer("seed", 0..=u64::MAX, "the swarm's") } else { Some(None) };
    let layout = read(table);
    Some(Generate { width_m: width_m?, height_m: height_m?, seed: seed?, layout: layout? })
}

/// Two of the shipped bodies (0.84 m) pass each other with a third of a metre to spare.
fn passage_m(table: &mut Table<'_>) -> Option<f64> {
    table.number("passage_m", 0.2..=50.0, Some(2.0))
}

/// A partition wall.
fn wall_m(table: &mut Table<'_>) -> Option<f64> {
    table.number("wall_m", 0.02..=10.0, Some(0.2))
}

/// One of the shipped bodies passes with its stopping margin on both sides, two do not.
fn door_m(table: &mut Table<'_>) -> Option<f64> {
    table.number("door_m", 0.2..=50.0, Some(1.4))
}

/// Room for a swarm of some rows to start and to arrive.
fn margin_m(table: &mut Table<'_>) -> Option<f64> {
    table.number("margin_m", 0.2..=100.0, Some(3.0))
}

/// None: a tree, with one way between any two places, is the hardest to explore and the easiest to describe.
fn loops(table: &mut Table<'_>) -> Option<f64> {
    table.number("loops", 0.0..=1.0, Some(0.0))
}

/// The flocking paper's pocket is 200 mm deep; lengths times 18, as in the flock's own defaults.
fn depth_m(table: &mut Table<'_>) -> Option<f64> {
    table.number("depth_m", 0.2..=500.0, Some(3.6))
}

fn count(table: &mut Table<'_>, key: &'static str, most: u32, default: u32) -> Option<usize> {
    let least = u32::from(!matches!(key, "desks" | "bends" | "smoothing"));
    table.integer_u32(key, least..=most, Some(default)).and_then(|count| usize::try_from(count).ok())
}

fn convex_field(table: &mut Table<'_>) -> Option<Layout> {
    let count = count(table, "count", 500, 20);
    // As many for every seed.
    let count_max = table.optional_integer("count_max", 1..=500, "count");
    // From a pillar to a car.
    let size_min_m = table.number("size_min_m", 0.1..=100.0, Some(0.5));
    let size_max_m = table.number("size_max_m", 0.1..=100.0, Some(2.0));
    let (passage_m, margin_m) = (passage_m(table), margin_m(table));
    let west_m = table.derived_number("margin_west_m", 0.2..=500.0, "margin_m");
    let east_m = table.derived_number("margin_east_m", 0.2..=500.0, "margin_m");
    let (count, margin_m) = (count?, margin_m?);
    let count_max = count_max?.map_or(Some(count), |most| usize::try_from(most).ok());
    Some(Layout::ConvexField(ConvexField {
        count,
        count_max: count_max?,
        size_min_m: size_min_m?,
        size_max_m: size_max_m?,
        passage_m: passage_m?,
        margin_m,
        west_m: west_m?.unwrap_or(margin_m),
        east_m: east_m?.unwrap_or(margin_m),
    }))
}

fn rooms(table: &mut Table<'_>) -> Option<Layout> {
    let (columns, rows) = (count(table, "columns", 50, 3), count(table, "rows", 50, 3));
    let (door_m, wall_m, loops) = (door_m(table), wall_m(table), loops(table));
    Some(Layout::Rooms(Rooms { columns: columns?, rows: rows?, door_m: door_m?, wall_m: wall_m?, loops: loops? }))
}

fn office(table: &mut Table<'_>) -> Option<Layout> {
    let corridors = count(table, "corridors", 20, 1);
    let passage_m = passage_m(table);
    // A room for two desks.
    let room_m = table.number("room_m", 0.5..=100.0, Some(4.0));
    let (door_m, wall_m) = (door_m(table), wall_m(table));
    // Bare rooms, for a start.
    let desks = count(table, "desks", 20, 0);
    Some(Layout::Office(Office {
        corridors: corridors?,
        passage_m: passage_m?,
        room_m: room_m?,
        door_m: door_m?,
        wall_m: wall_m?,
        desks: desks?,
    }))
}

fn warehouse(table: &mut Table<'_>) -> Option<Layout> {
    // Three bays of pallets, and one pallet deep.
    let rack_m = table.number("rack_m", 0.2..=500.0, Some(8.0));
    let rack_depth_m = table.number("rack_depth_m", 0.1..=50.0, Some(1.1));
    let (passage_m, margin_m) = (passage_m(table), margin_m(table));
    // Some: seeds make different worlds.
    let gaps = table.number("gaps", 0.0..=1.0, Some(0.1));
    Some(Layout::Warehouse(Warehouse {
        rack_m: rack_m?,
        rack_depth_m: rack_depth_m?,
        passage_m: passage_m?,
        margin_m: margin_m?,
        gaps: gaps?,
    }))
}

fn maze(table: &mut Table<'_>) -> Option<Layout> {
    let (passage_m, wall_m, loops) = (passage_m(table), wall_m(table), loops(table));
    Some(Layout::Maze(Maze { passage_m: passage_m?, wall_m: wall_m?, loops: loops? }))
}

fn cave(table: &mut Table<'_>) -> Option<Layout> {
    let passage_m = passage_m(table);
    // Where the automaton makes halls joined by passages: below it, a field of boulders; above it, single caverns.
    let density = table.number("density", 0.0..=1.0, Some(0.45));
    // After four rounds hardly any cell changes.
    let smoothing = count(table, "smoothing", 20, 4);
    // Room for five robots at the flock's spacing, near the south-west corner.
    let clear_x_m = table.number("clear_x_m", 0.0..=1_000.0, Some(5.0));
    let clear_y_m = table.number("clear_y_m", 0.0..=1_000.0, Some(5.0));
    let clear_radius_m = table.number("clear_radius_m", 0.0..=100.0, Some(3.0));
    Some(Layout::Cave(Cave {
        passage_m: passage_m?,
        density: density?,
        smoothing: smoothing?,
        clear_m: [clear_x_m?, clear_y_m?],
        clear_radius_m: clear_radius_m?,
    }))
}

fn corridor(table: &mut Table<'_>) -> Option<Layout> {
    // A straight one.
    let bends = count(table, "bends", 100, 0);
    let (passage_m, wall_m) = (passage_m(table), wall_m(table));
    Some(Layout::Corridor(Corridor { bends: bends?, passage_m: passage_m?, wall_m: wall_m? }))
}

fn u(table: &mut Table<'_>) -> Option<Layout> {
    // The flocking paper's 300 mm, times 18.
    let opening_m = table.number("opening_m", 0.2..=500.0, Some(5.4));
    let (depth_m, wall_m, passage_m) = (depth_m(table), wall_m(table), passage_m(table));
    Some(Layout::U(U { opening_m: opening_m?, depth_m: depth_m?, wall_m: wall_m?, passage_m: passage_m? }))
}

fn pocket(table: &mut Table<'_>) -> Option<Layout> {
    // From a little more than the flocking paper's U, in which a swarm of a dozen hardly finds room, to twice of it.
    let opening_min_m = table.number("opening_min_m", 0.2..=500.0, Some(6.0));
    let opening_max_m = table.number("opening_max_m", 0.2..=500.0, Some(12.0));
    let depth_min_m = table.number("depth_min_m", 0.2..=500.0, Some(5.0));
    let depth_max_m = table.number("depth_max_m", 0.2..=500.0, Some(10.0));
    // As far as it still catches whoever comes from the west.
    let turn_rad_max = table.number("turn_rad_max", 0.0..=PI, Some(FRAC_PI_6));
    let offset_m_max = table.number("offset_m_max", 0.0..=100.0, Some(2.0));
    let (wall_m, passage_m) = (wall_m(table), passage_m(table));
    Some(Layout::Pocket(Pocket {
        opening_m: [opening_min_m?, opening_max_m?],
        depth_m: [depth_min_m?, depth_max_m?],
        wall_m: wall_m?,
        turn_rad_max: turn_rad_max?,
        offset_m_max: offset_m_max?,
        passage_m: passage_m?,
    }))
}

fn tee(table: &mut Table<'_>) -> Option<Layout> {
    // The flocking paper's 300 mm and 200 mm, times 18.
    let bar_m = table.number("bar_m", 0.2..=500.0, Some(5.4));
    let stem_m = table.number("stem_m", 0.2..=500.0, Some(3.6));
    let (wall_m, passage_m) = (wall_m(table), passage_m(table));
    Some(Layout::T(Tee { bar_m: bar_m?, stem_m: stem_m?, wall_m: wall_m?, passage_m: passage_m? }))
}

fn spiral(table: &mut Table<'_>) -> Option<Layout> {
    let turns = count(table, "turns", 100, 2);
    let (passage_m, wall_m) = (passage_m(table), wall_m(table));
    Some(Layout::Spiral(Spiral { turns: turns?, passage_m: passage_m?, wall_m: wall_m? }))
}

fn comb(table: &mut Table<'_>) -> Option<Layout> {
    let pockets = count(table, "pockets", 500, 6);
    let (depth_m, wall_m, passage_m) = (depth_m(table), wall_m(table), passage_m(table));
    Some(Layout::Comb(Comb { pockets: pockets?, depth_m: depth_m?, wall_m: wall_m?, passage_m: passage_m? }))
}

fn door(table: &mut Table<'_>) -> Option<Layout> {
    let (door_m, wall_m) = (door_m(table), wall_m(table));
    Some(Layout::Door(Door { door_m: door_m?, wall_m: wall_m? }))
}
