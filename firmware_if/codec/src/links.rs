//! DROVER_LINKS of our own dialect: what [`drover_contract::LinkReport`] says, framed as a beacon is.
//!
//! 189 bytes of state (201 on the wire at most) and 64 more for a signature that is not made yet. Three things are
//! packed, since all of it has to fit one frame: centres stand as centimetres from one anchor, which every report
//! chooses anew; what was made in a term is told by its age, which ends at 255; an id of 0 is an empty place.
//!
//! An age at its end reads as made in term 0. Told older than it is, a link proves less than it could, never more.

use crate::beacon::{DecodeError, Message, POSITION_M_MAX, emitter, system_window};
use crate::mavlink::raw::Raw;
use drover_contract::{
    Departure, EDGES_TOLD_MAX, LINKS_TOLD_MAX, LinkEdge, LinkEntry, LinkReport, RobotId, RootOffer, Vec2,
};

pub(crate) const LINKS: u32 = 52_002;
pub(crate) const LINKS_EXTRA_CRC: u8 = 189;
const STATE_BYTES: usize = 189;
/// With the signature.
pub(crate) const LINKS_BYTES_MAX: usize = STATE_BYTES + 64;

const HOLDS: u8 = 1;
const NEWEST: u8 = 2;
const PROPOSES: u8 = 4;
const ASKS: u8 = 8;

/// Where each field starts.
mod at {
    pub(super) const SWARM: usize = 0;
    pub(super) const ROBOT: usize = 4;
    pub(super) const EPOCH: usize = 8;
    pub(super) const SEQ: usize = 12;
    pub(super) const TERM: usize = 16;
    pub(super) const ROOT: usize = 20;
    pub(super) const ROOT_METRIC: usize = 24;
    pub(super) const ANCHOR_X: usize = 28;
    pub(super) const ANCHOR_Y: usize = 32;
    pub(super) const PEER: usize = 36;
    pub(super) const EDGE_LOW: usize = 64;
    pub(super) const EDGE_HIGH: usize = 76;
    pub(super) const GONE: usize = 88;
    pub(super) const ROOT_SEQ: usize = 92;
    pub(super) const PEER_EPOCH: usize = 94;
    pub(super) const VERSION: usize = 108;
    pub(super) const WEIGHT: usize = 122;
    pub(super) const EDGE_WEIGHT: usize = 136;
    pub(super) const CENTRE_X: usize = 142;
    pub(super) const CENTRE_Y: usize = 156;
    pub(super) const HOPS: usize = 170;
    pub(super) const FLAGS: usize = 171;
    pub(super) const AGE: usize = 178;
    pub(super) const EDGE_AGE: usize = 185;
    pub(super) const GONE_AGE: usize = 188;
}

/// `report` as a datagram; `seq` counts the frames of this sender.
///
/// A proposal whose centre is more than 327 m from the first one's is left out of this datagram: what is not told says
/// nothing, and its turn to be the first one comes.
#[must_use]
pub fn encode_links(swarm: u32, report: &LinkReport, seq: u8) -> Vec<u8> {
    let proposal = report.links.iter().flatten().find(|link| link.proposes);
    let anchor_cm = proposal.map_or([0, 0], |link| [whole_cm(link.centre_w.x), whole_cm(link.centre_w.y)]);
    let mut payload = [0; STATE_BYTES];
    let words = [
        (at::SWARM, swarm),
        (at::ROBOT, report.robot.0),
        (at::EPOCH, report.epoch),
        (at::SEQ, report.seq),
        (at::TERM, report.term),
        (at::ROOT, report.root.root.0),
        (at::ROOT_METRIC, report.root.metric.to_bits()),
        (at::ANCHOR_X, anchor_cm[0].cast_unsigned()),
        (at::ANCHOR_Y, anchor_cm[1].cast_unsigned()),
    ];
    words.into_iter().for_each(|(offset, word)| put(&mut payload, offset, word.to_le_bytes()));
    put(&mut payload, at::ROOT_SEQ, report.root.seq.to_le_bytes());
    put(&mut payload, at::HOPS, [report.root.hops]);
    for (place, link) in report.links.iter().enumerate() {
        let offset_cm = link.and_then(|link| offset_cm(&link, anchor_cm));
        if let (Some(link), Some(offset_cm)) = (link, offset_cm) {
            put_link(&mut payload, place, link, age(report.term, link.made));
            put(&mut payload, at::CENTRE_X + 2 * place, offset_cm[0].to_le_bytes());
            put(&mut payload, at::CENTRE_Y + 2 * place, offset_cm[1].to_le_bytes());
        }
    }
    for (place, edge) in report.edges.iter().enumerate() {
        let Some(edge) = edge else { continue };
        put(&mut payload, at::EDGE_LOW + 4 * place, edge.low.0.to_le_bytes());
        put(&mut payload, at::EDGE_HIGH + 4 * place, edge.high.0.to_le_bytes());
        put(&mut payload, at::EDGE_WEIGHT + 2 * place, weight_cm(edge.weight_m).to_le_bytes());
        put(&mut payload, at::EDGE_AGE + place, [age(report.term, edge.made)]);
    }
    if let Some(gone) = report.gone {
        put(&mut payload, at::GONE, gone.robot.0.to_le_bytes());
        put(&mut payload, at::GONE_AGE, [age(report.term, gone.term)]);
    }
    emitter(report.robot, seq).encode_raw(LINKS, LINKS_EXTRA_CRC, &payload)
}

