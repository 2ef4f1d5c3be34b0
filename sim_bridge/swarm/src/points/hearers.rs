//! Points that know each other by beacons: each speaks and decides at moments of its own, and hears late or never.
//!
//! A robot decides every period; what it decided is carried out in steps of the world, and in each of them the last
//! layer has its word again, as on a robot whose sensors are much faster than its radio: C by the discs agreed by then,
//! R by the robots that are sensed now, O by the walls.

use drover_config::{Deploy, Swarm};
use drover_contract::{LinkReport, RobotId, Stamp, Vec2};
use drover_core::avoid::{Capsule, SafeSet, SafeSetParams, Steer, Steering};
use drover_core::deploy::{Around, Places, Teammate};
use drover_core::links::{LinkPeer, Place};
use drover_world::{Arena, Radio, RadioTally, phases};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// Bytes of a report of seven links on the air, header and checksum included.
const REPORT_BYTES: u64 = 201;
/// Robots nearer than this are sensed, whatever the radio says: the paper's perception radius, metres.
const SENSE_M: f64 = 2.5;
/// Whom a robot has not heard for this long it does not reckon with, seconds.
const FORGET_S: f64 = 3.0;
/// By how much a point's position may be wrong, metres: rounding, and no more.
const MARGIN_M: f64 = 1e-4;
/// Which life a robot is in: nobody comes back.
const EPOCH: u32 = 1;

/// What a robot says.
struct Said {
    robot: RobotId,
    sent: Stamp,
    pos_w: Vec2,
    vel_w: Vec2,
    report: LinkReport,
}

/// What a robot heard last of another.
#[derive(Clone, Copy)]
struct Heard {
    sent: Stamp,
    pos_w: Vec2,
    vel_w: Vec2,
}

/// A swarm of them.
pub(super) struct Hearers {
    ids: Vec<RobotId>,
    mates: Vec<Teammate>,
    heard: Vec<BTreeMap<RobotId, Heard>>,
    radio: Radio<Arc<Said>>,
    walls: Vec<Capsule>,
    safe: SafeSetParams,
    period: Duration,
    beat: Duration,
    /// When each decides next, and speaks next.
    decide_due: Vec<Stamp>,
    beat_due: Vec<Stamp>,
    ends_w: Vec<Vec2>,
    velocities_w: Vec<Vec2>,
    said: u64,
}

/// The swarm as it is, for one turn.
pub(super) struct Scene<'a> {
    pub(super) now: Stamp,
    pub(super) arena: &'a Arena,
    pub(super) at_w: &'a [Vec2],
    pub(super) alive: &'a [bool],
}

/// What one robot decided.
pub(super) struct Decided {
    pub(super) robot: usize,
    pub(super) changed: bool,
}

impl Hearers {
    pub(super) fn new(swarm: &Swarm, deploy: &Deploy, starts_w: &[Vec2], walls: Vec<Capsule>) -> Self {
        let ids: Vec<RobotId> = swarm.robots.iter().map(|robot| RobotId(robot.id)).collect();
        let places = Arc::new(Places::new(ids.iter().copied(), &deploy.targets_m, deploy.range_m));
        let mate = |id: &RobotId| Teammate::new(deploy, Arc::clone(&places), (*id, EPOCH), MARGIN_M, Stamp::ZERO);
        let period = Duration::from_secs_f64(deploy.period_s);
        let beat = Duration::from_secs_f64(1.0 / swarm.beacon.rate_hz.clamp(1.0, 50.0));
        // Nobody's period begins when another's does.
        let phase = |id: &RobotId, which: usize, span: Duration| {
            Stamp::ZERO + span.mul_f64(phases(swarm.seed, u64::from(id.0))[which])
        };
        let plain: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
        Self {
            mates: ids.iter().map(mate).collect(),
            heard: vec![BTreeMap::new(); ids.len()],
            radio: Radio::new(&swarm.radio, &plain, swarm.seed),
            walls,
            safe: SafeSetParams {
                robot_gap_m: deploy.robot_gap_m,
                wall_gap_m: deploy.wall_gap_m,
                step_m_max: deploy.speed_mps * deploy.period_s,
            },
            period,
            beat,
            decide_due: ids.iter().map(|id| phase(id, 0, period)).collect(),
            beat_due: ids.iter().map(|id| phase(id, 1, beat)).collect(),
            ends_w: starts_w.to_vec(),
            velocities_w: vec![Vec2::zeros(); ids.len()],
            said: 0,
            ids,
        }
    }

    pub(super) fn mate(&self, robot: usize) -> &Teammate {
        &self.mates[robot]
    }

    pub(super) fn radio(&self) -> RadioTally {
        self.radio.tally()
    }

    pub(super) fn messages_bytes(&self) -> u64 {
        self.said * (super::BEACON_BYTES + REPORT_BYTES)
    }

