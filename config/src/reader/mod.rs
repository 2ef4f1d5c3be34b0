//! Reads tables key by key: every key that is asked for is known, every other key is a problem.

use crate::path::join;
use crate::report::{KeyDoc, Report, Words};
use crate::source::At;
use crate::tree::{Field, Fields, Node, Value};

mod list;
mod rule;
mod scalar;

pub(crate) use list::COORDINATE_M_MAX;
pub(crate) use rule::{FILE, FOLDER, IPV4, IPV4_GROUP, NAME, TextRule};

/// A table that is being read.
pub(crate) struct Table<'r> {
    report: &'r mut Report,
    fields: &'r Fields,
    at: At,
    /// As `--set` says it: `robot[2].start`.
    path: String,
    /// With indices and names left out: `robot[].start`.
    shape: String,
    known: Vec<&'static str>,
    /// The word that says which keys belong here is wrong: no key can be called unknown.
    undecided: bool,
}

/// Reads `node`, which is to be a table; whatever `read` did not ask for is an unknown key.
pub(crate) fn read_table<T>(
    report: &mut Report,
    node: &Node,
    (path, shape): (&str, &str),
    read: impl FnOnce(&mut Table<'_>) -> Option<T>,
) -> Option<T> {
    let Some(fields) = node.fields() else {
        report.push(node.at, path, Words::new(node.shown(), "a table", "write it as a table: { key = value }"));
        return None;
    };
    let (path, shape) = (path.to_owned(), shape.to_owned());
    let mut table = Table { report, fields, at: node.at, path, shape, known: Vec::new(), undecided: false };
    let value = read(&mut table);
    table.report_unknown();
    value
}

impl<'r> Table<'r> {
    /// A table that must be there.
    pub(crate) fn table<T>(&mut self, key: &'static str, read: impl FnOnce(&mut Table<'_>) -> Option<T>) -> Option<T> {
        let node = self.scalar(key, "a table", None)?;
        read_table(self.report, node, (&join(&self.path, key), &join(&self.shape, key)), read)
    }

    /// A table all of whose keys have defaults: not there, it is read as empty.
    pub(crate) fn section<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Table<'_>) -> Option<T>,
    ) -> Option<T> {
        let empty = Node::empty_table(self.at);
        let node = match self.fields.get(key) {
            Some(field) => &field.node,
            None => &empty,
        };
        self.optional(key, "a table", "its defaults");
        read_table(self.report, node, (&join(&self.path, key), &join(&self.shape, key)), read)
    }

    /// A table that may be absent altogether. Outer `None`: it is there and wrong.
    pub(crate) fn optional_table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Table<'_>) -> Option<T>,
    ) -> Option<Option<T>> {
        self.optional(key, "a table", "none");
        if self.has(key) { self.table(key, read).map(Some) } else { Some(None) }
    }

    /// A table that may be absent and may be given as the file that its key `file` would name.
    pub(crate) fn optional_file_table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Table<'_>) -> Option<T>,
    ) -> Option<Option<T>> {
        self.optional(key, "a table or the path of a file", "none");
        let Some(field) = self.fields.get(key) else { return Some(None) };
        let place = (join(&self.path, key), join(&self.shape, key));
        let mut named = Node::empty_table(field.node.at);
        let node = match (&field.node.value, named.fields_mut()) {
            (Value::String(_), Some(fields)) => {
                fields.insert("file".to_owned(), Field { key_at: field.key_at, node: field.node.clone() });
                &named
            }
            (Value::String(_) | Value::Table(_) | Value::Array(_) | Value::Integer(_), _)
            | (Value::Float(_) | Value::Bool(_) | Value::Date, _) => &field.node,
        };
        read_table(self.report, node, (&place.0, &place.1), read).map(Some)
    }

    /// The report, and the place of the value of `key` (of the table, if it is not there).
    pub(crate) fn report_at(&mut self, key: &str) -> (&mut Report, At) {
        let at = self.fields.get(key).map_or(self.at, |field| field.node.at);
        (self.report, at)
    }

    /// A problem with `key` of this table.
    pub(crate) fn problem(&mut self, key: &str, words: Words) {
        let at = self.fields.get(key).map_or(self.at, |field| field.node.at);
        self.report.push(at, &join(&self.path, key), words);
    }

    /// A key that must be there, but for one that may stand in its place, is not; `expected` says both.
    pub(crate) fn missing(&mut self, key: &str, expected: &str) {
        self.report.missing(self.at, &join(&self.path, key), expected);
    }

    /// A key that need not be there is known all the same.
    fn optional(&mut self, key: &'static str, allowed: &str, default: &str) {
        self.know(key, allowed, Some(default.to_owned()));
    }

    fn know(&mut self, key: &'static str, allowed: &str, default: Option<String>) {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.report.accept(&join(&self.shape, key), || KeyDoc { allowed: allowed.to_owned(), default });
    }

    /// Whether `key` is there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.fields.contains_key(key)
    }

    /// This table's key, as `--set` says it.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// The value of `key`; `None` if it is not there: without a default it is then missing.
    fn scalar(&mut self, key: &'static str, allowed: &str, default: Option<String>) -> Option<&'r Node> {
        let required = default.is_none();
        self.know(key, allowed, default);
        let fields: &'r Fields = self.fields;
        let node = fields.get(key).map(|field| &field.node);
        if node.is_none() && required {
            self.report.missing(self.at, &join(&self.path, key), allowed);
        }
        node
    }

    fn wrong(&mut self, key: &str, node: &Node, allowed: &str, advice: &str) {
        self.report.push(node.at, &join(&self.path, key), Words::new(node.shown(), allowed, advice));
    }

    fn report_unknown(&mut self) {
        for (key, field) in self.fields {
            if !self.undecided && !self.known.contains(&key.as_str()) {
                let shown = crate::tree::shorten(&key.escape_debug().to_string());
                self.report.unknown_key(field.key_at, &join(&self.path, &shown), &self.known);
            }
        }
    }
}
