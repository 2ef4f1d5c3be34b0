//! A direct robot that thinks along with a robot of the wire: same body, same sensors' chance, its own mind.

use drover_config::Swarm;
use drover_contract::{Beacon, Event, RobotId, Stamp};
use drover_core::{Node, Roster, Status};
use drover_swarm::VirtualSwarm;
use drover_world::{BodySpec, IdealDevice, Lidar, Radio};
use std::sync::Arc;
use std::time::Duration;

/// As in every run loop: a fresh scan makes a tick, but not more often than this.
const SCAN_TICK_SPACING: Duration = Duration::from_millis(5);

/// All robots of a swarm on values, whose bodies are those of a swarm on the wire: what they command moves nothing.
pub(crate) struct Shadows {
    minds: Vec<Mind>,
    radio: Radio<Beacon>,
}

struct Mind {
    node: Node,
    device: IdealDevice,
    lidar: Lidar,
    scan_tick_due: Stamp,
}

impl Shadows {
    /// Robot i's drive is ready from `ready[i]` on, as it was on the wire.
    pub(crate) fn new(swarm: &Swarm, ready: &[Stamp]) -> Self {
        let radius_m = |robot| swarm.kind_of(robot).body.radius_m;
        let roster = Arc::new(Roster::new(swarm.robots.iter().map(|robot| (RobotId(robot.id), radius_m(robot)))));
        let bodies = BodySpec::all_of(swarm);
        let mind = |((robot, body), at): ((&drover_config::Robot, &BodySpec), &Stamp)| {
            let file = swarm.file_without_peers(robot);
            let mut device = IdealDevice::new(&file.kind, robot.id, swarm.seed, Stamp::ZERO);
            device.set_ready_at(*at);
            let node = Node::in_swarm(&file, Arc::clone(&roster), 1, Stamp::ZERO);
            Mind { node, device, lidar: Lidar::new(body.lidar, swarm.seed, body.key), scan_tick_due: Stamp::ZERO }
        };
        let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
        Self {
            minds: swarm.robots.iter().zip(&bodies).zip(ready).map(mind).collect(),
            radio: Radio::new(&swarm.radio, &ids, swarm.seed),
        }
    }

    /// Sense and decide where the wire's bodies are now.
    pub(crate) fn step(&mut self, wire: &VirtualSwarm) {
        let (now, arena) = (wire.now(), wire.plant().arena());
        for (robot, mind) in self.minds.iter_mut().enumerate() {
            mind.turn(now, robot, wire);
            if let Some(beacon) = mind.node.poll_beacon(now) {
                self.radio.broadcast(now, robot, arena.place(), beacon);
            }
        }
        let minds = &mut self.minds;
        self.radio.deliver(now, |to, _, beacon| minds[to].node.handle_beacon(now, beacon));
    }

    /// What robot `robot`'s shadow makes of it all.
    pub(crate) fn status(&self, robot: usize) -> &Status {
        self.minds[robot].node.status()
    }
}

impl Mind {
    fn turn(&mut self, now: Stamp, robot: usize, wire: &VirtualSwarm) {
        let Self { node, device, lidar, .. } = self;
        let (arena, mut fresh) = (wire.plant().arena(), false);
        let state = arena.state(robot);
        let cast = || lidar.scan(now, state.pose_wb, &arena.place().seen_by(robot));
        device.step(now, &state, cast, &mut |event| {
            fresh |= matches!(event, Event::Scan(_));
            node.handle_event(now, event);
        });
        if node.tick_due(now) || (fresh && now >= self.scan_tick_due) {
            self.scan_tick_due = now + SCAN_TICK_SPACING;
            let _ = node.tick(now); // moves nothing
        }
    }
}
