//! A swarm in virtual time: the same robots, firmware and bytes over memory links, as fast as the machine goes.
//!
//! Time moves in steps of the world. In each step the plant moves and speaks, then every robot takes a turn, in the
//! file's order, then beacons travel. Nothing reads the wall clock and nothing runs beside it, so that one seed gives
//! the same bytes twice (invariant 9).

use crate::ether::Ether;
use crate::measures::Measures;
use crate::summary::{RunFacts, Summary, Tally, summarise};
use crate::tasks::beacon_links;
use crate::trial::Trial;
use drover_config::{Links, RobotFile, Swarm};
use drover_contract::{CanBus, Clock, Link, Stamp};
use drover_core::Status;
use drover_core::map::SharedMap;
use drover_io::{ManualClock, MemoryBus, MemoryLink, MemoryNode, MemoryTapes, OpenError, Tape, memory_link};
use drover_record::Recorder;
use drover_robot::{Assembly, Hardware, Recording, RobotLoop, StopReason, View, assemble};
use drover_world::{Arena, Packet, PeerKey, Plant, Port, RadioTally};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// Messages that a link keeps for a side that does not read.
const QUEUE: usize = 4096;
/// Which life a robot begins with; greater after every restart.
const FIRST_EPOCH: u32 = 1;
/// The one peer that every virtual firmware has here.
const PEER: PeerKey = PeerKey(0);

/// The firmware's end of one robot's links.
enum FarEnd {
    Mavlink(MemoryLink),
    Can { drive: MemoryNode, lidar: MemoryNode },
}

/// A swarm in virtual time.
pub struct VirtualSwarm {
    swarm: Swarm,
    clock: ManualClock,
    step: Duration,
    plant: Plant,
    robots: Vec<Option<RobotLoop>>,
    epochs: Vec<u32>,
    far_ends: Vec<FarEnd>,
    ether: Ether,
    tallies: Vec<Tally>,
    memory: Memory,
}

/// What is kept of the robots' links.
enum Memory {
    Nothing,
    /// Their bytes, in memory.
    Bytes {
        tapes: Arc<MemoryTapes>,
        robots: Vec<Tape>,
    },
    /// Everything, in a file.
    File(Recorder),
}

impl Memory {
    /// The recording of a robot that begins now.
    fn of_robot(&mut self, file: &RobotFile, epoch: u32, now: Stamp) -> Option<Recording> {
        match self {
            Self::Nothing => None,
            Self::Bytes { tapes, robots } => {
                let tape = Tape::new(file.robot.id, tapes.clone());
                robots.push(tape.clone());
                Some(Recording::of_bytes(tape))
            }
            Self::File(recorder) => Some(recorder.robot(file, epoch, now)),
        }
    }
}

impl VirtualSwarm {
    /// A swarm at rest at time zero, all of whose links are recorded in memory.
    ///
    /// # Errors
    /// [`OpenError`] if a robot's links do not fit its kind.
    pub fn new(swarm: &Swarm) -> Result<Self, OpenError> {
        Self::with(swarm, Memory::Bytes { tapes: Arc::default(), robots: Vec::new() })
    }

    /// The same without recording: for runs of which only the result is wanted.
    ///
    /// # Errors
    /// [`OpenError`] if a robot's links do not fit its kind.
    pub fn unrecorded(swarm: &Swarm) -> Result<Self, OpenError> {
        Self::with(swarm, Memory::Nothing)
    }

    /// The same with everything in a file.
    ///
    /// # Errors
    /// [`OpenError`] if a robot's links do not fit its kind.
    pub fn recorded(swarm: &Swarm, recorder: &Recorder) -> Result<Self, OpenError> {
        Self::with(swarm, Memory::File(recorder.clone()))
    }

    fn with(swarm: &Swarm, mut memory: Memory) -> Result<Self, OpenError> {
        let clock = ManualClock::new(Stamp::ZERO);
        let (near_beacons, far_beacons) = beacon_links(swarm.robots.len());
        let mut robots = Vec::new();
        let mut far_ends = Vec::new();
        for (index, beacons) in near_beacons.into_iter().enumerate() {
            let (robot, far_end) = start(swarm, (index, FIRST_EPOCH), beacons, &mut memory, Stamp::ZERO)?;
            robots.push(Some(robot));
            far_ends.push(far_end);
        }
        Ok(Self {
            step: Duration::from_millis(u64::from(swarm.step_ms)),
            plant: Plant::new(swarm, Stamp::ZERO),
            ether: Ether::new(swarm, far_beacons),
            epochs: vec![FIRST_EPOCH; robots.len()],
            tallies: vec![Tally::default(); robots.len()],
            swarm: swarm.clone(),
            clock,
            robots,
            far_ends,
            memory,
        })
    }

