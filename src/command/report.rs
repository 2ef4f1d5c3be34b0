//! `drover report RUN.mcap`: one page with the summary of a recorded run and its pictures.

use crate::command::plot::with_run;
use crate::exit::Exit;
use anyhow::Context;
use drover_picture::report;
use std::path::PathBuf;

/// Arguments of `drover report`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The recording
    file: PathBuf,
    /// The page to write; beside the recording unless given
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let page = arguments.to.clone().unwrap_or_else(|| arguments.file.with_extension("html"));
    with_run(&arguments.file, |run| {
        std::fs::write(&page, report(run)?).with_context(|| format!("cannot write {}", page.display()))?;
        println!("{}", page.display());
        Ok(())
    })
}
