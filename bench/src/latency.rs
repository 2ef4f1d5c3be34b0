//! `drover bench latency`: scan bytes in to command bytes out, over loopback UDP, with the whole stack between.
//!
//! The far end is the world with its virtual autopilots, in this process. The moment an OBSTACLE_DISTANCE datagram is
//! handed to the socket starts the watch; the next SET_POSITION_TARGET_LOCAL_NED that arrives from that robot stops it.
//! Robots act on a fresh scan at once, so between the two lie: kernel, wake-up, decoding, estimate, law, supervisor,
//! encoding, kernel. A periodic command that happens to fall into the span would be counted as its answer; ticks are
//! 50 ms apart and answers take far less than 1 ms, so this shortens less than 2 % of the spans.

use crate::machine::Conditions;
use anyhow::Context;
use drover_config::Swarm;
use drover_contract::Clock;
use drover_io::{OsClock, UdpServer, memory_link};
use drover_robot::{Assembly, Guard, Hardware, Shutdown, StopReason, Teller, assemble, drive};
use drover_world::{Packet, PeerKey, Plant, Port};
use serde::Serialize;
use std::fmt;
use std::future::poll_fn;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, watch};

/// MAVLink message ids in a version 2 frame.
const OBSTACLE_DISTANCE: [u8; 3] = [0x4A, 0x01, 0x00];
const SET_POSITION_TARGET_LOCAL_NED: [u8; 3] = [84, 0, 0];

/// One size of swarm.
#[derive(Clone, Debug, Serialize)]
pub struct LatencyRow {
    /// Robots in the process.
    pub robots: usize,
    /// Scans that were answered.
    pub samples: usize,
    /// Half of the answers came sooner, µs.
    pub p50_us: f64,
    /// 99 of 100 came sooner, µs.
    pub p99_us: f64,
    /// 999 of 1,000 came sooner, µs.
    pub p999_us: f64,
    /// The slowest, µs.
    pub max_us: f64,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct LatencyResult {
    /// Under which conditions.
    pub conditions: Conditions,
    /// A row a size.
    pub rows: Vec<LatencyRow>,
}

/// Measure `swarm` (MAVLink robots) for `measure_s` seconds, `settle_s` seconds after its start.
///
/// # Errors
/// If a link cannot be opened, or no scan was ever answered.
pub async fn latency(swarm: &Swarm, settle_s: f64, measure_s: f64) -> anyhow::Result<LatencyRow> {
    let clock = OsClock::new();
    let guard = Guard::start()?;
    let (end, end_seen) = watch::channel(None);
    let (arrivals_in, arrivals) = mpsc::channel(4096);
    let mut far = FarEnd { plant: Plant::new(swarm, clock.now()), ports: Vec::new(), arrivals, spans_us: Vec::new() };
    for (index, robot) in swarm.robots.iter().enumerate() {
        let server = UdpServer::open("127.0.0.1:0")?;
        let near = format!("udpout:{}", server.local_addr()?);
        let file = swarm.robot_file(robot.id).context("a robot of the swarm")?;
        let hardware = Hardware::open(&drover_config::Links::Mavlink { autopilot: near })?;
        // Nobody carries beacons here: what is measured is one robot's own path.
        let (beacons, _) = memory_link(8);
        let assembly = Assembly { file, hardware, beacons: Box::new(beacons), epoch: 1, recording: None };
        let opened = assemble(assembly, clock.now())?;
        let heart = guard.add(robot.id, opened.hang_limit, opened.stop);
        let teller = Teller { period: Duration::from_secs(1), tell: |_| {} };
        tokio::spawn(drive(opened.robot, clock, heart, end_seen.clone(), teller));
        let (out, outputs) = mpsc::channel(64);
        let port =
            PortTask { robot: index, server, outputs, arrivals: arrivals_in.clone(), peer: None, scan_sent: None };
        tokio::spawn(port.run());
        far.ports.push(out);
    }
    let step = Duration::from_millis(u64::from(swarm.step_ms));
    far.run(&clock, step, Duration::from_secs_f64(settle_s)).await;
    far.spans_us.clear();
    far.run(&clock, step, Duration::from_secs_f64(measure_s)).await;
    let spans_us = std::mem::take(&mut far.spans_us);
    // Nobody listening means that the robots have ended by themselves.
    let _ = end.send(Some(Shutdown(StopReason::Shutdown)));
    far.run(&clock, step, Duration::from_secs(4)).await;
    row(swarm.robots.len(), spans_us)
}

/// What came from a robot, and how long after the scan it answers.
struct Arrival {
    robot: usize,
    bytes: Vec<u8>,
    span: Option<Duration>,
}

/// One virtual autopilot's socket, in a task of its own so that every datagram's moment is its own.
struct PortTask {
    robot: usize,
    server: UdpServer,
    outputs: mpsc::Receiver<Vec<u8>>,
    arrivals: mpsc::Sender<Arrival>,
    peer: Option<SocketAddr>,
    scan_sent: Option<Instant>,
}

impl PortTask {
    async fn run(mut self) {
        loop {
            let output = tokio::select! {
                output = self.outputs.recv() => output,
                () = poll_fn(|cx| self.server.poll_readable(cx)) => {
                    if self.receive().is_err() {
                        return;
                    }
                    continue;
                }
            };
            let Some(bytes) = output else { return };
            let Some(peer) = self.peer else { continue };
            if holds(&bytes, OBSTACLE_DISTANCE) {
                self.scan_sent = Some(Instant::now());
            }
            // A datagram that is lost leaves its span open; the next scan starts it anew.
            let _ = self.server.send_to(&bytes, peer);
        }
    }

