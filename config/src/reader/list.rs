//! Lists: of tables, of points; and tables by names that the file chooses.

use super::rule::NAME_LEN_MAX;
use super::{NAME, Table, read_table};
use crate::include::KINDS_MAX;
use crate::path::join;
use crate::report::Words;
use crate::tree::{Node, Value};
use std::ops::RangeInclusive;

/// Farthest coordinate, metres: a world is a site, not a country, and f64 keeps micrometres there.
pub(crate) const COORDINATE_M_MAX: f64 = 10_000.0;

const POINT: &str = "a point [x, y] with both in -10000..=10000";

impl<'r> Table<'r> {
    /// A list of at most `count_max` tables: those that are right, each with its index. Not there: empty.
    pub(crate) fn tables<T>(
        &mut self,
        key: &'static str,
        count_max: usize,
        mut read: impl FnMut(&mut Table<'_>) -> Option<T>,
    ) -> Option<Vec<(usize, T)>> {
        let Some(items) = self.list(key, &format!("a list of at most {count_max} tables"), count_max, true) else {
            return (!self.has(key)).then(Vec::new);
        };
        let (path, shape) = (join(&self.path, key), format!("{}[]", join(&self.shape, key)));
        let mut values = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let place = (format!("{path}[{index}]"), shape.as_str());
            let value = read_table(self.report, item, (&place.0, place.1), &mut read);
            values.extend(value.map(|value| (index, value)));
        }
        Some(values)
    }

    /// Tables by names that the file chooses: those that are right.
    pub(crate) fn named_tables<T>(
        &mut self,
        key: &'static str,
        mut read: impl FnMut(&str, &mut Table<'_>) -> Option<T>,
    ) -> Option<Vec<(String, T)>> {
        let node = self.scalar(key, "a table of tables by name", None)?;
        let (path, shape) = (join(&self.path, key), format!("{}.NAME", join(&self.shape, key)));
        let Some(fields) = node.fields() else {
            self.wrong(key, node, "a table of tables by name", "write [kinds.NAME]");
            return None;
        };
        if fields.len() > KINDS_MAX {
            let allowed = format!("at most {KINDS_MAX} tables");
            let words = Words::new(format!("{} tables", fields.len()), allowed, "leave some out");
            self.report.push(node.at, &path, words);
            return None;
        }
        let mut values = Vec::new();
        for (name, field) in fields {
            if !crate::path::is_bare_key(name) || name.len() > NAME_LEN_MAX {
                let words = Words::new(format!("{name:?}"), NAME.allowed, NAME.advice);
                self.report.push(field.key_at, &path, words);
                continue;
            }
            let place = join(&path, name);
            let value = read_table(self.report, &field.node, (&place, &shape), |table| read(name, table));
            values.extend(value.map(|value| (name.clone(), value)));
        }
        Some(values)
    }

    /// A list of `count` points `[x, y]`, metres.
    pub(crate) fn points(&mut self, key: &'static str, count: RangeInclusive<usize>) -> Option<Vec<[f64; 2]>> {
        let allowed = format!("a list of {}..={} points [x, y]", count.start(), count.end());
        let items = self.list(key, &allowed, *count.end(), false)?;
        if items.len() < *count.start() {
            let node = &self.fields.get(key)?.node;
            self.wrong(key, node, &allowed, "add points");
            return None;
        }
        let path = join(&self.path, key);
        let points: Vec<_> =
            items.iter().enumerate().map(|(index, item)| self.point_of(item, &format!("{path}[{index}]"))).collect();
        points.into_iter().collect()
    }

    /// The same list; not there: empty.
    pub(crate) fn optional_points(&mut self, key: &'static str, count: RangeInclusive<usize>) -> Option<Vec<[f64; 2]>> {
        self.optional(key, &format!("a list of {}..={} points [x, y]", count.start(), count.end()), "none");
        if self.has(key) { self.points(key, count) } else { Some(Vec::new()) }
    }

    /// Two points, the south-west and the north-east corner of a rectangle, metres; it may be absent:
    /// `otherwise` says what counts then.
    pub(crate) fn optional_region(&mut self, key: &'static str, otherwise: &str) -> Option<Option<[[f64; 2]; 2]>> {
        const ALLOWED: &str = "two points [[x_min, y_min], [x_max, y_max]]";
        self.optional(key, ALLOWED, otherwise);
        let Some(node) = self.fields.get(key).map(|field| &field.node) else { return Some(None) };
        let Some([low, high]) = node.items() else {
            self.wrong(key, node, ALLOWED, "write the south-west corner and the north-east one");
            return None;
        };
        let path = join(&self.path, key);
        let (low, high) = (self.point_of(low, &format!("{path}[0]")), self.point_of(high, &format!("{path}[1]")));
        let (low, high) = (low?, high?);
        if low[0] < high[0] && low[1] < high[1] {
            return Some(Some([low, high]));
        }
        self.problem(key, Words::new(node.text.clone(), format!("{ALLOWED}, each min below its max"), "swap them?"));
        None
    }

    /// A list of 1 to `count_max` ids of robots.
    pub(crate) fn ids(&mut self, key: &'static str, count_max: usize) -> Option<Vec<u32>> {
        let allowed = format!("a list of 1..={count_max} ids of robots");
        let items = self.list(key, &allowed, count_max, false)?;
        if items.is_empty() {
            let node = &self.fields.get(key)?.node;
            self.wrong(key, node, &allowed, "add ids");
            return None;
        }
        let path = join(&self.path, key);
        let mut ids = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            match id_of(item) {
                Some(id) => ids.push(id),
                None => {
                    let words = Words::new(item.shown(), "a whole number in 1..=4294967295", "write a robot's id");
                    self.report.push(item.at, &format!("{path}[{index}]"), words);
                }
            }
        }
        (ids.len() == items.len()).then_some(ids)
    }

