//! Where text comes from: files and overrides, and which line an offset is in.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Greatest configuration file, bytes. A resolved swarm of 100,000 robots takes about 22 MB.
pub(crate) const FILE_BYTES_MAX: u64 = 32 << 20;

/// A place in one of the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct At {
    /// Index of the source.
    pub(crate) source: usize,
    /// Bytes from its start.
    pub(crate) offset: usize,
}

/// One file or one override.
#[derive(Debug)]
pub(crate) struct Source {
    /// As problems name it.
    pub(crate) name: String,
    /// Folder that paths in it are relative to; an override's are relative to the current folder.
    pub(crate) folder: PathBuf,
    text: String,
    /// Where each line begins; none for an override, which has no lines.
    line_starts: Option<Vec<usize>>,
    /// Lines with a syntax error: what else is found there would only repeat it.
    broken_lines: BTreeSet<u32>,
}

impl Source {
    /// A file's text.
    pub(crate) fn file(path: &Path, text: String) -> Self {
        let starts = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        let line_starts = Some(std::iter::once(0).chain(starts).collect());
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Self { name: path.display().to_string(), folder, text, line_starts, broken_lines: BTreeSet::new() }
    }

    /// An override, `KEY=VALUE`.
    pub(crate) fn set(text: &str) -> Self {
        Self {
            name: format!("--set {text}"),
            folder: PathBuf::new(),
            text: text.to_owned(),
            line_starts: None,
            broken_lines: BTreeSet::new(),
        }
    }

    /// Line and column, from 1, columns in characters; none in an override.
    pub(crate) fn position(&self, offset: usize) -> Option<(u32, u32)> {
        let starts = self.line_starts.as_ref()?;
        let line = starts.partition_point(|start| *start <= offset);
        let start = starts.get(line.checked_sub(1)?)?;
        let before = self.text.as_bytes().get(*start..offset.min(self.text.len()))?;
        let column = before.iter().filter(|byte| (**byte & 0xC0) != 0x80).count() + 1;
        Some((u32::try_from(line).ok()?, u32::try_from(column).ok()?))
    }

    /// The text from `start` to `end`, as it stands there.
    pub(crate) fn slice(&self, start: usize, end: usize) -> &str {
        self.text.get(start..end).unwrap_or_default()
    }

    /// The whole text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Remembers that the line at `offset` has a syntax error.
    pub(crate) fn mark_broken(&mut self, offset: usize) {
        self.broken_lines.extend(self.position(offset).map(|(line, _)| line));
    }

    /// Whether any line has a syntax error.
    pub(crate) fn is_broken(&self) -> bool {
        !self.broken_lines.is_empty()
    }

    /// Whether the line at `offset` has a syntax error.
    pub(crate) fn is_broken_at(&self, offset: usize) -> bool {
        self.position(offset).is_some_and(|(line, _)| self.broken_lines.contains(&line))
    }
}

/// Why a file could not be read: what was found, what is allowed, what to do.
pub(crate) struct Unreadable {
    pub(crate) found: String,
    pub(crate) expected: String,
    pub(crate) advice: String,
}

impl Unreadable {
    fn new(found: String, expected: &str, advice: &str) -> Self {
        Self { found, expected: expected.to_owned(), advice: advice.to_owned() }
    }
}

/// The text of a configuration file. Never more than [`FILE_BYTES_MAX`] are read, whatever the file is.
pub(crate) fn read_text(path: &Path) -> Result<String, Unreadable> {
    read_text_up_to(path, FILE_BYTES_MAX)
}

/// The text of a file of at most `bytes_max` bytes.
pub(crate) fn read_text_up_to(path: &Path, bytes_max: u64) -> Result<String, Unreadable> {
    let denied = |error: std::io::Error| {
        Unreadable::new(format!("no readable file ({error})"), "a readable file", "check the path and its permissions")
    };
    let meta = std::fs::metadata(path).map_err(denied)?;
    if !meta.is_file() {
        let what = if meta.is_dir() { "a folder" } else { "a device or pipe" };
        return Err(Unreadable::new(what.to_owned(), "a regular file", "name a TOML file"));
    }
    let too_long = |length: u64| {
        let advice = "is it the right file? No swarm of 100,000 robots needs more";
        Unreadable::new(format!("a file of {length} bytes"), &format!("at most {bytes_max} bytes"), advice)
    };
    if meta.len() > bytes_max {
        return Err(too_long(meta.len()));
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(bytes_max + 1).read_to_end(&mut bytes)).map_err(denied)?;
    if bytes.len() as u64 > bytes_max {
        return Err(too_long(bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        Unreadable::new(
            format!("bytes that are not UTF-8 (first at byte {at}, in line {line})"),
            "UTF-8 text",
            "save the file as UTF-8",
        )
    })
}