fn put<const N: usize>(payload: &mut [u8; STATE_BYTES], offset: usize, bytes: [u8; N]) {
    payload[offset..offset + N].copy_from_slice(&bytes);
}

fn put_link(payload: &mut [u8; STATE_BYTES], place: usize, link: &LinkEntry, age: u8) {
    let flags = [(link.holds, HOLDS), (link.newest, NEWEST), (link.proposes, PROPOSES), (link.asks, ASKS)].into_iter();
    put(payload, at::PEER + 4 * place, link.peer.0.to_le_bytes());
    put(payload, at::PEER_EPOCH + 2 * place, link.peer_epoch.to_le_bytes());
    put(payload, at::VERSION + 2 * place, link.version.to_le_bytes());
    put(payload, at::WEIGHT + 2 * place, weight_cm(link.weight_m).to_le_bytes());
    put(payload, at::FLAGS + place, [flags.filter(|(is, _)| *is).fold(0, |sum, (_, bit)| sum | bit)]);
    put(payload, at::AGE + place, [age]);
}

/// A centre from the anchor, if it can be told; zeros where nothing is proposed.
fn offset_cm(link: &LinkEntry, anchor_cm: [i32; 2]) -> Option<[i16; 2]> {
    if !link.proposes {
        return Some([0, 0]);
    }
    let from = |value_m: f64, anchor_cm: i32| i16::try_from(i64::from(whole_cm(value_m)) - i64::from(anchor_cm)).ok();
    Some([from(link.centre_w.x, anchor_cm[0])?, from(link.centre_w.y, anchor_cm[1])?])
}

fn whole_cm(value_m: f64) -> i32 {
    (value_m * 100.0).round() as i32
}

fn weight_cm(weight_m: f64) -> u16 {
    (weight_m * 100.0).round() as u16
}

fn age(term: u32, made: u32) -> u8 {
    u8::try_from(term.saturating_sub(made)).unwrap_or(u8::MAX)
}

fn made(term: u32, age: u8) -> u32 {
    if age == u8::MAX { 0 } else { term.saturating_sub(u32::from(age)) }
}

/// The report in a payload whose frame came from `system`.
pub(crate) fn read_links(raw: Raw<'_>, system: u8) -> Result<Message, DecodeError> {
    let robot = RobotId(raw.u32(at::ROBOT));
    if robot.0 == 0 {
        return Err(DecodeError::Range("robot"));
    }
    if system != system_window(robot) {
        return Err(DecodeError::Sender);
    }
    let root = read_root(raw)?;
    let term = raw.u32(at::TERM);
    let mut links = [None; LINKS_TOLD_MAX];
    for place in 0..LINKS_TOLD_MAX {
        let link = read_link(raw, place, term)?;
        let peer = link.map(|link: LinkEntry| link.peer);
        let told = links.iter().flatten().any(|earlier: &LinkEntry| Some(earlier.peer) == peer);
        if peer == Some(robot) || told {
            return Err(DecodeError::Range("peer"));
        }
        links[place] = link;
    }
    let mut edges = [None; EDGES_TOLD_MAX];
    for (place, edge) in edges.iter_mut().enumerate() {
        *edge = read_edge(raw, place, term)?;
    }
    let gone = RobotId(raw.u32(at::GONE));
    let departure = Departure { robot: gone, term: made(term, raw.u8(at::GONE_AGE)) };
    let report = LinkReport {
        robot,
        epoch: raw.u32(at::EPOCH),
        seq: raw.u32(at::SEQ),
        term,
        root,
        links,
        edges,
        gone: (gone.0 != 0).then_some(departure),
    };
    Ok(Message::Links { swarm: raw.u32(at::SWARM), report: Box::new(report) })
}

