//! Dotted keys: `robot[2].start.x_m`.

use std::fmt;

/// Longest key, in steps. The deepest real one has five.
const STEPS_MAX: usize = 16;

/// One step down the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Into a table.
    Key(String),
    /// Into an array.
    Index(usize),
}

/// A key from the root of the resolved tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KeyPath(pub(crate) Vec<Step>);

impl KeyPath {
    /// `a.b[2].c`; `None` if it is not of that form.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut steps = Vec::new();
        for part in text.trim().split('.') {
            let mut pieces = part.split('[');
            let name = pieces.next().unwrap_or_default();
            if !is_bare_key(name) {
                return None;
            }
            steps.push(Step::Key(name.to_owned()));
            for piece in pieces {
                steps.push(Step::Index(piece.strip_suffix(']')?.parse().ok()?));
            }
        }
        (steps.len() <= STEPS_MAX).then_some(Self(steps))
    }
}

/// Whether `text` can stand in TOML without quotes.
pub(crate) fn is_bare_key(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-')
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if index == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(at) => write!(f, "[{at}]")?,
            }
        }
        Ok(())
    }
}

/// `parent.key`, or `key` at the root.
pub(crate) fn join(parent: &str, key: &str) -> String {
    if parent.is_empty() { key.to_owned() } else { format!("{parent}.{key}") }
}
