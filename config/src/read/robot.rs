//! Reads one robot, and the file of one robot in the field.

use super::kind::KindParts;
use super::{behaviour, kind, plane};
use crate::path::join;
use crate::reader::{COORDINATE_M_MAX, FOLDER, NAME, Table, TextRule};
use crate::{BeaconPlane, Behaviour, Drive, Links, Peer, Robot, Start};

/// First port of virtual autopilots: above the ports of ground stations (14550 and its neighbours).
pub(crate) const MAVLINK_PORT_BASE: u16 = 14_600;
/// Most robots of one swarm, fleets and all.
pub(crate) const ROBOTS_MAX: usize = 100_000;

/// What could be read of a robot; `path` is its key, or its fleet's.
#[derive(Clone, Debug)]
pub(crate) struct RobotParts {
    pub(crate) path: String,
    pub(crate) id: Option<u32>,
    pub(crate) kind: Option<String>,
    pub(crate) start: Option<Start>,
    pub(crate) links: Option<Links>,
    pub(crate) of_fleet: bool,
}

impl RobotParts {
    /// The key that says its id.
    pub(crate) fn id_path(&self) -> String {
        join(&self.path, if self.of_fleet { "first_id" } else { "id" })
    }

    /// The robot, if all of it could be read.
    pub(crate) fn robot(&self) -> Option<Robot> {
        let (id, kind) = (self.id?, self.kind.clone()?);
        Some(Robot { id, kind, start: self.start?, links: self.links.clone()? })
    }
}

/// Reads a robot whose kind's drive `drive_of` knows by name. `port_base` makes the addresses that it does not give.
pub(crate) fn robot(
    table: &mut Table<'_>,
    port_base: Option<u16>,
    drive_of: impl FnOnce(&str) -> Option<Drive>,
) -> Option<RobotParts> {
    let id = table.integer_u32("id", 1..=u32::MAX, None);
    let kind = table.text("kind", &NAME, None);
    let start = table.table("start", start);
    let drive = kind.as_deref().and_then(drive_of);
    let links = table.section("links", |table| links(table, drive, id, port_base));
    Some(RobotParts { path: table.path().to_owned(), id, kind, start, links, of_fleet: false })
}

fn start(table: &mut Table<'_>) -> Option<Start> {
    let x_m = table.number("x_m", -COORDINATE_M_MAX..=COORDINATE_M_MAX, None);
    let y_m = table.number("y_m", -COORDINATE_M_MAX..=COORDINATE_M_MAX, None);
    let yaw_rad = table.number("yaw_rad", -std::f64::consts::TAU..=std::f64::consts::TAU, Some(0.0));
    Some(Start { x_m: x_m?, y_m: y_m?, yaw_rad: yaw_rad? })
}

/// Links as given, or as the id says. Of a kind that is not known nothing can be said: any key may stand.
fn links(table: &mut Table<'_>, drive: Option<Drive>, id: Option<u32>, port_base: Option<u16>) -> Option<Links> {
    match drive {
        Some(Drive::Mavlink { .. }) => {
            let derived = id.zip(port_base).and_then(|(id, base)| derived_autopilot(id, base));
            let autopilot = table.derived_text("autopilot", &MAVLINK_ADDRESS, derived)?;
            Some(Links::Mavlink { autopilot })
        }
        Some(Drive::AgilexV2 { .. }) => {
            let [drive, lidar] = id.map(derived_buses).map_or([None, None], |buses| buses.map(Some));
            let drive = table.derived_text("drive", &CAN_BUS, drive);
            let lidar = table.derived_text("lidar", &CAN_BUS, lidar);
            Some(Links::Can { drive: drive?, lidar: lidar? })
        }
        None => {
            let _ = table.optional_text("autopilot", &MAVLINK_ADDRESS);
            let _ = table.optional_text("drive", &CAN_BUS);
            let _ = table.optional_text("lidar", &CAN_BUS);
            None
        }
    }
}

/// The links of robot `id`, as far as its id says them.
pub(crate) fn derived_links(drive: Drive, id: u32, port_base: u16) -> Option<Links> {
    match drive {
        Drive::Mavlink { .. } => derived_autopilot(id, port_base).map(|autopilot| Links::Mavlink { autopilot }),
        Drive::AgilexV2 { .. } => {
            let [drive, lidar] = derived_buses(id);
            Some(Links::Can { drive, lidar })
        }
    }
}

