//! What those benches have in common whose rows compete on the same scenes with the same seeds: the scenes' files, the
//! jobs, the words of a table, the robots' ways.

pub(crate) mod table;
mod ways;

pub use ways::Ways;
pub(crate) use ways::{Figure, record_ways};

use anyhow::Context;
use drover_config::{Override, Swarm, load_swarm};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Where the swarms' files are, seen from the top of the project.
const FOLDER: &str = "config/swarms";

/// What a bench runs unless told otherwise.
#[derive(Clone, Debug)]
pub(crate) struct Usual {
    /// The names of its scenes' files, and what is overridden on each before a row's own overrides.
    pub(crate) scenes: &'static [(&'static str, &'static [&'static str])],
    /// The only scene of a quick run.
    pub(crate) quick: &'static str,
    /// The file that the cost is measured with.
    pub(crate) cost: &'static str,
    /// Seeds, and those of a quick run.
    pub(crate) seeds: Range<u64>,
    pub(crate) seeds_quick: Range<u64>,
    /// Says so if a swarm does something else than this bench measures.
    pub(crate) fits: fn(&Swarm) -> anyhow::Result<()>,
}

/// What was asked for on the command line.
#[derive(Clone, Debug, Default)]
pub(crate) struct Asked<'a> {
    /// The only scene; all of the bench's unless given.
    pub(crate) swarm: Option<&'a Path>,
    /// Seeds; the bench's usual ones unless given.
    pub(crate) seeds: Option<Range<u64>>,
    /// Few of everything.
    pub(crate) quick: bool,
}

/// What is to be measured.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) scenes: Vec<Scene>,
    pub(crate) seeds: Range<u64>,
    pub(crate) quick: bool,
    cost: Option<PathBuf>,
}

/// A swarm's file, and what of it is overridden for all rows.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    file: PathBuf,
    base: &'static [&'static str],
}

impl Plan {
    /// With the shipped files as they are seen from the top of the project.
    pub(crate) fn new(usual: &Usual, asked: Asked<'_>) -> anyhow::Result<Self> {
        Self::within(Path::new(FOLDER), usual, asked)
    }

    /// With the shipped files in `folder`.
    pub(crate) fn within(folder: &Path, usual: &Usual, asked: Asked<'_>) -> anyhow::Result<Self> {
        let file = |name: &str| folder.join(name).with_extension("toml");
        let shipped = usual.scenes.iter().filter(|(name, _)| !asked.quick || *name == usual.quick);
        let scenes: Vec<Scene> = match asked.swarm {
            Some(swarm) => vec![Scene::of(usual, swarm.to_owned())],
            None => shipped.map(|(name, _)| Scene::of(usual, file(name))).collect(),
        };
        let cost = asked.swarm.is_none().then(|| file(usual.cost));
        let seeds = if asked.quick { &usual.seeds_quick } else { &usual.seeds };
        let plan = Self { scenes, seeds: asked.seeds.unwrap_or_else(|| seeds.clone()), quick: asked.quick, cost };
        plan.check(usual.fits)?;
        Ok(plan)
    }

    /// The swarm that the cost is measured with; none if one swarm was asked for.
    pub(crate) fn cost_file(&self) -> Option<&Path> {
        self.cost.as_deref()
    }

    /// The scene whose file has this name.
    pub(crate) fn named(&self, name: &str) -> Option<&Scene> {
        self.scenes.iter().find(|scene| scene.name() == name)
    }

    /// What is wrong with a file is said before hours of runs, not after.
    fn check(&self, fits: fn(&Swarm) -> anyhow::Result<()>) -> anyhow::Result<()> {
        let files = self.scenes.iter().map(|scene| &scene.file).chain(&self.cost);
        let missing: BTreeSet<String> =
            files.filter(|file| !file.is_file()).map(|file| file.display().to_string()).collect();
        anyhow::ensure!(
            missing.is_empty(),
            "not there: {}. The scenes of this bench are files: run it from the top of the project, which has them in \
             {FOLDER}, or name one swarm with --swarm",
            missing.into_iter().collect::<Vec<String>>().join(", ")
        );
        self.scenes.iter().try_for_each(|scene| fits(&scene.load(&[], self.seeds.start)?))
    }

    /// The runs of each contender, in the order of seeds, spread over all cores; no result depends on how many there
    /// are. `on_run` is told of every run that has ended, on whatever thread that is.
    pub(crate) fn run_all<C: Sync, T: Send>(
        &self,
        contenders: &[C],
        run: impl Fn(&C, u64) -> anyhow::Result<T> + Sync,
        on_run: &(dyn Fn() + Sync),
    ) -> anyhow::Result<Vec<Vec<T>>> {
        let seeds: Vec<u64> = self.seeds.clone().collect();
        let jobs: Vec<(&C, u64)> =
            contenders.iter().flat_map(|contender| seeds.iter().map(move |seed| (contender, *seed))).collect();
        let job = |(contender, seed): &(&C, u64)| {
            let result = run(contender, *seed);
            on_run();
            result
        };
        let runs: Vec<T> = jobs.par_iter().map(job).collect::<anyhow::Result<_>>()?;
        let mut runs = runs.into_iter();
        Ok(contenders.iter().map(|_| runs.by_ref().take(seeds.len()).collect()).collect())
    }
}

impl Scene {
    /// A shipped file by its name, or one that nobody knows.
    fn of(usual: &Usual, file: PathBuf) -> Self {
        let is_named = |(name, _): &&(&str, _)| file.file_stem().is_some_and(|stem| stem == *name);
        let base = usual.scenes.iter().find(is_named).map(|(_, base)| *base).unwrap_or_default();
        Self { file, base }
    }

    /// The swarm of a row and a seed: read anew, since whatever is generated follows from both.
    pub(crate) fn load(&self, set: &[&str], seed: u64) -> anyhow::Result<Swarm> {
        let seed = format!("seed={seed}");
        let all = self.base.iter().chain(set).copied().chain([seed.as_str()]);
        load(&self.file, all).with_context(|| format!("{}, {seed}", self.file.display()))
    }

    /// The file's name without its ending.
    pub(crate) fn name(&self) -> String {
        self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// A swarm's file with overrides, the last of which counts.
pub(crate) fn load<'s>(file: &Path, set: impl IntoIterator<Item = &'s str>) -> anyhow::Result<Swarm> {
    let set: Result<Vec<Override>, _> = set.into_iter().map(Override::parse).collect();
    let set = set.map_err(|problem| anyhow::anyhow!("{problem}"))?;
    load_swarm(file, &set).map_err(anyhow::Error::new)
}

/// A thread pool of one: the cost of a decision is that of one thread.
pub(crate) fn one_thread() -> anyhow::Result<rayon::ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(1).build()?)
}
