//! Links: no two robots on one address, no two uses of one port or interface.

use super::Checker;
use crate::path::join;
use crate::read::robot::{RobotParts, mavlink_address, tunnel_ports};
use crate::report::Words;
use crate::{BeaconPlane, Links};
use std::collections::{BTreeMap, BTreeSet};

impl Checker<'_> {
    /// Each address, local port and interface of `robots` once, and none of them the beacons' port.
    pub(crate) fn links(&mut self, robots: &[RobotParts], beacon: Option<&BeaconPlane>) {
        let mut used: BTreeMap<String, String> = BTreeMap::new();
        if let Some(beacon) = beacon {
            used.insert(format!("UDP port {}", beacon.port), "beacon.port".to_owned());
        }
        let mut ids = BTreeSet::new();
        for robot in robots {
            let again = robot.id.is_some_and(|id| !ids.insert(id));
            for (key, link) in entries(robot) {
                let path = join(&robot.path, &format!("links.{key}"));
                if again && !self.root.has(&path) {
                    continue; // it follows from an id that is already said to be taken
                }
                for use_ in uses(link) {
                    self.use_once(&mut used, &path, link, use_);
                }
            }
        }
    }

    fn use_once(&mut self, used: &mut BTreeMap<String, String>, path: &str, link: &str, use_: String) {
        match used.get(&use_) {
            Some(other) if other != path => {
                let found = format!("{link:?}, whose {use_} {other} has already");
                let words = Words::new(found, "an address, port or interface of its own", "give it another");
                self.report.push_path(self.root, path, words);
            }
            Some(_) => {}
            None => {
                used.insert(use_, path.to_owned());
            }
        }
    }
}

fn entries(robot: &RobotParts) -> Vec<(&'static str, &str)> {
    match &robot.links {
        Some(Links::Mavlink { autopilot }) => vec![("autopilot", autopilot)],
        Some(Links::Can { drive, lidar }) => vec![("drive", drive), ("lidar", lidar)],
        None => Vec::new(),
    }
}

/// What a link takes for itself. On this computer a port counts whatever its address: the simulator listens there.
fn uses(link: &str) -> Vec<String> {
    if let Some((inbound, host, port)) = mavlink_address(link) {
        let here = inbound || host == "localhost" || host.starts_with("127.");
        return vec![if here { format!("UDP port {port}") } else { format!("UDP address {host}:{port}") }];
    }
    match tunnel_ports(link) {
        Some((local, remote)) => vec![format!("UDP port {local}"), format!("UDP port {remote}")],
        None => vec![format!("CAN interface {link}")],
    }
}
