//! Who competes: the paper's method and what it is without its parts, classical methods with the paper's value and with
//! plain steps, and what ships.

use drover_config::{Explore, ExploreMethod};

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What the table calls it.
    pub(super) name: &'static str,
    /// Overrides on a scene's `[behaviour]`, with spaces between them.
    set: &'static str,
    /// Whether a quick run has it.
    pub(super) quick: bool,
    /// Mean steps to 96 %, as a prototype measured them on worlds of its own: random, rooms, maze, cave.
    prototype: Option<[u32; 4]>,
}

/// The paper's own scenes, in the order of the prototype's figures.
pub(super) const SCENES: [&str; 4] = ["explore_random", "explore_rooms", "explore_maze", "explore_cave"];

/// The paper's method, and the same without directions: figure 6.
pub(super) const INEA: &str = "INEA";
pub(super) const INEA_ASTRAY: &str = "INEA, no direction";
/// Those that every table has.
const PRINCIPAL: [&str; 4] = [INEA, "MinPos, eq. 9", "sweep", "sweep, whole"];

const fn row(name: &'static str, set: &'static str) -> Row {
    Row { name, set, quick: false, prototype: None }
}

impl Row {
    const fn quick(self) -> Self {
        Self { quick: true, ..self }
    }

    const fn prototype(self, steps: [u32; 4]) -> Self {
        Self { prototype: Some(steps), ..self }
    }

    /// Its overrides, as `--set` has them.
    pub(super) fn overrides(&self) -> Vec<String> {
        self.set.split_whitespace().map(|set| format!("behaviour.{set}")).collect()
    }

    /// What the prototype had on the scene of this name.
    pub(super) fn prototype_on(&self, scene: &str) -> Option<u32> {
        let at = SCENES.iter().position(|name| *name == scene)?;
        self.prototype.map(|steps| steps[at])
    }
}

/// All of them.
pub(super) const ROWS: [Row; 19] = [
    row(INEA, "method=inea").quick().prototype([658, 784, 771, 691]),
    row("INEA, closed form", "method=inea closed_form=true"),
    row(INEA_ASTRAY, "method=inea direction_weight=0").quick(),
    row("INEA, no T cell", "method=inea t_cell_rate=0"),
    row("INEA, share .9", "method=inea affinity_share=0.9"),
    row("basic immune", "method=basic").prototype([864, 991, 1047, 908]),
    row("basic immune, as printed", "method=basic suppression=printed").prototype([622, 740, 764, 671]),
    row("greedy", "method=greedy").prototype([627, 743, 804, 708]),
    row("nearest frontier", "method=nearest").prototype([1074, 1558, 1259, 876]),
    row("Burgard, eq. 9", "method=burgard").prototype([597, 725, 748, 659]),
    row("Burgard, steps", "method=burgard value=cost"),
    row("Hungarian, eq. 9", "method=hungarian").prototype([584, 710, 752, 644]),
    row("Hungarian, steps", "method=hungarian value=cost"),
    row("MinPos, eq. 9", "method=min_pos").quick().prototype([591, 715, 729, 649]),
    row("MinPos, steps", "method=min_pos value=cost"),
    row("market, eq. 9", "method=market").prototype([826, 1048, 1013, 902]),
    row("market, steps", "method=market value=cost").prototype([934, 1233, 1193, 1005]),
    row("sweep", "method=sweep").quick().prototype([448, 648, 625, 462]),
    row("sweep, whole", "method=sweep finish=whole").quick().prototype([507, 710, 689, 526]),
];

/// Those that every table has, in its order.
pub(super) fn principal() -> Vec<Row> {
    PRINCIPAL.into_iter().filter_map(row_named).collect()
}

/// The row of this name.
pub(super) fn row_named(name: &str) -> Option<Row> {
    ROWS.into_iter().find(|row| row.name == name)
}

/// A place has no more obstacles than this; beyond, larger ones cover the same share.
const OBSTACLES_MAX: u32 = 500;

/// What makes of a scene's place one of so many cells to a side, with the rim, as dense as the file's own.
pub(super) fn sized(scene: &str, side_cells: u32) -> Vec<String> {
    let inner_m = side_cells - 2;
    let mut set = vec![format!("world.generate.width_m={inner_m}"), format!("world.generate.height_m={inner_m}")];
    if scene == SCENES[0] {
        let wanted = inner_m * inner_m * 60 / (98 * 98);
        let count = wanted.min(OBSTACLES_MAX);
        set.push(format!("world.generate.count={count}"));
        if count < wanted {
            let scale = (f64::from(wanted) / f64::from(count)).sqrt();
            set.push(format!("world.generate.size_min_m={:.2}", 2.0 * scale));
            set.push(format!("world.generate.size_max_m={:.2}", 8.0 * scale));
        }
    } else if scene == SCENES[1] {
        let rooms = (inner_m * 5 + 49) / 98;
        set.push(format!("world.generate.columns={rooms}"));
        set.push(format!("world.generate.rows={rooms}"));
    }
    set
}

/// Those whose decisions are timed.
pub(super) fn timed() -> [(&'static str, Explore); 3] {
    let usual = Explore::usual;
    let closed = Explore { closed_form: true, ..usual(ExploreMethod::Inea) };
    [
        ("INEA, closed form", closed),
        ("MinPos, eq. 9", usual(ExploreMethod::MinPos)),
        ("sweep", usual(ExploreMethod::Sweep)),
    ]
}
