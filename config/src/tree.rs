//! Text as a tree in which every value knows its place.

use crate::guard;
use crate::path::{KeyPath, Step};
use crate::report::Report;
use crate::source::At;
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) at: At,
    /// The value as it is written, shortened: what a problem shows.
    pub(crate) text: String,
    pub(crate) value: Value,
}

/// What a value is.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Table(Fields),
    Array(Vec<Node>),
    String(String),
    /// `None`: too large for any number of ours.
    Integer(Option<i128>),
    Float(f64),
    Bool(bool),
    Date,
}

/// The keys of a table, each with its value.
pub(crate) type Fields = BTreeMap<String, Field>;

/// One key of a table.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    /// Where the key stands.
    pub(crate) key_at: At,
    pub(crate) node: Node,
}

impl Node {
    /// An empty table at `at`.
    pub(crate) fn empty_table(at: At) -> Self {
        Self { at, text: "a table".to_owned(), value: Value::Table(Fields::new()) }
    }

    /// The keys, if this is a table.
    pub(crate) fn fields(&self) -> Option<&Fields> {
        match &self.value {
            Value::Table(fields) => Some(fields),
            Value::Array(_) | Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
                None
            }
        }
    }

    /// The same, to change them.
    pub(crate) fn fields_mut(&mut self) -> Option<&mut Fields> {
        match &mut self.value {
            Value::Table(fields) => Some(fields),
            Value::Array(_) | Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
                None
            }
        }
    }

    /// The elements, if this is an array.
    pub(crate) fn items(&self) -> Option<&[Self]> {
        match &self.value {
            Value::Array(items) => Some(items),
            Value::Table(_) | Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
                None
            }
        }
    }

    /// The value of `key`, if this is a table that has it.
    pub(crate) fn get(&self, key: &str) -> Option<&Self> {
        self.fields()?.get(key).map(|field| &field.node)
    }

    /// The node at `path`, or the nearest above it that there is.
    pub(crate) fn nearest(&self, path: &KeyPath) -> &Self {
        let mut node = self;
        for step in &path.0 {
            match node.child(step) {
                Some(child) => node = child,
                None => return node,
            }
        }
        node
    }

    /// Whether the file says anything at `path`.
    pub(crate) fn has(&self, path: &str) -> bool {
        let steps = KeyPath::parse(path).map(|path| path.0).unwrap_or_default();
        steps.iter().try_fold(self, |node, step| node.child(step)).is_some()
    }

    fn child(&self, step: &Step) -> Option<&Self> {
        match step {
            Step::Key(key) => self.get(key),
            Step::Index(index) => self.items()?.get(*index),
        }
    }

    /// What a problem calls this.
    pub(crate) fn shown(&self) -> String {
        match &self.value {
            Value::Table(_) => "a table".to_owned(),
            Value::Array(items) => format!("a list of {}", items.len()),
            Value::String(text) => shorten(&format!("{text:?}")),
            Value::Date => format!("the date {}", self.text),
            Value::Integer(_) | Value::Float(_) | Value::Bool(_) => self.text.clone(),
        }
    }
}

/// At most 60 characters of `text`.
pub(crate) fn shorten(text: &str) -> String {
    const SHOWN_MAX: usize = 60;
    match text.char_indices().nth(SHOWN_MAX) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// The tree of source `source`; syntax errors go to `report` and leave out what they spoil.
pub(crate) fn parse_document(report: &mut Report, source: usize) -> Node {
    let root_at = At { source, offset: 0 };
    let text = report.source(source).text().to_owned();
    if let Some(allowed) = guard::too_much(&text) {
        report.too_much(root_at, allowed);
        return Node::empty_table(root_at);
    }
    if let Some(offset) = guard::too_deep_document(&text) {
        report.too_deep(At { source, offset });
        return Node::empty_table(root_at);
    }
    let (table, errors) = DeTable::parse_recoverable(&text);
    for error in errors {
        let offset = error.span().map_or(text.len(), |span| span.start);
        report.syntax(At { source, offset }, error.message());
    }
    let fields = convert_table(report, root_at, table.get_ref());
    Node { at: root_at, text: String::new(), value: Value::Table(fields) }
}

/// An override's value: TOML if it is some, else the bare string. `offset` is where it starts in its source.
pub(crate) fn parse_override_value(report: &mut Report, source: usize, offset: usize) -> Node {
    let at = At { source, offset };
    let written = report.source(source).text().get(offset..).unwrap_or_default();
    let text = written.trim().to_owned();
    let start = At { source, offset: offset + (written.len() - written.trim_start().len()) };
    if guard::too_deep_value(&text).is_some() {
        report.too_deep(at);
        return Node::empty_table(at);
    }
    match DeValue::parse(&text) {
        Ok(value) => {
            let mut node = convert(report, start, &value);
            node.text = shorten(&text);
            node
        }
        Err(_) => Node { at, text: shorten(&text), value: Value::String(text) },
    }
}

/// `start` is where the parsed text begins.
fn convert_table(report: &Report, start: At, table: &DeTable<'_>) -> Fields {
    let fields = table.iter().map(|(key, value)| {
        let key_at = At { source: start.source, offset: start.offset + key.span().start };
        (key.get_ref().to_string(), Field { key_at, node: convert(report, start, value) })
    });
    fields.collect()
}

/// Recursive: the guard bounds the depth.
fn convert(report: &Report, start: At, value: &Spanned<DeValue<'_>>) -> Node {
    let span = value.span();
    let converted = match value.get_ref() {
        DeValue::Table(table) => Value::Table(convert_table(report, start, table)),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| convert(report, start, item)).collect()),
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(integer) => Value::Integer(integer_value(integer)),
        DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::INFINITY)),
        DeValue::Boolean(truth) => Value::Bool(*truth),
        DeValue::Datetime(_) => Value::Date,
    };
    let at = At { source: start.source, offset: start.offset + span.start };
    let text = shorten(report.source(at.source).slice(at.offset, start.offset + span.end));
    Node { at, text, value: converted }
}

fn integer_value(integer: &DeInteger<'_>) -> Option<i128> {
    i128::from_str_radix(integer.as_str(), integer.radix()).ok()
}
