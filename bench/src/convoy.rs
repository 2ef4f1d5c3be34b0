//! A swarm of any size for benches: MAVLink rovers in a grid on an open field, behind a leader that drives straight on.

use drover_config::{Behaviour, Flock, Links, Party, Robot, Start, Swarm, World};

/// Between two robots of the grid, metres.
const PITCH_M: f64 = 2.5;

/// `template` with `count` robots of its kind `kind`, in a square grid, autopilots from `port_base` upwards.
///
/// # Errors
/// If the ids do not fit MAVLink's or the ports do not fit UDP's.
pub fn convoy(template: &Swarm, kind: &str, count: u32, port_base: u16) -> anyhow::Result<Swarm> {
    anyhow::ensure!((1..=250).contains(&count), "1..=250 MAVLink robots, not {count}");
    anyhow::ensure!(u32::from(port_base) + count <= 65_535, "ports from {port_base} upwards end at 65535");
    anyhow::ensure!(template.kinds.contains_key(kind), "the swarm has no kind {kind}");
    let side = f64::from(count).sqrt().ceil();
    let place = |index: u32| {
        let (row, column) = ((f64::from(index) / side).floor(), f64::from(index) % side);
        // The leader, first in the file, stands in front.
        Start { x_m: -row * PITCH_M, y_m: (column - (side - 1.0) / 2.0) * PITCH_M, yaw_rad: 0.0 }
    };
    let robots = (0..count).map(|index| Robot {
        id: index + 1,
        kind: kind.to_owned(),
        start: place(index),
        links: Links::Mavlink { autopilot: format!("udpout:127.0.0.1:{}", u32::from(port_base) + index + 1) },
    });
    let Behaviour::Flock(flock) = &template.behaviour else {
        anyhow::bail!("swarm {:?} does not flock; a convoy follows a leader", template.name);
    };
    Ok(Swarm {
        name: format!("convoy-{count}"),
        robots: robots.collect(),
        world: World { name: "open field".into(), ..World::default() },
        behaviour: Behaviour::Flock(Flock { parties: vec![Party::of_all(1, vec![[1000.0, 0.0]])], ..flock.clone() }),
        mavlink_port_base: port_base,
        ..template.clone()
    })
}