fn read_root(raw: Raw<'_>) -> Result<RootOffer, DecodeError> {
    let (root, metric) = (RobotId(raw.u32(at::ROOT)), raw.f32(at::ROOT_METRIC));
    if root.0 == 0 {
        return Err(DecodeError::Range("root"));
    }
    if !metric.is_finite() {
        return Err(DecodeError::Range("root_metric"));
    }
    Ok(RootOffer { root, metric, seq: raw.u16(at::ROOT_SEQ), hops: raw.u8(at::HOPS) })
}

fn read_link(raw: Raw<'_>, place: usize, term: u32) -> Result<Option<LinkEntry>, DecodeError> {
    let peer = RobotId(raw.u32(at::PEER + 4 * place));
    let flags = raw.u8(at::FLAGS + place);
    let is = |bit: u8| flags & bit != 0;
    if peer.0 == 0 {
        return Ok(None);
    }
    let coordinate = |anchor: usize, offset: usize, name: &'static str| {
        let anchor_cm = i64::from(raw.u32(anchor).cast_signed());
        let value_m = (anchor_cm + i64::from(raw.i16(offset + 2 * place))) as f64 / 100.0;
        if value_m.abs() <= POSITION_M_MAX { Ok(value_m) } else { Err(DecodeError::Range(name)) }
    };
    let centre_w = if is(PROPOSES) {
        Vec2::new(
            coordinate(at::ANCHOR_X, at::CENTRE_X, "anchor_x")?,
            coordinate(at::ANCHOR_Y, at::CENTRE_Y, "anchor_y")?,
        )
    } else {
        Vec2::zeros()
    };
    Ok(Some(LinkEntry {
        peer,
        peer_epoch: raw.u16(at::PEER_EPOCH + 2 * place),
        version: raw.u16(at::VERSION + 2 * place),
        holds: is(HOLDS),
        newest: is(NEWEST),
        proposes: is(PROPOSES),
        asks: is(ASKS),
        centre_w,
        made: made(term, raw.u8(at::AGE + place)),
        weight_m: f64::from(raw.u16(at::WEIGHT + 2 * place)) / 100.0,
    }))
}