    /// A point `[x, y]`, metres.
    pub(crate) fn point(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let node = self.scalar(key, POINT, None)?;
        let path = join(&self.path, key);
        self.point_of(node, &path)
    }

    fn point_of(&mut self, node: &Node, path: &str) -> Option<[f64; 2]> {
        let coordinate = |node: &Node| match &node.value {
            Value::Float(value) => Some(*value),
            Value::Integer(value) => value.map(|value| value as f64),
            Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Bool(_) | Value::Date => None,
        };
        let point = match node.items() {
            Some([x, y]) => coordinate(x).zip(coordinate(y)),
            Some(_) | None => None,
        };
        match point {
            Some((x_m, y_m)) if x_m.abs() <= COORDINATE_M_MAX && y_m.abs() <= COORDINATE_M_MAX => Some([x_m, y_m]),
            Some(_) | None => {
                let found = match node.items() {
                    Some(_) => node.text.clone(),
                    None => node.shown(),
                };
                self.report.push(node.at, path, Words::new(found, POINT, "write two finite numbers, metres"));
                None
            }
        }
    }

    fn list(&mut self, key: &'static str, allowed: &str, count_max: usize, optional: bool) -> Option<&'r [Node]> {
        let default = optional.then(|| "none".to_owned());
        let node = self.scalar(key, allowed, default)?;
        match node.items() {
            Some(items) if items.len() <= count_max => Some(items),
            Some(_) => {
                self.wrong(key, node, allowed, "leave some out");
                None
            }
            None => {
                self.wrong(key, node, allowed, "write a list");
                None
            }
        }
    }
}

fn id_of(node: &Node) -> Option<u32> {
    match &node.value {
        Value::Integer(Some(value)) => u32::try_from(*value).ok().filter(|id| *id > 0),
        Value::Integer(None) | Value::Float(_) | Value::Table(_) | Value::Array(_) => None,
        Value::String(_) | Value::Bool(_) | Value::Date => None,
    }
}
