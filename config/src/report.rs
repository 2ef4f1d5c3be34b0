//! Collects problems, and every key that is read, while a configuration is checked.

use crate::guard;
use crate::path::KeyPath;
use crate::problem::{Problem, Problems};
use crate::source::{At, Source};
use crate::suggest::nearest;
use crate::tree::{Node, shorten};
use std::collections::BTreeMap;

/// What a key may hold, for documentation and for suggestions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KeyDoc {
    /// The values that it may have.
    pub(crate) allowed: String,
    /// What holds if it is not there; none: it must be.
    pub(crate) default: Option<String>,
}

/// The words of a problem: found, allowed, what to do.
pub(crate) struct Words {
    pub(crate) found: String,
    pub(crate) expected: String,
    pub(crate) advice: String,
}

impl Words {
    /// The three, in this order.
    pub(crate) fn new(found: impl Into<String>, expected: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { found: found.into(), expected: expected.into(), advice: advice.into() }
    }
}

/// Most problems that are kept: a hostile file could make a million.
const PROBLEMS_MAX: usize = 1_000;

/// The sources that were read and what was found in them.
#[derive(Debug, Default)]
pub(crate) struct Report {
    sources: Vec<Source>,
    problems: Vec<Problem>,
    /// Problems beyond those that are kept.
    more: usize,
    /// Problems of unknown keys for which no neighbour was near: the whole tree is searched at the end.
    unknown: Vec<(usize, String)>,
    accepted: BTreeMap<String, KeyDoc>,
}

impl Report {
    /// Adds a source; its index.
    pub(crate) fn add(&mut self, source: Source) -> usize {
        self.sources.push(source);
        self.sources.len() - 1
    }

    /// A source that was added.
    pub(crate) fn source(&self, index: usize) -> &Source {
        &self.sources[index]
    }

    /// Whether nothing is wrong so far.
    pub(crate) fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    /// Every key that was read, in its general form (`robot[].start.x_m`, `kinds.NAME.motion`).
    #[cfg(test)]
    pub(crate) fn accepted(&self) -> &BTreeMap<String, KeyDoc> {
        &self.accepted
    }

    /// Remembers a key that may stand in a configuration.
    pub(crate) fn accept(&mut self, shape: &str, doc: impl FnOnce() -> KeyDoc) {
        if !self.accepted.contains_key(shape) {
            self.accepted.insert(shape.to_owned(), doc());
        }
    }

    /// A problem at `at`. On a line with a syntax error it would only be an echo, and is left out.
    pub(crate) fn push(&mut self, at: At, key: &str, words: Words) {
        if !self.source(at.source).is_broken_at(at.offset) {
            self.keep(at, key, words);
        }
    }

    /// A problem with the value that `root` has at `path`, or with the table that lacks it.
    pub(crate) fn push_path(&mut self, root: &Node, path: &str, words: Words) {
        let at = KeyPath::parse(path).map_or(root.at, |steps| root.nearest(&steps).at);
        self.push(at, path, words);
    }

    /// A problem with a file as a whole, named at `at` (or nowhere, if the user named it).
    pub(crate) fn push_file(&mut self, file: &str, words: Words) {
        let Words { found, expected, advice } = words;
        let file = file.to_owned();
        self.store(Problem { file, line: None, column: None, key: String::new(), found, expected, advice });
    }

    /// A key is missing in the table at `at`. A syntax error in the same file may have hidden it: then nothing is said.
    pub(crate) fn missing(&mut self, at: At, key: &str, expected: &str) {
        if !self.source(at.source).is_broken() {
            let leaf = key.rsplit('.').next().unwrap_or(key);
            self.push(at, key, Words::new("nothing", expected, format!("add {leaf}; it has no default")));
        }
    }