fn read_edge(raw: Raw<'_>, place: usize, term: u32) -> Result<Option<LinkEdge>, DecodeError> {
    let low = RobotId(raw.u32(at::EDGE_LOW + 4 * place));
    let high = RobotId(raw.u32(at::EDGE_HIGH + 4 * place));
    if low.0 == 0 {
        return Ok(None);
    }
    if low >= high {
        return Err(DecodeError::Range("edge"));
    }
    let weight_m = f64::from(raw.u16(at::EDGE_WEIGHT + 2 * place)) / 100.0;
    Ok(Some(LinkEdge { low, high, made: made(term, raw.u8(at::EDGE_AGE + place)), weight_m }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beacon::{decode, swarm_hash};
    use crate::mavlink::golden::vectors;
    use drover_contract::{WEIGHT_M_MAX, on_grid_m};
    use proptest::prelude::*;

    fn golden(label: &str) -> Vec<u8> {
        let file = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/links.txt"));
        vectors(file).remove(label).expect("known label").bytes
    }

    fn link(peer: u32, peer_epoch: u16, version: u16) -> LinkEntry {
        LinkEntry {
            peer: RobotId(peer),
            peer_epoch,
            version,
            holds: false,
            newest: false,
            proposes: false,
            asks: false,
            centre_w: Vec2::zeros(),
            made: 0,
            weight_m: 0.0,
        }
    }

    fn edge(low: u32, high: u32, made: u32, weight_m: f64) -> LinkEdge {
        LinkEdge { low: RobotId(low), high: RobotId(high), made, weight_m }
    }

    /// What `links` of the golden vectors says, as tests/golden/mavlink/make.py spells it.
    fn sample() -> LinkReport {
        let mut links = [None; LINKS_TOLD_MAX];
        links[0] = Some(LinkEntry { holds: true, newest: true, asks: true, made: 300, weight_m: 2.5, ..link(2, 7, 3) });
        let centre_w = Vec2::new(1250.25, -3250.5);
        let first = link(70_004, 65_535, 65_535);
        links[1] = Some(LinkEntry { proposes: true, centre_w, made: 299, weight_m: WEIGHT_M_MAX, ..first });
        links[2] = Some(LinkEntry { holds: true, made: 46, weight_m: 1.2, ..link(70_005, 1, 9) });
        let centre_w = Vec2::new(922.57, -2922.83);
        let last = link(70_006, 2, 1);
        links[3] = Some(LinkEntry { holds: true, proposes: true, centre_w, made: 0, weight_m: 3.33, ..last });
        LinkReport {
            robot: RobotId(70_003),
            epoch: 5,
            seq: 1234,
            term: 300,
            root: RootOffer { root: RobotId(2), metric: 12.5, seq: 65_535, hops: 4 },
            links,
            edges: [Some(edge(2, 4, 300, 1.01)), Some(edge(4, 9, 297, 2.02)), None],
            gone: Some(Departure { robot: RobotId(11), term: 288 }),
        }
    }

    fn read(datagram: &[u8]) -> LinkReport {
        match decode(datagram) {
            Ok(Message::Links { swarm, report }) if swarm == swarm_hash("first") => *report,
            other => panic!("no links of the swarm: {other:?}"),
        }
    }

    #[test]
    fn our_report_is_the_bytes_that_pymavlink_makes_from_our_dialect() {
        assert_eq!(encode_links(swarm_hash("first"), &sample(), 17), golden("links"));
        let lone = LinkReport {
            epoch: 0,
            seq: 0,
            term: 0,
            root: RootOffer { root: RobotId(70_003), metric: 0.0, seq: 0, hops: 0 },
            links: [None; LINKS_TOLD_MAX],
            edges: [None; EDGES_TOLD_MAX],
            gone: None,
            ..sample()
        };
        assert_eq!(encode_links(swarm_hash("first"), &lone, 17), golden("links_of_a_lone_robot"));
        assert_eq!(read(&golden("links_of_a_lone_robot")), lone);
    }

    #[test]
    fn a_report_that_pymavlink_made_reads_as_what_it_says_signed_or_not() {
        assert_eq!(read(&golden("links")), sample());
        assert_eq!(read(&golden("links_with_signature")), sample());
        assert_eq!(golden("links_full").len(), 201, "189 bytes of state, 12 around them");
        let full = read(&golden("links_full"));
        assert!(full.links.iter().flatten().count() == 7 && full.edges.iter().flatten().count() == 3);
        assert!(full.links.iter().flatten().all(|link| link.made == 0), "of an unknown age: as old as can be");
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let refused = |label| decode(&golden(label)).expect_err("refused");
        assert_eq!(refused("bad_links_robot"), DecodeError::Range("robot"));
        assert_eq!(refused("bad_links_sender"), DecodeError::Sender);
        assert_eq!(refused("bad_links_nan"), DecodeError::Range("root_metric"));
        assert_eq!(refused("bad_links_root"), DecodeError::Range("root"));
        assert_eq!(refused("bad_links_anchor"), DecodeError::Range("anchor_y"));
        assert_eq!(refused("bad_links_peer"), DecodeError::Range("peer"));
        assert_eq!(refused("bad_links_twice"), DecodeError::Range("peer"));
        assert_eq!(refused("bad_links_edge"), DecodeError::Range("edge"));
    }

    #[test]
    fn a_proposal_too_far_from_the_first_one_waits_for_its_turn() {
        let mut report = sample();
        let far = report.links[3].as_mut().expect("a proposal");
        far.centre_w.x = 922.56;
        let left = read(&encode_links(swarm_hash("first"), &report, 0));
        assert!(left.links[3].is_none() && left.links[1] == report.links[1]);
        report.links.swap(1, 3);
        assert_eq!(read(&encode_links(swarm_hash("first"), &report, 0)).links[1], report.links[1]);
    }

    proptest! {
        #[test]
        fn points_of_the_grid_travel_unchanged(x_m in -1e6..1e6_f64, y_m in -1e6..1e6_f64, near in -300.0..300.0_f64) {
            let mut report = sample();
            let [x_m, y_m] = [on_grid_m(x_m), on_grid_m(y_m)];
            let centres_w = [Vec2::new(x_m, y_m), Vec2::new(on_grid_m((x_m + near).clamp(-1e6, 1e6)), y_m)];
            report.links[1].as_mut().expect("a proposal").centre_w = centres_w[0];
            report.links[3].as_mut().expect("a proposal").centre_w = centres_w[1];
            let back = read(&encode_links(swarm_hash("first"), &report, 0));
            let centre_w = |place: usize| back.links[place].expect("a proposal").centre_w;
            prop_assert!(centre_w(1) == centres_w[0] && centre_w(3) == centres_w[1]);
        }

        #[test]
        fn any_payload_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 1..=LINKS_BYTES_MAX)) {
            let from = RobotId(u32::from_le_bytes([bytes[0], 0, 0, 0]));
            let datagram = emitter(from, 0).encode_raw(LINKS, LINKS_EXTRA_CRC, &bytes);
            if let Ok(Message::Links { swarm, report }) = decode(&datagram) {
                prop_assert!(decode(&encode_links(swarm, &report, 0)).is_ok());
            }
        }
    }
}