    /// The present moment.
    #[must_use]
    pub fn now(&self) -> Stamp {
        self.clock.now()
    }

    /// The world and its firmware: to look at, and to break.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The world and its firmware.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Robot `index`'s loop, unless it was killed.
    #[must_use]
    pub fn robot(&self, index: usize) -> Option<&RobotLoop> {
        self.robots.get(index)?.as_ref()
    }

    /// Robot `index`'s process dies: its loop is gone between two instructions, and sends nothing any more.
    pub fn kill(&mut self, index: usize) {
        if let Some(slot) = self.robots.get_mut(index) {
            *slot = None;
        }
    }

    /// Robot `index`'s process starts anew, with links of its own; its firmware and its body are as they are.
    ///
    /// # Errors
    /// [`OpenError`] as for [`VirtualSwarm::new`].
    pub fn restart(&mut self, index: usize) -> Result<(), OpenError> {
        let (near, far) = memory_link(QUEUE);
        self.ether.replace(index, far);
        self.epochs[index] += 1;
        let now = self.now();
        let (robot, far_end) = start(&self.swarm, (index, self.epochs[index]), near, &mut self.memory, now)?;
        self.robots[index] = Some(robot);
        self.far_ends[index] = far_end;
        Ok(())
    }

    /// One step of the world.
    pub fn step(&mut self) {
        let now = self.now() + self.step;
        self.clock.set(now);
        self.plant.step(now);
        self.deliver_from_plant();
        for robot in self.robots.iter_mut().flatten() {
            robot.turn(&self.clock);
        }
        self.deliver_to_plant(now);
        self.ether.turn(now, self.plant.arena().place());
        self.tally(now);
    }

    /// Step until `moment`.
    pub fn run_until(&mut self, moment: Stamp) {
        while self.now() < moment {
            self.step();
        }
    }

    /// Run until every robot says it has reached the end, or until the swarm's duration is over; then stop every robot
    /// and see it stand.
    pub fn run(&mut self) -> Summary {
        let limit = Stamp::ZERO + Duration::from_secs_f64(self.swarm.duration_s);
        while self.now() < limit && !self.all_reached() {
            self.step();
        }
        let ended = if self.all_reached() { "every robot reached the end" } else { "the time was over" };
        let time_s = self.now().as_secs_f64();
        self.end();
        let facts = RunFacts {
            ended: ended.into(),
            time_s,
            world_rate: 1.0,
            can: "memory",
            can_detail: "buses in memory, virtual time".into(),
            processes: false,
            recording: None,
            recording_dropped: match &self.memory {
                Memory::Bytes { tapes, .. } => tapes.dropped(),
                Memory::Nothing | Memory::File(_) => 0,
            },
            recording_failed: None,
        };
        summarise(&self.swarm, &self.plant, (&self.tallies, &Measures::default()), facts)
    }

    /// Everything recorded so far: file name to bytes.
    #[must_use]
    pub fn recordings(&self) -> BTreeMap<String, Vec<u8>> {
        let Memory::Bytes { tapes, robots } = &self.memory else { return BTreeMap::new() };
        robots.iter().for_each(Tape::flush);
        tapes.files()
    }

    fn all_reached(&self) -> bool {
        let mut running = self.robots.iter().flatten().peekable();
        running.peek().is_some() && running.all(|robot| robot.status().reached)
    }

    fn end(&mut self) {
        const PATIENCE_S: f64 = 10.0;
        self.look();
        self.tallies.iter_mut().for_each(Tally::note_end);
        let now = self.now();
        for robot in self.robots.iter_mut().flatten() {
            robot.begin_end(now, StopReason::Shutdown);
        }
        let limit = now + Duration::from_secs_f64(PATIENCE_S);
        while self.now() < limit && self.robots.iter().flatten().any(|robot| !robot.ended()) {
            self.step();
        }
        self.look();
    }

    fn deliver_from_plant(&mut self) {
        while let Some(output) = self.plant.poll_output() {
            // A full queue drops, as a real one does; the virtual firmware never waits.
            let _ = match (&mut self.far_ends[output.robot], output.port, &output.packet) {
                (FarEnd::Mavlink(link), Port::Autopilot, Packet::Datagram(bytes)) => link.send(bytes),
                (FarEnd::Can { drive, .. }, Port::DriveBus, Packet::Frame(frame)) => drive.send(frame),
                (FarEnd::Can { lidar, .. }, Port::LidarBus, Packet::Frame(frame)) => lidar.send(frame),
                (FarEnd::Mavlink(_) | FarEnd::Can { .. }, _, _) => Ok(()),
            };
        }
    }

