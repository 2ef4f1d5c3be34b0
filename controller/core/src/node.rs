//! One robot: mailboxes, estimate, peers, law, limit, supervisor, wired in this order. Nothing is decided here.

use crate::avoid::Disc;
use crate::cadence::{Beat, Cadence};
use crate::estimate::{Estimate, Motion};
use crate::law::explore::Surveyor;
use crate::law::pacts::place;
use crate::law::{Law, Outcome, View};
use crate::limit::{limit, limits_of};
use crate::links::LinkPeer;
use crate::mailbox::Mailbox;
use crate::map::SharedMap;
use crate::peers::{Body, Neighbour, Peers, Roster};
use crate::sight::{Matches, Surroundings};
use crate::status::{Counters, HeardPeer, Status};
use crate::supervisor::conditions::{Ages, RequestFact};
use crate::supervisor::{self, Conditions, GuardParams, Obstacles, Reason, StopReason, Supervisor, Verdict, near_side};
use drover_config::{Drive, Mount, RobotFile, Timeouts};
use drover_contract::{
    Beacon, BehaviourState, Event, Limits, LinkReport, MapReport, Pose, RobotId, SafeCommand, Scan, Stamp, Twist, Vec2,
};
use nalgebra::Isometry2;
use std::sync::Arc;
use std::time::Duration;

/// From a measurement to wheels that obey it, beside the tick: sensor, links and drive, seconds.
const LATENCY_S: f64 = 0.1;

/// What matching hits to bodies allows beside their bounds, and rounding, metres.
const BODY_SLACK_M: f64 = 1.0;

/// One robot's controller.
///
/// Feed it with `handle_*`; call [`Node::tick`] when [`Node::poll_timeout`] says so and whenever a fresh scan has been
/// handled; send what it returns. It never waits, and it stops by itself when what it needs is absent.
#[derive(Clone, Debug)]
pub struct Node {
    id: RobotId,
    epoch: u32,
    seq: u32,
    radius_m: f64,
    limits: Limits,
    timeouts: Timeouts,
    needs_fix: bool,
    beacon_every: Duration,
    beacon_due: Stamp,
    cadence: Cadence,
    mailbox: Mailbox,
    estimate: Estimate,
    peers: Peers,
    law: Law,
    /// What to tell of links, beside the newest beacon.
    links_due: Option<LinkReport>,
    /// What to tell of the map, beside it, the first last.
    maps_due: Vec<MapReport>,
    supervisor: Supervisor,
    guard: GuardParams,
    /// Where the lidar sits on the body.
    mount: Isometry2<f64>,
    workspace: Workspace,
    status: Status,
}

/// What a tick works on. Nothing in it lives longer than the tick but the memory of its lists: who turns thousands of
/// nodes lends the same one to all of them ([`Node::tick_in`]), so that it stays in the processor's cache.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    seen: Surroundings,
    bodies: Vec<Body>,
    matches: Matches,
    neighbours: Vec<Neighbour>,
    unseen_b: Vec<Vec2>,
    walls_b: Vec<Vec2>,
    discs: Vec<Disc>,
    obstacles: Obstacles,
    scratch: supervisor::Scratch,
}

impl Node {
    /// The robot of `file`, in its life `epoch` (greater after every restart), starting now.
    #[must_use]
    pub fn new(file: &RobotFile, epoch: u32, now: Stamp) -> Self {
        let peers = file.peers.iter().map(|peer| (RobotId(peer.id), peer.radius_m));
        Self::in_swarm(file, Arc::new(Roster::new(peers)), epoch, now)
    }

    /// The same for one of many robots in a process, which share the list of all of them; `file.peers` is not read.
    #[must_use]
    pub fn in_swarm(file: &RobotFile, roster: Arc<Roster>, epoch: u32, now: Stamp) -> Self {
        let id = RobotId(file.robot.id);
        let timeouts = file.kind.timeouts;
        let tick = Duration::from_millis(u64::from(timeouts.tick_ms));
        let start_wb = Pose::new(file.robot.start.x_m, file.robot.start.y_m, file.robot.start.yaw_rad);
        let guard = guard_params(file, tick);
        let peer_timeout = Duration::from_millis(u64::from(timeouts.peer_ms));
        Self {
            id,
            epoch,
            seq: 0,
            radius_m: file.kind.body.radius_m,
            limits: guard.limits,
            timeouts,
            needs_fix: matches!(file.kind.drive, Drive::Mavlink { .. }),
            beacon_every: Duration::from_secs_f64(1.0 / file.beacon.rate_hz.clamp(1.0, 50.0)),
            beacon_due: now,
            cadence: Cadence::new(tick, now),
            mailbox: Mailbox::default(),
            estimate: Estimate::new(start_wb, file.kind.body.track_m),
            law: Law::new(file, &roster, epoch, now),
            links_due: None,
            maps_due: Vec::new(),
            peers: Peers::new(id, roster, peer_timeout),
            supervisor: Supervisor::new(guard),
            guard,
            mount: mount_of(&file.kind.lidar.mount),
            workspace: Workspace::default(),
            status: Status::first(now, start_wb),
        }
    }

