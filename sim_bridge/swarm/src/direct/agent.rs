//! One robot on values: its node, its ideal firmware, its ears.

use super::inbox::Words;
use drover_config::RobotFile;
use drover_contract::{Event, Stamp, Twist};
use drover_core::map::SharedMap;
use drover_core::{Node, Roster, Status, Workspace};
use drover_robot::{HeardView, ScanView, View};
use drover_world::{BodyState, IdealDevice, Lidar, Place};
use std::sync::Arc;
use std::time::Duration;

/// A fresh scan is acted on at once, but not more often than this; the run loop of a real robot does the same.
const SCAN_TICK_SPACING_MIN: Duration = Duration::from_millis(5);
/// Which life a robot is in: nobody dies here.
const EPOCH: u32 = 1;

/// One robot.
pub(super) struct Agent {
    id: u32,
    node: Node,
    device: IdealDevice,
    fresh_scan: bool,
    last_scan_tick: Option<Stamp>,
}

/// What a robot has around it in one turn, and what it hears.
pub(super) struct Around<'a, H> {
    pub(super) place: &'a Place,
    pub(super) robot: usize,
    pub(super) lidar: &'a mut Lidar,
    pub(super) state: BodyState,
    pub(super) heard: H,
}

impl Agent {
    pub(super) fn new(file: &RobotFile, roster: &Arc<Roster>, seed: u64) -> Self {
        Self {
            id: file.robot.id,
            node: Node::in_swarm(file, Arc::clone(roster), EPOCH, Stamp::ZERO),
            device: IdealDevice::new(&file.kind, file.robot.id, seed, Stamp::ZERO),
            fresh_scan: false,
            last_scan_tick: None,
        }
    }

    /// Sense, decide, command: the turn of a real robot's loop, in its order. What it tells its peers, if it is time
    /// to.
    pub(super) fn turn<'h, H>(
        &mut self,
        now: Stamp,
        around: &mut Around<'_, H>,
        workspace: &mut Workspace,
    ) -> Option<Words>
    where
        H: Iterator<Item = &'h Words>,
    {
        for words in &mut around.heard {
            self.node.handle_beacon(now, &words.beacon);
            if let Some(report) = &words.links {
                self.node.handle_links(now, report);
            }
            words.maps.iter().for_each(|report| self.node.handle_map(now, report));
        }
        let Self { node, device, fresh_scan, .. } = self;
        let Around { place, robot, lidar, state, .. } = around;
        let cast = || lidar.scan(now, state.pose_wb, &place.seen_by(*robot));
        device.step(now, state, cast, &mut |event| {
            *fresh_scan |= matches!(event, Event::Scan(_));
            node.handle_event(now, event);
        });
        if self.tick_due(now) {
            if std::mem::take(&mut self.fresh_scan) {
                self.last_scan_tick = Some(now);
            }
            let command = self.node.tick_in(now, workspace);
            self.device.command(now, command.twist_b());
        }
        let beacon = self.node.poll_beacon(now)?;
        Some(Words {
            beacon,
            links: self.node.poll_links().map(Box::new),
            maps: std::iter::from_fn(|| self.node.poll_map()).collect(),
        })
    }

    fn tick_due(&self, now: Stamp) -> bool {
        let scan_due = self.last_scan_tick.map_or(Stamp::ZERO, |last| last + SCAN_TICK_SPACING_MIN);
        self.node.tick_due(now) || (self.fresh_scan && now >= scan_due)
    }

    pub(super) fn demand(&self) -> Twist {
        self.device.demand()
    }

    pub(super) fn set_ready_at(&mut self, at: Stamp) {
        self.device.set_ready_at(at);
    }

    pub(super) fn status(&self) -> &Status {
        self.node.status()
    }

    /// What it tells of itself.
    pub(super) fn view(&self, now: Stamp) -> View {
        let heard = self.node.heard(now).map(HeardView::from).collect();
        let scan = self.node.scan().map(ScanView::from);
        View { heard, scan, ..View::of_status(self.id, self.node.status(), now) }
    }

    pub(super) fn map(&self) -> Option<&SharedMap> {
        self.node.map()
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.node.bytes() + self.device.bytes()
    }
}