    fn deliver_to_plant(&mut self, now: Stamp) {
        let mut buf = [0; 2048];
        for (robot, far_end) in self.far_ends.iter_mut().enumerate() {
            match far_end {
                FarEnd::Mavlink(link) => {
                    while let Ok(Some(len)) = link.try_recv(&mut buf) {
                        let packet = Packet::Datagram(buf[..len].to_vec());
                        self.plant.handle_input(now, robot, Port::Autopilot, PEER, &packet);
                    }
                }
                FarEnd::Can { drive, lidar } => {
                    for (port, bus) in [(Port::DriveBus, drive), (Port::LidarBus, lidar)] {
                        while let Ok(Some(frame)) = bus.try_recv() {
                            self.plant.handle_input(now, robot, port, PEER, &Packet::Frame(frame));
                        }
                    }
                }
            }
        }
    }

    /// Who has come to the end, and when; what else there is to see of a robot is looked at in the end.
    fn tally(&mut self, now: Stamp) {
        for (robot, tally) in self.robots.iter().zip(&mut self.tallies) {
            if robot.as_ref().is_some_and(|robot| robot.status().reached) {
                tally.reached_s.get_or_insert(now.as_secs_f64());
            }
        }
    }

    fn look(&mut self) {
        let now = self.now();
        for (robot, tally) in self.robots.iter().zip(&mut self.tallies) {
            if let Some(robot) = robot {
                tally.see(View::of(robot, now), now.as_secs_f64());
            }
        }
    }
}

impl Trial for VirtualSwarm {
    fn now(&self) -> Stamp {
        self.now()
    }

    fn step(&mut self) {
        self.step();
    }

    fn arena(&self) -> &Arena {
        self.plant.arena()
    }

    fn status(&self, robot: usize) -> Option<&Status> {
        self.robot(robot).map(RobotLoop::status)
    }

    fn view(&self, robot: usize) -> Option<View> {
        self.robot(robot).map(|robot| View::of(robot, self.now()))
    }

    fn map(&self, robot: usize) -> Option<&SharedMap> {
        self.robot(robot).and_then(RobotLoop::map)
    }

    fn radio(&self) -> RadioTally {
        self.ether.tally()
    }

    fn messages_bytes(&self) -> u64 {
        self.ether.sent_bytes()
    }

    fn aged_commands(&self) -> u64 {
        self.robots.iter().flatten().map(RobotLoop::aged_commands).sum()
    }

    fn bytes(&self) -> usize {
        // Codecs, firmware and queues are not counted one by one: a wire's robot is not what fills a memory.
        self.robots.len() * size_of::<RobotLoop>() + self.plant.arena().bytes().0 + self.ether.bytes()
    }
}

fn start(
    swarm: &Swarm,
    (index, epoch): (usize, u32),
    beacons: MemoryLink,
    memory: &mut Memory,
    now: Stamp,
) -> Result<(RobotLoop, FarEnd), OpenError> {
    let config = &swarm.robots[index];
    let (hardware, far_end) = memory_hardware(&config.links);
    let unknown = || OpenError::new(format!("robot {}", config.id), "not in the swarm", "name one that is");
    let file = swarm.robot_file(config.id).ok_or_else(unknown)?;
    let recording = memory.of_robot(&file, epoch, now);
    let assembly = Assembly { file, hardware, beacons: Box::new(beacons), epoch, recording };
    Ok((assemble(assembly, now)?.robot, far_end))
}

fn memory_hardware(links: &Links) -> (Hardware, FarEnd) {
    match links {
        Links::Mavlink { .. } => {
            let (near, far) = memory_link(QUEUE);
            (Hardware::Mavlink { link: Box::new(near), stop: Box::new(|_: &[u8]| {}) }, FarEnd::Mavlink(far))
        }
        Links::Can { .. } => {
            let (drive, lidar) = (MemoryBus::new(QUEUE), MemoryBus::new(QUEUE));
            let near = Hardware::Can {
                drive: Box::new(drive.node()),
                lidar: Box::new(lidar.node()),
                stop: Box::new(drive.node()),
            };
            (near, FarEnd::Can { drive: drive.node(), lidar: lidar.node() })
        }
    }
}
