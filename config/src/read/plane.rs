//! Reads the beacon plane and the modelled radio.

use super::robot::ROBOTS_MAX;
use crate::reader::{IPV4, IPV4_GROUP, Table};
use crate::report::Words;
use crate::{Airtime, BeaconPlane, Burst, Partition, Propagation, Radio};

/// Most times at which the radio is parted.
const PARTITIONS_MAX: usize = 1_000;
/// Longest run, s.
const RUN_S_MAX: f64 = 86_400.0;

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
    let duplicate = table.number("duplicate", 0.0..=1.0, Some(0.0));
    let asymmetry = table.number("asymmetry", 0.0..=1.0, Some(0.0));
    let burst = table.optional_table("burst", burst);
    let propagation = table.optional_table("propagation", propagation);
    let airtime = table.optional_table("airtime", airtime);
    let partitions = table.tables("partitions", PARTITIONS_MAX, partition)?;
    // One that could not be read would shift the others' places.
    let whole = partitions.iter().enumerate().all(|(at, (index, _))| at == *index);
    Some(Radio {
        range_m: range_m?,
        loss: loss?,
        delay_ms: delay_ms?,
        jitter_ms: jitter_ms?,
        duplicate: duplicate?,
        asymmetry: asymmetry?,
        burst: burst?,
        propagation: propagation?,
        airtime: airtime?,
        partitions: whole.then(|| partitions.into_iter().map(|(_, partition)| partition).collect())?,
    })
}

fn burst(table: &mut Table<'_>) -> Option<Burst> {
    let enter_per_s = table.number("enter_per_s", 0.0..=1_000.0, None);
    let leave_per_s = table.number("leave_per_s", 0.001..=1_000.0, None);
    // Gilbert's own model: in the bad state nothing arrives.
    let loss = table.number("loss", 0.0..=1.0, Some(1.0));
    Some(Burst { enter_per_s: enter_per_s?, leave_per_s: leave_per_s?, loss: loss? })
}

fn propagation(table: &mut Table<'_>) -> Option<Propagation> {
    // Halls and offices in line of sight are near free space.
    let exponent = table.number("exponent", 1.0..=6.0, Some(2.0));
    let half_range_m = table.number("half_range_m", 0.1..=100_000.0, None);
    // A light inner wall at 2.4 GHz takes 3 to 7 dB.
    let wall_db = table.number("wall_db", 0.0..=60.0, Some(5.0));
    let shadow_db = table.number("shadow_db", 0.0..=20.0, Some(3.0));
    // From nine in ten to one in ten within about 9 dB, as a Wi-Fi frame under fading.
    let soft_db = table.number("soft_db", 0.01..=20.0, Some(2.0));
    Some(Propagation {
        exponent: exponent?,
        half_range_m: half_range_m?,
        wall_db: wall_db?,
        shadow_db: shadow_db?,
        soft_db: soft_db?,
    })
}

fn airtime(table: &mut Table<'_>) -> Option<Airtime> {
    // A 75-byte broadcast at 1 Mbit/s with its preamble.
    let message_ms = table.number("message_ms", 0.001..=1_000.0, Some(1.0));
    // One period of the beacons: after that the next one is better.
    let wait_ms_max = table.number("wait_ms_max", 0.0..=10_000.0, Some(100.0));
    Some(Airtime { message_ms: message_ms?, wait_ms_max: wait_ms_max? })
}

fn partition(table: &mut Table<'_>) -> Option<Partition> {
    let from_s = table.number("from_s", 0.0..=RUN_S_MAX, None);
    let until_s = table.number("until_s", 0.0..=RUN_S_MAX, None);
    let ids = table.ids("ids", ROBOTS_MAX);
    let (from_s, until_s) = (from_s?, until_s?);
    if until_s <= from_s {
        let words = Words::new(until_s.to_string(), format!("more than from_s, {from_s}"), "swap them?");
        table.problem("until_s", words);
        return None;
    }
    Some(Partition { from_s, until_s, ids: ids? })
}
