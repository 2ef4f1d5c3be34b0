//! The plant behind real links, in step with the wall clock.

use crate::far_side::{BridgeError, CanBacking, FarSide, Interfaces, NearSide};
use drover_config::Swarm;
use drover_contract::{CanBus, Clock, Stamp, Vec2};
use drover_world::{Packet, Plant, Port};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::time::MissedTickBehavior;

/// At most so many messages are read from one link in one step: a flood must not hold up the world.
const READS_PER_STEP: usize = 1024;
/// Longest datagram that is read.
const DATAGRAM_BYTES: usize = 2048;

/// The plant, shared with whoever wants to look at it or to break it.
#[derive(Clone)]
pub struct PlantHandle(Arc<Mutex<Plant>>);

impl PlantHandle {
    /// Look at the plant, or do something to it. Keep it short: the world stands still meanwhile.
    pub fn with<T>(&self, look: impl FnOnce(&mut Plant) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// True positions of all bodies, world frame, in the file's order.
    #[must_use]
    pub fn positions(&self) -> Vec<Vec2> {
        self.with(|plant| (0..plant.robot_count()).map(|robot| plant.truth(robot).pose_wb.position()).collect())
    }
}

/// The plant and the firmware's ends of all links.
pub struct Bridge {
    plant: PlantHandle,
    far_sides: Vec<FarSide>,
    step: Duration,
    _interfaces: Interfaces,
}

impl Bridge {
    /// Open the firmware's end of every link; and what each robot is to connect to, in the file's order.
    ///
    /// # Errors
    /// [`BridgeError`] for a port in use or an interface that cannot be made. Nothing runs then.
    pub fn open(swarm: &Swarm, backing: CanBacking, now: Stamp) -> Result<(Self, Vec<NearSide>), BridgeError> {
        let mut interfaces = Interfaces::default();
        let mut far_sides = Vec::new();
        let mut near_sides = Vec::new();
        for (index, robot) in swarm.robots.iter().enumerate() {
            let (far, near) =
                interfaces.open(swarm, index, backing).map_err(|source| BridgeError { robot: robot.id, source })?;
            far_sides.push(far);
            near_sides.push(near);
        }
        let bridge = Self {
            plant: PlantHandle(Arc::new(Mutex::new(Plant::new(swarm, now)))),
            far_sides,
            step: Duration::from_millis(u64::from(swarm.step_ms)),
            _interfaces: interfaces,
        };
        Ok((bridge, near_sides))
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> PlantHandle {
        self.plant.clone()
    }

    fn turn(&mut self, now: Stamp) {
        let mut plant = self.plant.0.lock().unwrap_or_else(PoisonError::into_inner);
        for (robot, far) in self.far_sides.iter_mut().enumerate() {
            receive(&mut plant, now, robot, far);
        }
        plant.step(now);
        while let Some(output) = plant.poll_output() {
            // What cannot be sent now is lost, as it would be on a robot; the firmware repeats its telemetry anyway.
            let _ = match (&mut self.far_sides[output.robot], output.port, &output.packet) {
                (FarSide::Mavlink { server, peers }, Port::Autopilot, Packet::Datagram(bytes)) => {
                    peers.address_of(output.to).map_or(Ok(()), |address| server.send_to(bytes, address))
                }
                (FarSide::Can { drive, .. }, Port::DriveBus, Packet::Frame(frame)) => drive.send(frame),
                (FarSide::Can { lidar, .. }, Port::LidarBus, Packet::Frame(frame)) => lidar.send(frame),
                (FarSide::Mavlink { .. } | FarSide::Can { .. }, _, _) => Ok(()),
            };
        }
    }
}

/// Run the bridge until its task is aborted: one turn a world step. A late step is caught up by the plant, which counts
/// its own time.
pub async fn pace<C: Clock>(mut bridge: Bridge, clock: C) {
    let mut ticker = tokio::time::interval(bridge.step);
    ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        ticker.tick().await;
        bridge.turn(clock.now());
    }
}

fn receive(plant: &mut Plant, now: Stamp, robot: usize, far: &mut FarSide) {
    match far {
        FarSide::Mavlink { server, peers } => {
            let mut buf = [0; DATAGRAM_BYTES];
            for _ in 0..READS_PER_STEP {
                match server.try_recv_from(&mut buf) {
                    Ok(Some((len, address))) => {
                        let from = peers.key_of(address);
                        plant.handle_input(now, robot, Port::Autopilot, from, &Packet::Datagram(buf[..len].to_vec()));
                    }
                    Ok(None) => break,
                    // A ground station that went away shows up as a refused datagram: the others are still there.
                    Err(_) => {}
                }
            }
        }
        FarSide::Can { drive, lidar } => {
            receive_frames(plant, now, (robot, Port::DriveBus), drive.as_mut());
            receive_frames(plant, now, (robot, Port::LidarBus), lidar.as_mut());
        }
    }
}

fn receive_frames(plant: &mut Plant, now: Stamp, (robot, port): (usize, Port), bus: &mut dyn CanBus) {
    for _ in 0..READS_PER_STEP {
        match bus.try_recv() {
            Ok(Some(frame)) => {
                plant.handle_input(now, robot, port, drover_world::PeerKey(0), &Packet::Frame(frame));
            }
            Ok(None) | Err(_) => break,
        }
    }
}
