//! Who competes: the paper as printed and with repairs, what ships, and what it would be without each of its parts.

/// The paper's own scenes, on which all rows run.
pub(super) const OF_PAPER: [&str; 2] = ["flock_u", "flock_t"];
/// The row of the paper.
pub(super) const LITERAL: &str = "literal";
/// The row of what ships.
pub(super) const SAFE: &str = "safe";

/// The row of kept links, which is none where a robot is alone with its goal.
const LINKS: &str = "safe, links kept";
const ALONE: &str = "flock_single";

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What the table calls it.
    pub(super) name: &'static str,
    /// Overrides on a scene's `[behaviour]`, with spaces between them.
    pub(super) set: &'static str,
    /// Whether it runs on all scenes, not on the paper's alone.
    everywhere: bool,
    /// Shares of successes on [`OF_PAPER`], as a Python prototype measured them: other scenes and starts. Opening
    /// (300 mm) and depth (200 mm) are alike, starts and the leader's way are not.
    prototype: Option<[f64; 2]>,
}

impl Row {
    /// Of [`OF_PAPER`] alone.
    const fn of_paper(name: &'static str, set: &'static str) -> Self {
        Self { name, set, everywhere: false, prototype: None }
    }

    /// Of all scenes.
    pub(super) const fn of_all(name: &'static str, set: &'static str) -> Self {
        Self { name, set, everywhere: true, prototype: None }
    }

    const fn prototype(self, shares: [f64; 2]) -> Self {
        Self { prototype: Some(shares), ..self }
    }

    /// Its overrides, as `--set` has them.
    pub(super) fn overrides(&self) -> Vec<String> {
        self.set.split_whitespace().map(|set| format!("behaviour.{set}")).collect()
    }

    /// What the prototype had on the scene of this name.
    pub(super) fn prototype_on(&self, scene: &str) -> Option<f64> {
        let at = OF_PAPER.iter().position(|name| *name == scene)?;
        self.prototype.map(|shares| shares[at])
    }
}

/// The paper, and what can be done for it.
const PAPER: [Row; 12] = [
    Row::of_paper("no wall following", "mode=literal walls=none").prototype([0.10, 0.23]),
    Row::of_paper("no wall following, 180 deg/s", "mode=literal walls=none turn_radps=3.1416").prototype([0.33, 0.17]),
    Row::of_all(LITERAL, "mode=literal").prototype([0.20, 0.47]),
    Row::of_paper("literal, window 1 s", "mode=literal deadlock_s=1").prototype([0.12, 0.33]),
    Row::of_paper("literal, walls not solid", "mode=literal solid=false").prototype([0.90, 0.88]),
    Row::of_paper("literal, v >= 0", "mode=literal reverse=false").prototype([0.20, 0.80]),
    Row::of_paper("literal, v >= 0, 180 deg/s", "mode=literal reverse=false turn_radps=3.1416").prototype([0.42, 0.93]),
    Row::of_paper("+ 360 deg laser", "mode=literal reverse=false turn_radps=3.1416 laser_rad=6.2831")
        .prototype([0.68, 0.93]),
    Row::of_paper("+ side latch", "mode=literal reverse=false turn_radps=3.1416 laser_rad=6.2831 side_latch=true"),
    Row::of_paper(
        "+ Pledge exit, 18 deg/s",
        "mode=literal reverse=false laser_rad=6.2831 side_latch=true walls=pledge",
    )
    .prototype([0.93, 0.97]),
    Row::of_paper(
        "+ Pledge exit, 180 deg/s",
        "mode=literal reverse=false turn_radps=3.1416 laser_rad=6.2831 side_latch=true walls=pledge",
    )
    .prototype([0.97, 0.95]),
    Row::of_paper(
        "the same, turning limited on walls",
        "mode=literal reverse=false turn_radps=3.1416 wall_turn_radps=3.1416 laser_rad=6.2831 side_latch=true \
         walls=pledge",
    )
    .prototype([0.95, 0.72]),
];

/// What ships, and the same under limits of turning like the paper's.
const OURS: [Row; 3] = [
    Row::of_all(SAFE, ""),
    Row::of_all("safe, 18 deg/s", "turn_radps=0.3142 wall_turn_radps=26.2"),
    Row::of_paper("safe, 18 deg/s everywhere", "turn_radps=0.3142 wall_turn_radps=0.3142"),
];

/// What ships, each time without one of its parts, or with one that it does without. A trail hides what else gets
/// robots out of traps: the parts of that are shown without it.
const PARTS: [Row; 10] = [
    Row::of_all("safe, no trail", "trail=false"),
    Row::of_all("no trail, reverse", "trail=false reverse=true"),
    Row::of_all("no trail, front laser", "trail=false laser_rad=3.1416"),
    Row::of_all("no trail, no side latch", "trail=false side_latch=false"),
    Row::of_all("no trail, no wall following", "trail=false walls=none"),
    Row::of_all("no trail, no right of way", "trail=false right_of_way=false"),
    Row::of_all("safe, no wall following", "walls=none"),
    Row::of_all("safe, ORCA", "avoidance=orca"),
    Row::of_all("safe, loses nobody", "lose_nobody=true"),
    Row::of_all(LINKS, "guard=full link_range_m=0.4"),
];

/// The rows of a scene; `quick`: the paper's and ours.
pub(super) fn of(scene: &str, quick: bool) -> Vec<Row> {
    let all = PAPER.into_iter().chain(OURS).chain(PARTS);
    let runs_there =
        all.filter(|row| row.everywhere || OF_PAPER.contains(&scene)).filter(|row| row.name != LINKS || scene != ALONE);
    runs_there.filter(|row| !quick || [LITERAL, SAFE].contains(&row.name)).collect()
}
