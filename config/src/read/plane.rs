//! Reads the beacon plane and the modelled radio.

use crate::reader::{IPV4, IPV4_GROUP, Table};
use crate::{BeaconPlane, Radio};

/// Reads `[beacon]`.
pub(crate) fn beacon(table: &mut Table<'_>) -> Option<BeaconPlane> {
    // 239.255.0.0/16 is the administratively scoped block of one site (RFC 2365): routers keep it inside.
    let group = table.text("group", &IPV4_GROUP, Some("239.255.77.1"));
    let port = table.integer_u16("port", 1_024..=65_535, 17_700);
    // Loopback: beacons leave this computer only if the file says so.
    let interface = table.text("interface", &IPV4, Some("127.0.0.1"));
    // What fifty robots can share on one Wi-Fi channel.
    let rate_hz = table.number("rate_hz", 1.0..=50.0, Some(10.0));
    Some(BeaconPlane { group: group?, port: port?, interface: interface?, rate_hz: rate_hz? })
}

/// Reads `[radio]`.
pub(crate) fn radio(table: &mut Table<'_>) -> Option<Radio> {
    // Outdoor Wi-Fi reaches about this far between small antennas near the ground.
    let range_m = table.number("range_m", 0.1..=100_000.0, Some(100.0));
    let loss = table.number("loss", 0.0..=1.0, Some(0.0));
    // One broadcast frame on an idle channel.
    let delay_ms = table.number("delay_ms", 0.0..=10_000.0, Some(2.0));
    let jitter_ms = table.number("jitter_ms", 0.0..=10_000.0, Some(3.0));
    Some(Radio { range_m: range_m?, loss: loss?, delay_ms: delay_ms?, jitter_ms: jitter_ms?, ..Radio::default() })
}