    /// A key that nobody reads; `known` are its neighbours that somebody does.
    pub(crate) fn unknown_key(&mut self, at: At, key: &str, known: &[&str]) {
        if self.source(at.source).is_broken_at(at.offset) {
            return;
        }
        if self.is_full() {
            self.more += 1; // looking for its neighbours would take long, for nobody
            return;
        }
        let leaf = key.rsplit('.').next().unwrap_or(key);
        let advice = match nearest(leaf, known.iter().copied()) {
            Some(near) => format!("did you mean '{near}'?"),
            None => {
                self.unknown.push((self.problems.len(), leaf.to_owned()));
                "remove it".to_owned()
            }
        };
        let expected = shorten_list(known);
        self.keep(at, key, Words::new("an unknown key", expected, advice));
    }

    /// A syntax error; the parser's words.
    pub(crate) fn syntax(&mut self, at: At, message: &str) {
        self.sources[at.source].mark_broken(at.offset);
        if self.is_full() {
            self.more += 1;
            return;
        }
        let text = self.source(at.source);
        let rest = text.slice(at.offset, text.text().len()).lines().next().unwrap_or_default().trim();
        let found = if rest.is_empty() { "the end of the line".to_owned() } else { format!("`{}`", shorten(rest)) };
        let words = if message.contains("duplicate key") {
            Words::new(found, "each key once", "remove one of the two")
        } else {
            let message = message.lines().collect::<Vec<_>>().join(", ");
            Words::new(found, format!("TOML ({message})"), "correct the syntax")
        };
        self.keep(at, "", words);
    }

    /// Nesting that no configuration has.
    pub(crate) fn too_deep(&mut self, at: At) {
        let words = Words::new("deeper nesting", guard::depth_allowed(), "remove it; no key lies that deep");
        self.sources[at.source].mark_broken(at.offset);
        self.keep(at, "", words);
    }

    /// More values than any configuration has.
    pub(crate) fn too_much(&mut self, at: At, allowed: String) {
        let advice = "is it the right file? No swarm of 100,000 robots needs more";
        self.sources[at.source].mark_broken(at.offset);
        self.keep(at, "", Words::new("too many values", allowed, advice));
    }

    /// `value` if nothing is wrong, else everything that is.
    pub(crate) fn finish<T>(mut self, value: Option<T>) -> Result<T, Problems> {
        self.suggest_from_whole_tree();
        let files: Vec<&str> = self.sources.iter().map(|source| source.name.as_str()).collect();
        match value {
            Some(value) if self.problems.is_empty() => Ok(value),
            Some(_) | None => Err(Problems::new(self.problems, self.more, &files)),
        }
    }

    /// Whether more problems are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.problems.len() >= PROBLEMS_MAX
    }

    fn store(&mut self, problem: Problem) {
        if self.is_full() {
            self.more += 1;
        } else {
            self.problems.push(problem);
        }
    }

    fn keep(&mut self, at: At, key: &str, words: Words) {
        let source = self.source(at.source);
        let (line, column) = source.position(at.offset).unzip();
        let Words { found, expected, advice } = words;
        self.store(Problem { file: source.name.clone(), line, column, key: key.to_owned(), found, expected, advice });
    }

    /// A key in the wrong table is common: its right place is named.
    fn suggest_from_whole_tree(&mut self) {
        for (index, leaf) in std::mem::take(&mut self.unknown) {
            let leaves = self.accepted.keys().map(|shape| shape.rsplit('.').next().unwrap_or(shape));
            let Some(near) = nearest(&leaf, leaves) else { continue };
            let suffix = format!(".{near}");
            let whole = self.accepted.keys().find(|shape| *shape == near || shape.ends_with(&suffix));
            if let (Some(whole), Some(problem)) = (whole, self.problems.get_mut(index)) {
                problem.advice = format!("did you mean '{whole}'?");
            }
        }
    }
}

fn shorten_list(words: &[&str]) -> String {
    match words {
        [] => "no key".to_owned(),
        words => format!("one of {}", words.join(", ")),
    }
}
