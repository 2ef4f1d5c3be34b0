//! `drover check FILE...`: everything that is wrong, before anything moves.

use crate::exit::Exit;
use drover_config::check_file;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `drover check`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Swarm, robot, robot kind or world files
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Print one JSON document on stdout: a list of {file, kind, problems}
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Row {
    file: PathBuf,
    kind: Option<&'static str>,
    problems: Vec<drover_config::Problem>,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let rows: Vec<Row> = arguments.files.iter().map(|file| look_at(file.clone())).collect();
    let wrong = rows.iter().any(|row| !row.problems.is_empty());
    if arguments.json {
        // Only strings and numbers: this cannot fail to print.
        println!("{}", serde_json::to_string_pretty(&rows).unwrap_or_default());
    } else {
        rows.iter().for_each(print);
    }
    if wrong { Exit::BadInput } else { Exit::Reached }
}

fn look_at(file: PathBuf) -> Row {
    match check_file(&file) {
        Ok(checked) => Row { file, kind: Some(checked.kind_name()), problems: Vec::new() },
        Err(problems) => Row { file, kind: None, problems: problems.0 },
    }
}

fn print(row: &Row) {
    let file = row.file.display();
    match row.kind {
        Some(kind) => println!("{file}: {kind}: good"),
        None => {
            row.problems.iter().for_each(|problem| println!("{problem}"));
            println!("{file}: {} problem(s)", row.problems.len());
        }
    }
}