fn derived_autopilot(id: u32, port_base: u16) -> Option<String> {
    let port = u16::try_from(u32::from(port_base).checked_add(id)?).ok()?;
    Some(format!("udpout:127.0.0.1:{port}"))
}

/// At most 15 characters, whatever the id: what Linux allows.
fn derived_buses(id: u32) -> [String; 2] {
    [format!("vcan{id}d"), format!("vcan{id}l")]
}

const MAVLINK_ADDRESS: TextRule = TextRule {
    allowed: "udpout:HOST:PORT or udpin:HOST:PORT with a port in 1..=65535",
    advice: "write it like \"udpout:127.0.0.1:14601\" (we speak first) or \"udpin:0.0.0.0:14550\" (it does)",
    accepts: |text| mavlink_address(text).is_some(),
};

const CAN_BUS: TextRule = TextRule {
    allowed: "a CAN interface (1 to 15 characters) or udp:LOCAL_PORT:REMOTE_PORT",
    advice: "write it like \"can0\" or \"udp:15001:15002\"",
    accepts: |text| can_interface(text) || tunnel_ports(text).is_some(),
};

/// Direction (whether the autopilot speaks first), host and port of a MAVLink address.
pub(crate) fn mavlink_address(text: &str) -> Option<(bool, &str, u16)> {
    let (direction, rest) = text.split_once(':')?;
    let (host, port) = rest.rsplit_once(':')?;
    let inbound = match direction {
        "udpin" => true,
        "udpout" => false,
        _ => return None,
    };
    let letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'.' || byte == b'-';
    let named = !host.is_empty() && host.len() <= 253 && host.bytes().all(letter);
    // An address to listen on is a number: names are for those whom we call.
    let host_fits = if inbound { host.parse::<core::net::Ipv4Addr>().is_ok() } else { named };
    let port = port.parse().ok().filter(|port| *port > 0)?;
    host_fits.then_some((inbound, host, port))
}

/// Local and remote port of a tunnelled CAN bus.
pub(crate) fn tunnel_ports(text: &str) -> Option<(u16, u16)> {
    let (local, remote) = text.strip_prefix("udp:")?.split_once(':')?;
    let (local, remote): (u16, u16) = (local.parse().ok()?, remote.parse().ok()?);
    (local > 0 && remote > 0 && local != remote).then_some((local, remote))
}

/// Linux: IFNAMSIZ is 16 with its NUL; no slash, no colon, no blank.
fn can_interface(text: &str) -> bool {
    let letter = |byte: u8| byte.is_ascii_graphic() && byte != b'/' && byte != b':';
    !text.is_empty() && text.len() <= 15 && text != "." && text != ".." && text.bytes().all(letter)
}

/// What could be read of a robot's own file.
#[derive(Debug)]
pub(crate) struct RobotFileParts {
    pub(crate) swarm: Option<String>,
    pub(crate) robot: Option<RobotParts>,
    pub(crate) kind: Option<KindParts>,
    pub(crate) behaviour: Option<Behaviour>,
    pub(crate) beacon: Option<BeaconPlane>,
    pub(crate) peers: Vec<(usize, Peer)>,
    pub(crate) record_dir: Option<String>,
}

/// Reads a robot's own file.
pub(crate) fn robot_file(table: &mut Table<'_>) -> Option<RobotFileParts> {
    let swarm = table.text("swarm", &NAME, None);
    let kind = table.table("kind", |table| kind::kind(table, None));
    let drive = kind.as_ref().and_then(|kind| kind.drive);
    let robot = table.table("robot", |table| robot(table, Some(MAVLINK_PORT_BASE), |_| drive));
    let behaviour = table.table("behaviour", behaviour::behaviour);
    let beacon = table.section("beacon", plane::beacon);
    let peers = table.tables("peers", ROBOTS_MAX, |table| {
        let id = table.integer_u32("id", 1..=u32::MAX, None);
        let radius_m = table.number("radius_m", 0.005..=5.0, None);
        Some(Peer { id: id?, radius_m: radius_m? })
    });
    let record_dir = table.optional_text("record_dir", &FOLDER);
    Some(RobotFileParts { swarm, robot, kind, behaviour, beacon, peers: peers.unwrap_or_default(), record_dir })
}