    /// Takes what a codec learned. The newest of each kind replaces all older ones.
    pub fn handle_event(&mut self, _now: Stamp, event: Event) {
        match event {
            Event::Odometry(odometry) => self.estimate.handle_odometry(odometry),
            Event::Pose(fix) => self.estimate.handle_fix(fix),
            Event::Scan(scan) => self.mailbox.put_scan(scan),
            Event::Drive(state) => self.mailbox.drive = state,
            Event::Battery(battery) => self.mailbox.battery = Some(battery),
            Event::Text(severity, words) => self.mailbox.text = Some((severity, words)),
        }
    }

    /// Takes a peer's beacon; old, duplicate, unknown and malformed ones are counted and dropped.
    pub fn handle_beacon(&mut self, now: Stamp, beacon: &Beacon) {
        self.peers.handle_beacon(now, beacon);
    }

    /// Takes what a peer reports of its links; nothing to a behaviour that keeps none.
    pub fn handle_links(&mut self, now: Stamp, report: &LinkReport) {
        let motion = self.estimate.motion(now);
        if let Some(law) = self.law.tied_mut() {
            let place = place(law, motion.pose_wb.position(), motion.twist_b.speed_mps, self.limits.brake_mps2);
            law.handle_report(now, report, &place);
        }
    }

    /// Takes what a peer tells of the map; nothing to a behaviour that makes none.
    pub fn handle_map(&mut self, now: Stamp, report: &MapReport) {
        if let Some(law) = self.law.surveyor_mut() {
            law.handle_report(now, report);
        }
    }

    /// Stops for good: every tick from now on answers STOP, until the program starts anew.
    pub fn handle_stop(&mut self, now: Stamp, reason: StopReason) {
        self.supervisor.handle_stop(reason);
        self.law.halt();
        self.status.stamp = now;
        self.status.verdict = self.supervisor.verdict();
        self.status.state = BehaviourState::Stopped;
        self.status.request = None;
        self.status.command = SafeCommand::STOP;
        self.status.changed = None;
    }

    /// One tick: the whole way from what is known to the command to send now.
    pub fn tick(&mut self, now: Stamp) -> SafeCommand {
        let mut workspace = std::mem::take(&mut self.workspace);
        let command = self.tick_in(now, &mut workspace);
        self.workspace = workspace;
        command
    }

    /// The same with a workspace that is lent for it.
    pub fn tick_in(&mut self, now: Stamp, scene: &mut Workspace) -> SafeCommand {
        let beat = self.cadence.beat(now);
        let motion = self.estimate.motion(now);
        self.look_around(now, &motion, scene);
        scene.discs.clear();
        if let Some(law) = self.law.tied() {
            law.discs(&mut |disc| scene.discs.push(disc));
        }
        let mut facts = self.sense(now, beat, scene.seen.unknown_share);
        let request = if facts.fit() { self.ask(now, beat, motion, scene) } else { Err("not fit to move") };
        facts.request = RequestFact::of(request);
        let unheard = self.peers.heard(now) < self.peers.known();
        let Workspace { seen, bodies, matches, discs, obstacles, scratch, .. } = scene;
        let peers = supervisor::Peers { bodies, matches, own_bound_m: motion.pos_bound_m, unheard };
        obstacles.fill(seen, &peers, self.guard.keep_m(), self.guard.reach_m_max(motion.twist_b));
        let in_body = |disc: &Disc| (motion.pose_wb.inverse_transform(disc.centre_w), disc.radius_m);
        obstacles.stay_in(discs.iter().map(in_body));
        let decision = self.supervisor.tick(&facts, request.ok(), motion.twist_b, obstacles, scratch);
        self.status.nearest_m = seen.nearest_m;
        self.status.request = request.ok();
        self.status.changed = decision.changed.as_ref().map(Reason::label);
        if decision.command.is_stop() {
            // After a stop the law starts anew: nothing of the motion before is carried into the next command.
            self.law.halt();
        }
        self.count(beat, decision.command, decision.changed);
        self.report(now, motion, decision.command);
        decision.command
    }