    /// An error: nobody wants to hear of it any more.
    fn receive(&mut self) -> Result<(), ()> {
        let mut buf = [0; 2048];
        while let Ok(Some((len, from))) = self.server.try_recv_from(&mut buf) {
            self.peer = Some(from);
            let bytes = buf[..len].to_vec();
            let answers = holds(&bytes, SET_POSITION_TARGET_LOCAL_NED);
            let span = if answers { self.scan_sent.take().map(|sent| sent.elapsed()) } else { None };
            let arrival = Arrival { robot: self.robot, bytes, span };
            if let Err(mpsc::error::TrySendError::Closed(_)) = self.arrivals.try_send(arrival) {
                return Err(());
            }
        }
        Ok(())
    }
}

struct FarEnd {
    plant: Plant,
    ports: Vec<mpsc::Sender<Vec<u8>>>,
    arrivals: mpsc::Receiver<Arrival>,
    spans_us: Vec<f64>,
}

impl FarEnd {
    async fn run(&mut self, clock: &OsClock, step: Duration, span: Duration) {
        let until = Instant::now() + span;
        let mut ticker = tokio::time::interval(step);
        while Instant::now() < until {
            tokio::select! {
                _ = ticker.tick() => self.step(clock),
                arrival = self.arrivals.recv() => if let Some(arrival) = arrival { self.take(clock, arrival) },
            }
        }
    }

    fn take(&mut self, clock: &OsClock, arrival: Arrival) {
        self.spans_us.extend(arrival.span.map(|span| span.as_secs_f64() * 1e6));
        let packet = Packet::Datagram(arrival.bytes);
        self.plant.handle_input(clock.now(), arrival.robot, Port::Autopilot, PeerKey(0), &packet);
    }

    fn step(&mut self, clock: &OsClock) {
        self.plant.step(clock.now());
        while let Some(output) = self.plant.poll_output() {
            if let Packet::Datagram(bytes) = output.packet {
                // A queue that is full loses telemetry, as a link does.
                let _ = self.ports[output.robot].try_send(bytes);
            }
        }
    }
}

/// Whether one of the datagram's MAVLink 2 frames has this message id.
fn holds(mut bytes: &[u8], id: [u8; 3]) -> bool {
    const FRAME_BYTES_MIN: usize = 12;
    while bytes.len() >= FRAME_BYTES_MIN && bytes[0] == 0xFD {
        if bytes[7..10] == id {
            return true;
        }
        let frame = FRAME_BYTES_MIN + usize::from(bytes[1]);
        bytes = bytes.get(frame..).unwrap_or_default();
    }
    false
}

fn row(robots: usize, mut spans_us: Vec<f64>) -> anyhow::Result<LatencyRow> {
    anyhow::ensure!(!spans_us.is_empty(), "no scan was answered by a command: the robots never drove");
    spans_us.sort_by(f64::total_cmp);
    let at = |share: f64| spans_us[((spans_us.len() - 1) as f64 * share).round() as usize];
    Ok(LatencyRow {
        robots,
        samples: spans_us.len(),
        p50_us: at(0.5),
        p99_us: at(0.99),
        p999_us: at(0.999),
        max_us: at(1.0),
    })
}

impl fmt::Display for LatencyResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "latency: scan bytes in to command bytes out, loopback UDP, simulator in the same process")?;
        writeln!(f, "{}", self.conditions)?;
        write!(f, " robots  samples      p50      p99    p99.9      max  (µs)")?;
        self.rows.iter().try_for_each(|row| {
            write!(
                f,
                "\n{:>7}  {:>7}  {:>7.0}  {:>7.0}  {:>7.0}  {:>7.0}",
                row.robots, row.samples, row.p50_us, row.p99_us, row.p999_us, row.max_us
            )
        })
    }
}
