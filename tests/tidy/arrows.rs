//! The arrows between crates, read from `cargo metadata`.

use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;

/// Who may use whom. The same table stands in docs/ARCHITECTURE.md.
const MAY_USE: [(&str, &[&str]); 15] = [
    ("drover-config", &[]),
    ("drover-contract", &[]),
    ("drover-codec", &["drover-contract"]),
    ("drover-io", &["drover-config", "drover-contract"]),
    ("drover-core", &["drover-config", "drover-contract"]),
    ("drover-world", &["drover-codec", "drover-config", "drover-contract"]),
    ("drover-robot", &["drover-codec", "drover-config", "drover-contract", "drover-core", "drover-io"]),
    ("drover-bridge", &["drover-config", "drover-contract", "drover-io", "drover-world"]),
    (
        "drover-record",
        &["drover-codec", "drover-config", "drover-contract", "drover-core", "drover-io", "drover-robot"],
    ),
    ("drover-live", &["drover-io", "drover-record"]),
    ("drover-foxglove", &["drover-contract", "drover-record"]),
    ("drover-picture", &["drover-record"]),
    (
        "drover-swarm",
        &[
            "drover-bridge",
            "drover-config",
            "drover-contract",
            "drover-core",
            "drover-io",
            "drover-record",
            "drover-robot",
            "drover-world",
        ],
    ),
    (
        "drover-bench",
        &[
            "drover-codec",
            "drover-config",
            "drover-contract",
            "drover-core",
            "drover-io",
            "drover-robot",
            "drover-swarm",
            "drover-world",
        ],
    ),
    (
        "drover",
        &[
            "drover-bench",
            "drover-codec",
            "drover-config",
            "drover-contract",
            "drover-core",
            "drover-foxglove",
            "drover-io",
            "drover-live",
            "drover-picture",
            "drover-record",
            "drover-robot",
            "drover-swarm",
        ],
    ),
];

/// Crates without sockets, runtimes and clocks.
const PURE: [&str; 5] = ["drover-codec", "drover-config", "drover-contract", "drover-core", "drover-world"];
const IMPURE_LIBRARIES: [&str; 6] = ["tokio", "socketcan", "socket2", "mio", "async-io", "nix"];

/// Crate name to the names of what it uses in production.
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let out = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(crate::sources::top())
        .output()
        .expect("cargo runs");
    assert!(out.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&out.stderr));
    let metadata: Value = serde_json::from_slice(&out.stdout).expect("cargo metadata prints JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    packages.iter().map(|package| (text(&package["name"]), production_dependencies(package))).collect()
}

fn production_dependencies(package: &Value) -> Vec<String> {
    let listed = package["dependencies"].as_array().expect("dependencies");
    listed
        .iter()
        .filter(|dependency| dependency["kind"].is_null())
        .map(|dependency| text(&dependency["name"]))
        .collect()
}

fn text(value: &Value) -> String {
    value.as_str().expect("a string").to_owned()
}

#[test]
fn crates_use_only_what_the_table_of_arrows_allows() {
    let used = dependencies();
    let listed: Vec<&str> = MAY_USE.iter().map(|(name, _)| *name).collect();
    let unlisted: Vec<&String> = used.keys().filter(|name| !listed.contains(&name.as_str())).collect();
    assert!(unlisted.is_empty(), "crates without a row in the table: {unlisted:?}");
    for (name, allowed) in MAY_USE {
        let own = used[name].iter().filter(|used| used.starts_with("drover"));
        let wrong: Vec<&String> = own.filter(|used| !allowed.contains(&used.as_str())).collect();
        assert!(wrong.is_empty(), "{name} must not use {wrong:?}");
    }
}

#[test]
fn pure_crates_list_no_runtime_and_no_socket() {
    let used = dependencies();
    for name in PURE {
        let wrong: Vec<&String> = used[name].iter().filter(|used| IMPURE_LIBRARIES.contains(&used.as_str())).collect();
        assert!(wrong.is_empty(), "{name} is pure and must not use {wrong:?}");
        let rules = crate::sources::top().join(folder_of(name)).join("clippy.toml");
        let rules = std::fs::read_to_string(&rules).unwrap_or_else(|error| panic!("{}: {error}", rules.display()));
        assert!(rules.contains("std::time::Instant::now"), "{name}'s clippy.toml does not ban the clock");
    }
}

fn folder_of(name: &str) -> &'static str {
    match name {
        "drover-codec" => "firmware_if/codec",
        "drover-config" => "config",
        "drover-contract" => "firmware_if/contract",
        "drover-core" => "controller/core",
        "drover-world" => "sim_bridge/world",
        other => panic!("{other} is not pure"),
    }
}