    fn sense(&self, now: Stamp, beat: Beat, unknown_share: f64) -> Conditions {
        let ages = self.ages(now);
        let facts = Conditions::sensed(&self.mailbox.drive, ages, unknown_share, &self.timeouts);
        Conditions { late: beat.late, ..facts }
    }

    fn ages(&self, now: Stamp) -> Ages {
        let odometry = self.estimate.odometry_age(now);
        // Who ever had a fix goes on needing it: it has left dead reckoning behind.
        let fix = self.estimate.fix_age(now);
        let pose = if self.needs_fix || fix.is_some() { fix } else { odometry };
        Ages { scan: self.mailbox.scan_age(now), odometry, pose }
    }

    /// The scan of now, and the bodies that are in it or within reach.
    fn look_around(&self, now: Stamp, motion: &Motion, scene: &mut Workspace) {
        let Workspace { seen, bodies, matches, .. } = scene;
        match &self.mailbox.scan {
            Some(scan) => seen.look(scan, &self.mount, motion, now),
            None => seen.clear(),
        }
        // A peer may use half of the gap: one that limits us within our reach is no farther than twice that. And what
        // the law takes for a wall must be none of the peers that stand there.
        let reach_m = self.guard.reach_m_max(motion.twist_b);
        let range_m = self.law.range_m().max(2.0 * reach_m + self.guard.keep_m()) + BODY_SLACK_M;
        bodies.clear();
        bodies.extend(self.peers.bodies(now, motion.pose_wb.position(), range_m + motion.pos_bound_m));
        matches.find(seen, motion, bodies);
    }

