//! Rules that matter are tests: the arrows between crates, the size of files and functions, who may make a command.

mod arrows;
mod docs;
mod sizes;
mod sources;

use sources::{Source, production_sources};

/// Invariant 1: the supervisor is the only caller of `SafeCommand::bounded`, so no path to a wheel avoids it.
#[test]
fn only_the_supervisor_makes_a_moving_command() {
    let callers: Vec<String> = production_sources()
        .iter()
        .filter(|source| source.production_text().contains("SafeCommand::bounded("))
        .map(|source| source.name.clone())
        .collect();
    assert_eq!(callers, ["controller/core/src/supervisor/action.rs"]);
}

/// Design: parry is named in one file, which converts at its border.
#[test]
fn parry_is_named_in_one_file() {
    let namers: Vec<String> = production_sources()
        .iter()
        .filter(|source| source.production_text().contains("parry2d"))
        .map(|source| source.name.clone())
        .collect();
    assert_eq!(namers, ["sim_bridge/world/src/geometry.rs"]);
}

/// Design: drover-io is the only crate that opens a socket.
#[test]
fn only_io_names_sockets() {
    let words = ["UdpSocket", "socketcan::", "socket2::", "TcpStream", "TcpListener"];
    let namers: Vec<&Source> = Box::leak(Box::new(production_sources()))
        .iter()
        .filter(|source| !source.name.starts_with("firmware_if/io/"))
        .filter(|source| words.iter().any(|word| source.production_text().contains(word)))
        .collect();
    let names: Vec<&str> = namers.iter().map(|source| source.name.as_str()).collect();
    assert!(names.is_empty(), "sockets outside of drover-io: {names:?}");
}