    /// Whom `robot` has heard lately, and how long ago.
    pub(super) fn heard(&self, robot: usize, now: Stamp) -> impl Iterator<Item = (RobotId, Duration)> + '_ {
        let aged = self.heard[robot].iter().map(move |(id, heard)| (*id, now.since(heard.sent)));
        aged.filter(|(_, age)| age.as_secs_f64() <= FORGET_S)
    }

    /// Hear, speak and decide; who decided.
    pub(super) fn turn(&mut self, scene: &Scene<'_>) -> Vec<Decided> {
        self.hear(scene);
        let mut decided = Vec::new();
        for robot in (0..self.ids.len()).filter(|robot| scene.alive[*robot]) {
            if scene.now >= self.beat_due[robot] {
                self.beat_due[robot] = self.beat_due[robot] + self.beat;
                self.speak(robot, scene);
            }
            if scene.now >= self.decide_due[robot] {
                self.decide_due[robot] = self.decide_due[robot] + self.period;
                decided.push(Decided { robot, changed: self.decide(robot, scene) });
            }
        }
        decided
    }

    fn hear(&mut self, scene: &Scene<'_>) {
        let Self { radio, heard, mates, velocities_w, .. } = self;
        radio.deliver(scene.now, |to, _, said| {
            if !scene.alive[to] {
                return;
            }
            let news = Heard { sent: said.sent, pos_w: said.pos_w, vel_w: said.vel_w };
            let known = heard[to].entry(said.robot).or_insert(news);
            if said.sent > known.sent {
                *known = news;
            }
            let place = Place { pos_w: scene.at_w[to], wish_w: velocities_w[to], stop_m: 0.0 };
            mates[to].handle_report(scene.now, &said.report, &place);
        });
    }

    fn speak(&mut self, robot: usize, scene: &Scene<'_>) {
        let (now, pos_w, vel_w) = (scene.now, scene.at_w[robot], self.velocities_w[robot]);
        let peers = self.peers(robot, now);
        let wish_w = (self.ends_w[robot] - pos_w) / self.period.as_secs_f64();
        self.mates[robot].attend(now, &Place { pos_w, wish_w, stop_m: 0.0 }, &peers);
        let report = self.mates[robot].report(now);
        let said = Said { robot: self.ids[robot], sent: now, pos_w, vel_w, report };
        self.said += 1;
        self.radio.broadcast(now, robot, scene.arena.place(), Arc::new(said));
    }

    fn peers(&self, robot: usize, now: Stamp) -> Vec<LinkPeer> {
        let peer = |(id, heard): (&RobotId, &Heard)| {
            let age_s = now.since(heard.sent).as_secs_f64();
            (age_s <= FORGET_S).then_some(LinkPeer { id: *id, pos_w: heard.pos_w, vel_w: heard.vel_w, age_s })
        };
        self.heard[robot].iter().filter_map(peer).collect()
    }

    fn decide(&mut self, robot: usize, scene: &Scene<'_>) -> bool {
        let at_w = scene.at_w[robot];
        let mut peers = self.peers(robot, scene.now);
        let sensed = |other: &usize| *other != robot && (scene.at_w[*other] - at_w).norm() <= SENSE_M;
        for other in (0..self.ids.len()).filter(sensed) {
            let seen = LinkPeer { id: self.ids[other], pos_w: scene.at_w[other], vel_w: Vec2::zeros(), age_s: 0.0 };
            match peers.binary_search_by_key(&seen.id, |peer| peer.id) {
                Ok(place) => peers[place] = seen,
                Err(place) => peers.insert(place, seen),
            }
        }
        let reach_m = SENSE_M.max(self.safe.wall_gap_m + self.safe.step_m_max);
        let walls: Vec<Capsule> = self.walls.iter().filter(|wall| wall.at_least_m(at_w) <= reach_m).copied().collect();
        let mate = &mut self.mates[robot];
        let wish = mate.wish(&Around { at_w, peers: &peers, walls: &walls, dt_s: self.period.as_secs_f64() });
        let set = SafeSet::around(self.safe, at_w, mate.discs(), peers.iter().map(|peer| peer.pos_w), &walls);
        self.ends_w[robot] = mate.steer(&set, wish);
        (self.ends_w[robot] - at_w - wish).norm() > 1e-6
    }

    /// Where each robot goes in the next step of `dt_s`: as decided, as far as the last layer lets it now.
    pub(super) fn advance(&mut self, scene: &Scene<'_>, dt_s: f64) -> Vec<Vec2> {
        let step_m_max = self.safe.step_m_max / self.period.as_secs_f64() * dt_s;
        let mut set = SafeSet::new(SafeSetParams { step_m_max, ..self.safe }, Vec2::zeros());
        let mut places = Vec::with_capacity(scene.at_w.len());
        for (robot, at_w) in scene.at_w.iter().copied().enumerate() {
            let way = self.ends_w[robot] - at_w;
            let wish = way * (step_m_max / way.norm().max(step_m_max));
            if !scene.alive[robot] || way.norm() <= 0.0 {
                self.velocities_w[robot] = Vec2::zeros();
                places.push(at_w);
                continue;
            }
            set.reset(at_w);
            self.mates[robot].discs().for_each(|disc| set.stay_in(disc));
            let others = scene.at_w.iter().enumerate().filter(|(other, _)| *other != robot);
            others.for_each(|(_, other_w)| set.leave_half_to(*other_w));
            self.walls.iter().for_each(|wall| set.keep_from(*wall));
            let to_w = Steering::default().choose(&set, wish, Steer::Clip);
            self.velocities_w[robot] = (to_w - at_w) / dt_s;
            places.push(to_w);
        }
        places
    }
}
