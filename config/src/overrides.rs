//! `--set KEY=VALUE`: changes the tree before anything is checked, so that an override is checked like the file.

use crate::path::{KeyPath, Step};
use crate::problem::Problem;
use crate::report::{Report, Words};
use crate::source::{At, Source};
use crate::tree::{self, Field, Node, Value};

/// One override of one key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    path: KeyPath,
    text: String,
    value_offset: usize,
}

impl Override {
    /// `KEY=VALUE`. The key is dotted, with indices (`robot[2].start.x_m`) or a robot's id (`robots.3.start.x_m`). The
    /// value is TOML if it can be read as such, else it is text: `record_dir=/tmp/x` needs no quotes.
    ///
    /// # Errors
    /// [`Problem`] if there is no `=` or the key is not of that form. Whether there is such a key is said when the
    /// configuration is read.
    #[expect(clippy::result_large_err, reason = "made once a flag, before anything runs")]
    pub fn parse(text: &str) -> Result<Self, Problem> {
        let problem = |found: String, expected: &str, advice: &str| Problem {
            file: format!("--set {text}"),
            line: None,
            column: None,
            key: String::new(),
            found,
            expected: expected.to_owned(),
            advice: advice.to_owned(),
        };
        let Some((key, _)) = text.split_once('=') else {
            return Err(problem("no '='".to_owned(), "KEY=VALUE", "write it like behaviour.leader_speed_mps=0.5"));
        };
        let Some(path) = KeyPath::parse(key) else {
            let found = format!("the key {:?}", tree::shorten(key.trim()));
            let expected = "names joined by dots, each perhaps with an index";
            return Err(problem(found, expected, "write it like robot[2].start.x_m or robots.3.start.x_m"));
        };
        Ok(Self { path, text: text.to_owned(), value_offset: key.len() + 1 })
    }

    /// Whether this names a file to include, and so must act before files are included.
    pub(crate) fn names_file(&self) -> bool {
        let keys: Option<Vec<&str>> = self.path.0.iter().map(key_of).collect();
        let Some(keys) = keys else { return false };
        matches!(keys.as_slice(), ["world"] | ["world", "file"] | ["kinds", _] | ["kinds", _, "file"] | ["kind"])
            || keys == ["kind", "file"]
    }

    /// Sets the value in `root`, or says why it cannot be.
    pub(crate) fn apply(&self, report: &mut Report, root: &mut Node) {
        let source = report.add(Source::set(&self.text));
        let node = tree::parse_override_value(report, source, self.value_offset);
        let at = At { source, offset: 0 };
        let path = match by_index(&self.path, root) {
            Ok(path) => path,
            Err(words) => return report.push(at, &self.path.to_string(), words),
        };
        if let Err(words) = set(root, &path.0, node, at) {
            report.push(at, &self.path.to_string(), words);
        }
    }
}

fn key_of(step: &Step) -> Option<&str> {
    match step {
        Step::Key(key) => Some(key),
        Step::Index(_) => None,
    }
}

/// `robots.3.x` as `robot[i].x`, where robot `i` has the id 3.
fn by_index(path: &KeyPath, root: &Node) -> Result<KeyPath, Words> {
    let [Step::Key(first), Step::Key(id), rest @ ..] = path.0.as_slice() else { return Ok(path.clone()) };
    if first != "robots" {
        return Ok(path.clone());
    }
    let robots = root.get("robot").and_then(Node::items).unwrap_or_default();
    let has_id = |robot: &Node| match robot.get("id").map(|node| &node.value) {
        Some(Value::Integer(Some(value))) => value.to_string() == *id,
        Some(_) | None => false,
    };
    let Some(index) = robots.iter().position(has_id) else {
        let expected = format!("the id of one of the {} robots", robots.len());
        return Err(Words::new(format!("robot id {id}"), expected, "use an id that the swarm has"));
    };
    let steps = [Step::Key("robot".to_owned()), Step::Index(index)];
    Ok(KeyPath(steps.into_iter().chain(rest.iter().cloned()).collect()))
}

/// Sets the node at `path`; tables on the way are made: whether anybody reads them is said later.
fn set(root: &mut Node, path: &[Step], value: Node, at: At) -> Result<(), Words> {
    let mut node = root;
    for step in path {
        node = descend(node, step, at)?;
    }
    *node = value;
    Ok(())
}

fn descend<'n>(node: &'n mut Node, step: &Step, at: At) -> Result<&'n mut Node, Words> {
    let shown = node.shown();
    match (step, &mut node.value) {
        (Step::Key(key), Value::Table(fields)) => {
            let field = fields.entry(key.clone()).or_insert_with(|| Field { key_at: at, node: Node::empty_table(at) });
            field.key_at = at;
            Ok(&mut field.node)
        }
        (Step::Index(index), Value::Array(items)) => {
            let count = items.len();
            let words = || {
                let expected = format!("an index below {count}");
                Words::new(format!("[{index}]"), expected, "use an index that is there; a new one goes into the file")
            };
            items.get_mut(*index).ok_or_else(words)
        }
        (Step::Key(key), Value::Array(_)) => {
            let advice = format!("write an index before '{key}', as in robot[0].{key}");
            Err(Words::new(format!("'.{key}' after {shown}"), "an index", advice))
        }
        (Step::Key(key), _) => {
            Err(Words::new(format!("'.{key}' after {shown}"), "no key below a plain value", "set the value itself"))
        }
        (Step::Index(index), _) => {
            Err(Words::new(format!("[{index}] after {shown}"), "no index: it is not a list", "leave the index out"))
        }
    }
}
