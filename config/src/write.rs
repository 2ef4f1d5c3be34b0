//! From values back to text: everything resolved, nothing left to a default or to another file.

use crate::{RobotFile, Swarm};
use serde::Serialize;

impl Swarm {
    /// The whole swarm in one file that [`load_swarm`](crate::load_swarm) reads back to an equal value.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // TOML's own integers end at 2^63 - 1, our seeds at 2^64 - 1: the seed is written by hand.
        let mut table = table_of(&Self { seed: 0, ..self.clone() });
        table.remove("seed");
        if let Some(robots) = table.remove("robots") {
            table.insert("robot".to_owned(), robots);
        }
        format!("seed = {}\n{}", self.seed, text_of(&table))
    }
}

impl RobotFile {
    /// The file that `drover run` reads: [`load_robot`](crate::load_robot) gives back an equal value.
    #[must_use]
    pub fn to_toml(&self) -> String {
        text_of(&table_of(self))
    }
}

/// Our types are tables, lists, text, truth and numbers below 2^63, and every table's keys are text: this cannot fail,
/// and if it did, an empty file would be refused by whoever reads it.
fn table_of(value: &impl Serialize) -> toml::Table {
    toml::Table::try_from(value).unwrap_or_default()
}

fn text_of(table: &toml::Table) -> String {
    toml::to_string(table).unwrap_or_default()
}
