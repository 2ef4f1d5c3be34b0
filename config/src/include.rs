//! Files that a file names: kinds and worlds take the place of their names before anything is checked.

use crate::path::join;
use crate::report::{KeyDoc, Report, Words};
use crate::source::{At, Source, read_text};
use crate::tree::{self, Fields, Node, Value};
use std::path::Path;

/// Most kinds of one swarm: each may be a file of its own.
pub(crate) const KINDS_MAX: usize = 100;

/// Reads the file that the user named; `None` (and a problem) if it cannot be read.
pub(crate) fn read_root(report: &mut Report, path: &Path) -> Option<Node> {
    match read_text(path) {
        Ok(text) => {
            let source = report.add(Source::file(path, text));
            Some(tree::parse_document(report, source))
        }
        Err(error) => {
            let source = Source::file(path, String::new());
            let name = source.name.clone();
            report.add(source);
            report.push_file(&name, Words::new(error.found, error.expected, error.advice));
            None
        }
    }
}

/// Puts the files of a swarm's world and kinds in their places.
pub(crate) fn expand_swarm(report: &mut Report, root: &mut Node) {
    let doc = |allowed: &str, default: Option<&str>| KeyDoc {
        allowed: allowed.to_owned(),
        default: default.map(str::to_owned),
    };
    report.accept("kinds.NAME.file", || doc("the path of a file", Some("none")));
    report.accept("world.file", || doc("the path of a file", Some("none")));
    report.accept("world", || doc("a table or the path of a file", None));
    let Some(fields) = root.fields_mut() else { return };
    if let Some(world) = fields.get_mut("world") {
        expand(report, &mut world.node, "world");
    }
    let kinds = fields.get_mut("kinds").and_then(|field| field.node.fields_mut());
    for (name, field) in kinds.into_iter().flatten().take(KINDS_MAX) {
        if expand(report, &mut field.node, &join("kinds", name))
            && let Some(kind) = field.node.fields_mut()
        {
            kind.remove("name"); // a swarm's own name for a kind counts: two of its kinds may share a file
        }
    }
}

/// Puts the file of a robot's kind in its place.
pub(crate) fn expand_robot_file(report: &mut Report, root: &mut Node) {
    if let Some(kind) = root.fields_mut().and_then(|fields| fields.get_mut("kind")) {
        expand(report, &mut kind.node, "kind");
    }
}

/// `"FILE"` or `{ file = "FILE", ... }` becomes the file's tree, with the keys beside `file` laid over it.
/// Whether a file was named.
fn expand(report: &mut Report, node: &mut Node, key: &str) -> bool {
    let Some((file, at)) = named_file(node) else { return false };
    let path = report.source(at.source).folder.join(&file);
    let mut base = match read_text(&path) {
        Ok(text) => {
            let source = report.add(Source::file(&path, text));
            tree::parse_document(report, source)
        }
        Err(error) => {
            let found = format!("{file:?}, which is {}", error.found);
            report.push(at, key, Words::new(found, error.expected, format!("{} ({})", error.advice, path.display())));
            // What the file would have said is not missing: it could not be read.
            let mut unread = Source::file(&path, String::new());
            unread.mark_broken(0);
            Node::empty_table(At { source: report.add(unread), offset: 0 })
        }
    };
    if let Some(over) = node.fields_mut() {
        over.remove("file");
        lay_over(&mut base, std::mem::take(over));
    }
    *node = base;
    true
}

fn named_file(node: &Node) -> Option<(String, At)> {
    let file = node.get("file").unwrap_or(node);
    match &file.value {
        Value::String(path) if !path.contains('\0') => Some((path.clone(), file.at)),
        Value::String(_) | Value::Table(_) | Value::Array(_) | Value::Integer(_) => None,
        Value::Float(_) | Value::Bool(_) | Value::Date => None,
    }
}

/// Keys of `over` replace those of `base`; tables are merged. A table with another `protocol` replaces the whole
/// table, whose other keys belong to the protocol that went. Recursive: the guard bounds the depth.
fn lay_over(base: &mut Node, over: Fields) {
    let Some(fields) = base.fields_mut() else { return };
    for (key, mut field) in over {
        match fields.get_mut(&key) {
            Some(old) if merges(&old.node, &field.node) => {
                if let Some(inner) = field.node.fields_mut() {
                    lay_over(&mut old.node, std::mem::take(inner));
                }
            }
            Some(_) | None => {
                fields.insert(key, field);
            }
        }
    }
}

fn merges(old: &Node, new: &Node) -> bool {
    let protocol = |node: &Node| match node.get("protocol").map(|node| &node.value) {
        Some(Value::String(protocol)) => Some(protocol.clone()),
        Some(_) | None => None,
    };
    let changes = protocol(new).is_some_and(|new| protocol(old).is_some_and(|old| old != new));
    old.fields().is_some() && new.fields().is_some() && !changes
}
