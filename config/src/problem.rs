//! What is wrong with a configuration: where, what was found, what is allowed, what to do.

use serde::Serialize;
use std::fmt;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// The file; `--set KEY=VALUE` for an override.
    pub file: String,
    /// Line, from 1; none for a file as a whole and for an override.
    pub line: Option<u32>,
    /// Column in characters, from 1.
    pub column: Option<u32>,
    /// The key, as `--set` says it; empty for a file as a whole.
    pub key: String,
    /// What stands there.
    pub found: String,
    /// What may stand there.
    pub expected: String,
    /// What to do.
    pub advice: String,
}

impl fmt::Display for Problem {
    /// `path:line:col: key 'k': found X; allowed: Y; do: Z`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let (Some(line), Some(column)) = (self.line, self.column) {
            write!(f, ":{line}:{column}")?;
        }
        if !self.key.is_empty() {
            write!(f, ": key '{}'", self.key)?;
        }
        write!(f, ": found {}; allowed: {}; do: {}", self.found, self.expected, self.advice)
    }
}

impl std::error::Error for Problem {}

/// Everything that is wrong, ordered by file, line and column. Never empty.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// `found`, ordered, each said once, and how many `more` there are. Files keep the order in which they were met.
    pub(crate) fn new(mut found: Vec<Problem>, more: usize, files: &[&str]) -> Self {
        let place = |problem: &Problem| files.iter().position(|file| *file == problem.file);
        found.sort_by_cached_key(|problem| (place(problem), problem.line, problem.column, problem.key.clone()));
        found.dedup();
        if let Some(last) = found.last_mut().filter(|_| more > 0) {
            last.advice.push_str(&format!(" (and {more} more problems)"));
        }
        Self(found)
    }

    /// The problems, one after the other.
    pub fn iter(&self) -> std::slice::Iter<'_, Problem> {
        self.0.iter()
    }
}

impl IntoIterator for Problems {
    type Item = Problem;
    type IntoIter = std::vec::IntoIter<Problem>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Problems {
    type Item = &'a Problem;
    type IntoIter = std::slice::Iter<'a, Problem>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self(vec![problem])
    }
}

impl fmt::Display for Problems {
    /// One problem a line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            fmt::Display::fmt(problem, f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}
