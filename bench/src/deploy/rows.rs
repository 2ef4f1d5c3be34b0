//! Who competes: the paper as printed and with repairs, what ships and what it would be without each part, peers.

use super::peers;

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What the table calls it.
    pub(super) name: &'static str,
    /// Who decides.
    pub(super) contender: Contender,
}

/// Who decides.
#[derive(Clone, Copy, Debug)]
pub(super) enum Contender {
    /// Ours, with these overrides on a scene's file.
    Ours(&'static [&'static str]),
    /// One of [`peers::all`], by its place in there.
    Peer(usize),
}

impl Row {
    /// Its overrides; none for a peer.
    pub(super) fn overrides(&self) -> Option<Vec<&'static str>> {
        match self.contender {
            Contender::Ours(set) => Some(set.to_vec()),
            Contender::Peer(_) => None,
        }
    }
}

/// The row of the paper without its optimisation of links.
pub(super) const ALL_LINKS: &str = "literal, all links";
/// The row of the paper.
pub(super) const LITERAL: &str = "literal";
/// The row of what ships.
pub(super) const SAFE: &str = "safe";

const LITERALLY: &str = "behaviour.mode=literal";
const REPEL_2: &str = "behaviour.repel_gain=2";
const PROJECT: &str = "behaviour.steer=project";

/// The paper, and what can be done for it.
const PAPER: [(&str, &[&str]); 11] = [
    (ALL_LINKS, &[LITERALLY, "behaviour.links=all", REPEL_2]),
    (LITERAL, &[LITERALLY]),
    ("literal, repel_gain 2", &[LITERALLY, REPEL_2]),
    // The prototype's remedy against tunnelling: a step is no longer than what repels before everything else.
    ("literal, avoid_m_min = 1", &[LITERALLY, "behaviour.avoid_m_min=1", "behaviour.epsilon_m=1", REPEL_2]),
    ("literal + Hungarian", &[LITERALLY, "behaviour.assignment=hungarian"]),
    ("literal, classical sum", &[LITERALLY, "behaviour.forces=sum", REPEL_2]),
    ("literal, coupled rotation", &[LITERALLY, "behaviour.rotation=coupled"]),
    ("literal + collision guard", &[LITERALLY, "behaviour.guard=collision"]),
    ("literal + collision, project", &[LITERALLY, "behaviour.guard=collision", PROJECT]),
    ("literal + full guard", &[LITERALLY, "behaviour.guard=full"]),
    ("literal + full guard, project", &[LITERALLY, "behaviour.guard=full", PROJECT]),
];

/// The prototype that what ships grew out of, what ships, and the same where the map is known.
const OURS: [(&str, &[&str]); 3] = [
    (
        "W (prototype)",
        &[
            "behaviour.mode=safe",
            "behaviour.hops=4",
            "behaviour.goalward=0",
            "behaviour.spread=0",
            "behaviour.goal_gain=0.2",
            "behaviour.link_gain=0.4",
            "behaviour.repel_gain=0.4",
            "behaviour.detours=false",
        ],
    ),
    (SAFE, &[]),
    ("safe + known map", &["behaviour.escape=geodesic"]),
];

/// What ships, each time without one of its parts.
const ABLATIONS: [(&str, &[&str]); 10] = [
    ("safe, hops = 1", &["behaviour.hops=1"]),
    ("safe, hops = 2", &["behaviour.hops=2"]),
    ("safe, assignment given", &["behaviour.assignment=given"]),
    ("safe, no follow", &["behaviour.follow=false"]),
    ("safe, no detours", &["behaviour.detours=false"]),
    ("safe, project", &[PROJECT]),
    ("safe, no repulsion", &["behaviour.repel_gain=0"]),
    ("safe, goalward = 0", &["behaviour.goalward=0"]),
    ("safe, spread = 0", &["behaviour.spread=0"]),
    ("safe, collision guard only", &["behaviour.guard=collision"]),
];

/// The rows of a run; `quick`: the paper's, ours and one peer's.
pub(super) fn of(quick: bool) -> Vec<Row> {
    let ours = PAPER.into_iter().chain(OURS).chain(ABLATIONS);
    let ours = ours.map(|(name, set)| Row { name, contender: Contender::Ours(set) });
    let names = peers::all().into_iter().enumerate();
    let peers = names.map(|(at, peer)| Row { name: peer.name(), contender: Contender::Peer(at) });
    ours.chain(peers).filter(|row| !quick || [LITERAL, SAFE, "cbf"].contains(&row.name)).collect()
}
