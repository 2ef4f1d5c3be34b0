//! Where the rows compete: the paper's three experiments, and fields and pockets that nobody was tuned on.

use anyhow::Context;
use drover_config::{Behaviour, Deploy, Override, Swarm, load_swarm};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Where the swarms' files are, seen from the top of the project.
const FOLDER: &str = "config/swarms";
/// The file that the cost is measured with, and the only scene of a quick run.
const COST: &str = "deploy_exp2";
const QUICK: &str = "deploy_exp1";
/// Seeds unless given.
const SEEDS: Range<u64> = 0..20;
const SEEDS_QUICK: Range<u64> = 0..2;

/// The scenes, and what is overridden on them before a row's own overrides. The pockets' file ships with the map known;
/// here only the row of that name knows it, so that all others are asked the same.
const SCENES: [(&str, &[&str]); 6] = [
    (QUICK, &[]),
    (COST, &[]),
    ("deploy_exp3_row", &[]),
    ("deploy_exp3_random", &[]),
    ("deploy_field", &[]),
    ("deploy_pockets", &["behaviour.escape=none"]),
];

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct DeployPlan {
    pub(super) scenes: Vec<Scene>,
    pub(super) seeds: Range<u64>,
    pub(super) quick: bool,
    cost: Option<PathBuf>,
}

/// A swarm's file, and what of it is overridden for all rows.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    file: PathBuf,
    base: &'static [&'static str],
}

impl DeployPlan {
    /// All scenes, or `swarm` alone; `seeds` unless the usual ones are meant. `quick`: few of everything.
    ///
    /// # Errors
    /// If a file is not there, cannot be read or tells a swarm to do something else.
    pub fn new(swarm: Option<&Path>, seeds: Option<Range<u64>>, quick: bool) -> anyhow::Result<Self> {
        Self::within(Path::new(FOLDER), swarm, seeds, quick)
    }

    /// The same with the shipped files in `folder`.
    pub(super) fn within(
        folder: &Path,
        swarm: Option<&Path>,
        seeds: Option<Range<u64>>,
        quick: bool,
    ) -> anyhow::Result<Self> {
        let file = |name: &str| folder.join(name).with_extension("toml");
        let shipped = SCENES.into_iter().filter(|(name, _)| !quick || *name == QUICK);
        let scenes: Vec<Scene> = match swarm {
            Some(swarm) => vec![Scene::of(swarm.to_owned())],
            None => shipped.map(|(name, _)| Scene::of(file(name))).collect(),
        };
        let cost = swarm.is_none().then(|| file(COST));
        let usual = if quick { SEEDS_QUICK } else { SEEDS };
        let plan = Self { scenes, seeds: seeds.unwrap_or(usual), quick, cost };
        plan.check()?;
        Ok(plan)
    }

    /// The swarm that the cost is measured with; none if one swarm was asked for.
    pub(super) fn cost_file(&self) -> Option<&Path> {
        self.cost.as_deref()
    }

    /// What is wrong with a file is said before hours of runs, not after.
    fn check(&self) -> anyhow::Result<()> {
        let files = self.scenes.iter().map(|scene| &scene.file).chain(&self.cost);
        let missing: Vec<String> =
            files.filter(|file| !file.is_file()).map(|file| file.display().to_string()).collect();
        anyhow::ensure!(
            missing.is_empty(),
            "not there: {}. The scenes of this bench are files: run it from the top of the project, which has them in \
             {FOLDER}, or name one swarm with --swarm",
            missing.join(", ")
        );
        for scene in &self.scenes {
            deploys(&scene.load(&[], self.seeds.start)?)?;
        }
        Ok(())
    }
}

impl Scene {
    /// A shipped file by its name, or one that nobody knows.
    fn of(file: PathBuf) -> Self {
        let is_named = |(name, _): &(&str, _)| file.file_stem().is_some_and(|stem| stem == *name);
        let base = SCENES.into_iter().find(is_named).map(|(_, base)| base).unwrap_or_default();
        Self { file, base }
    }

    /// The swarm of a row and a seed: read anew, since generated places, starts and assignment follow from both.
    pub(super) fn load(&self, set: &[&str], seed: u64) -> anyhow::Result<Swarm> {
        let seed = format!("seed={seed}");
        let all = self.base.iter().chain(set).copied().chain([seed.as_str()]);
        load(&self.file, all).with_context(|| format!("{}, {seed}", self.file.display()))
    }

    /// The file's name without its ending.
    pub(super) fn name(&self) -> String {
        self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// A swarm's file with overrides, the last of which counts.
pub(super) fn load<'s>(file: &Path, set: impl IntoIterator<Item = &'s str>) -> anyhow::Result<Swarm> {
    let set: Result<Vec<Override>, _> = set.into_iter().map(Override::parse).collect();
    let set = set.map_err(|problem| anyhow::anyhow!("{problem}"))?;
    load_swarm(file, &set).map_err(anyhow::Error::new)
}

/// What the swarm is to do.
pub(super) fn deploys(swarm: &Swarm) -> anyhow::Result<&Deploy> {
    match &swarm.behaviour {
        Behaviour::Deploy(deploy) => Ok(deploy),
        Behaviour::Flock(_) | Behaviour::Diffuse(_) => anyhow::bail!("swarm {:?} does not deploy", swarm.name),
    }
}