    /// What the law wishes, limited; or why there is no wish.
    fn ask(&mut self, now: Stamp, beat: Beat, motion: Motion, scene: &mut Workspace) -> Result<Twist, &'static str> {
        scene.neighbours.clear();
        if self.law.asks_for_peers() {
            scene.neighbours.extend(self.peers.followable(now));
        }
        scene.unseen_b.clear();
        if self.law.minds_unseen() {
            let places = scene.bodies.iter().zip(&scene.matches.bodies);
            scene.unseen_b.extend(places.filter_map(|(body, place)| near_side(body, *place, motion.pos_bound_m)));
        }
        scene.walls_b.clear();
        if self.law.asks_for_walls() {
            scene.walls_b.extend(scene.matches.walls(&scene.seen));
        }
        let view = View {
            now,
            dt_s: beat.dt_s,
            motion,
            neighbours: &scene.neighbours,
            walls_b: &scene.walls_b,
            points_b: &scene.seen.points_b,
            unseen_b: &scene.unseen_b,
            scan: self.mailbox.scan.as_ref().map(|scan| (scan, *scene.seen.sensor_b())),
            bodies: &scene.bodies,
            discs: &scene.discs,
            limits: &self.limits,
        };
        match self.law.step(&view) {
            Outcome::Solved(wish) => Ok(limit(wish, self.supervisor.before(), &self.limits, beat.dt_s)),
            Outcome::Stale(why) => Err(why),
        }
    }

    fn count(&mut self, beat: Beat, command: SafeCommand, changed: Option<Reason>) {
        let counters = &mut self.status.counters;
        counters.ticks += 1;
        counters.late_ticks += u64::from(beat.late);
        if let Some(reason) = changed {
            *counters.changed.entry(reason.label()).or_default() += 1;
            counters.stops += u64::from(command.is_stop() && !self.status.command.is_stop());
        }
        copy_beacon_counts(counters, &self.peers);
    }

    fn report(&mut self, now: Stamp, motion: Motion, command: SafeCommand) {
        let ages = self.ages(now);
        let status = &mut self.status;
        status.stamp = now;
        status.drive.clone_from(&self.mailbox.drive);
        status.verdict = self.supervisor.verdict();
        status.reached = self.law.reached();
        status.state = behaviour_state(status.verdict, status.reached);
        status.pose_wb = motion.pose_wb;
        status.pos_bound_m = motion.pos_bound_m;
        status.twist_b = motion.twist_b;
        status.command = command;
        status.scan_age = ages.scan;
        status.odometry_age = ages.odometry;
        status.progress = self.law.progress();
        status.leader = self.law.leader();
        status.gives_way_to = self.law.gives_way_to();
        status.counters.wall_entries = u64::from(self.law.wall_entries());
        status.target_w = self.law.target_w();
        status.path_m = self.estimate.travelled_m();
        status.peers_heard = self.peers.heard(now);
        status.battery = self.mailbox.battery;
        status.text.clone_from(&self.mailbox.text);
    }

    /// The beacon that is due, if one is. The newest state goes out; missed ones are not made up for.
    pub fn poll_beacon(&mut self, now: Stamp) -> Option<Beacon> {
        if now < self.beacon_due {
            return None;
        }
        let next = self.beacon_due + self.beacon_every;
        self.beacon_due = if next > now { next } else { now + self.beacon_every };
        self.seq = self.seq.saturating_add(1);
        let motion = self.estimate.motion(now);
        if let Some(law) = self.law.tied_mut() {
            let place = place(law, motion.pose_wb.position(), motion.twist_b.speed_mps, self.limits.brake_mps2);
            let peers: Vec<LinkPeer> = self.peers.told(now).collect();
            self.links_due = law.attend(now, &place, &peers);
        }
        self.maps_due = self.law.surveyor_mut().map(|law| law.reports(now)).unwrap_or_default();
        Some(Beacon {
            robot: self.id,
            epoch: self.epoch,
            seq: self.seq,
            sent: now,
            pose_wb: motion.pose_wb,
            twist_b: motion.twist_b,
            accel_mps2: motion.accel_mps2,
            pos_bound_m: motion.pos_bound_m,
            radius_m: self.radius_m,
            state: self.status.state,
            progress: self.status.progress,
            leader: self.law.leader(),
        })
    }

    /// What to tell of links beside the beacon that [`Node::poll_beacon`] has just given, if the behaviour keeps any.
    pub fn poll_links(&mut self) -> Option<LinkReport> {
        self.links_due.take()
    }

    /// What to tell of the map beside the beacon that [`Node::poll_beacon`] has just given, one after the other, if the
    /// behaviour makes one.
    pub fn poll_map(&mut self) -> Option<MapReport> {
        self.maps_due.pop()
    }

    /// The map that it makes, if its behaviour makes one.
    #[must_use]
    pub fn map(&self) -> Option<&SharedMap> {
        self.law.surveyor().map(Surveyor::map)
    }

    /// The robot as of its last tick.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// The newest scan.
    #[must_use]
    pub fn scan(&self) -> Option<&Scan> {
        self.mailbox.scan.as_ref()
    }

    /// The peers heard within their timeout, sorted by id.
    pub fn heard(&self, now: Stamp) -> impl Iterator<Item = HeardPeer> + '_ {
        self.peers.ages(now).map(|(id, age)| HeardPeer { id, age, kept: self.law.relies_on(id) })
    }

    /// Heap bytes held for the newest scan, the peers and the map; what a tick works on is lent.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let scan = self.mailbox.scan.as_ref();
        let scan = scan.map_or(0, |scan| scan.beams.capacity() * size_of::<drover_contract::Beam>());
        scan + self.peers.bytes() + self.map().map_or(0, SharedMap::bytes)
    }

    /// Whether the next tick is due.
    #[must_use]
    pub fn tick_due(&self, now: Stamp) -> bool {
        now >= self.cadence.due()
    }

    /// When to come back at the latest, and for what.
    #[must_use]
    pub fn poll_timeout(&self) -> (Stamp, &'static str) {
        let tick = self.cadence.due();
        if self.beacon_due < tick { (self.beacon_due, "beacon") } else { (tick, "tick") }
    }
}

fn mount_of(mount: &Mount) -> Isometry2<f64> {
    Pose::new(mount.x_m, mount.y_m, mount.yaw_rad).isometry()
}

fn guard_params(file: &RobotFile, tick: Duration) -> GuardParams {
    let motion = file.kind.motion;
    GuardParams {
        limits: limits_of(&motion),
        radius_m: file.kind.body.radius_m,
        margin_m: motion.margin_m,
        latency_s: LATENCY_S,
        tick_s: tick.as_secs_f64(),
    }
}

fn copy_beacon_counts(counters: &mut Counters, peers: &Peers) {
    let counts = peers.counts();
    counters.beacons_taken = counts.taken;
    counters.beacons_old = counts.old;
    counters.beacons_duplicate = counts.duplicate;
    counters.beacons_refused = counts.own + counts.unknown + counts.malformed;
}

fn behaviour_state(verdict: Verdict, reached: bool) -> BehaviourState {
    match verdict {
        Verdict::Stopped(_) => BehaviourState::Stopped,
        Verdict::Waiting(_) => BehaviourState::Waiting,
        Verdict::Driving | Verdict::Held(_) if reached => BehaviourState::Done,
        Verdict::Driving => BehaviourState::Active,
        Verdict::Held(_) => BehaviourState::Held,
    }
}

#[cfg(test)]
#[path = "node_tests.rs"]
mod tests;
