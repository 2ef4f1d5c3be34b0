//! Reads tables key by key: every key that is asked for is known, every other key is a problem.

use crate::include::KINDS_MAX;
use crate::path::join;
use crate::report::{KeyDoc, Report, Words};
use crate::source::At;
use crate::tree::{Fields, Node, Value};
use std::ops::RangeInclusive;

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
    let mut table = Table { report, fields, at: node.at, path, shape, known: Vec::new() };
    let value = read(&mut table);
    table.report_unknown();
    value
}

impl<'r> Table<'r> {
    /// A number; `default` if it is not there, missing without one.
    pub(crate) fn number(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        default: Option<f64>,
    ) -> Option<f64> {
        let allowed = format!("a number in {}..={}", range.start(), range.end());
        let node = match self.scalar(key, &allowed, default.map(|value| value.to_string())) {
            Some(node) => node,
            None => return default.filter(|_| !self.fields.contains_key(key)),
        };
        let value = match &node.value {
            Value::Float(value) => Some(*value),
            Value::Integer(value) => value.map(|value| value as f64),
            Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Bool(_) | Value::Date => None,
        };
        match value {
            Some(value) if range.contains(&value) => return Some(value),
            Some(value) if !value.is_finite() => self.wrong(key, node, &allowed, "write a finite number"),
            Some(_) => self.wrong(key, node, &allowed, "choose a number in that range"),
            None => self.wrong(key, node, &allowed, number_advice(node)),
        }
        None
    }

    /// A number that may be absent, without a default.
    pub(crate) fn optional_number(&mut self, key: &'static str, range: RangeInclusive<f64>) -> Option<f64> {
        if self.fields.contains_key(key) {
            return self.number(key, range, None);
        }
        self.absent(key, &format!("a number in {}..={}", range.start(), range.end()), "none");
        None
    }

    /// A timeout that may be absent, without a default.
    pub(crate) fn optional_timeout(&mut self, key: &'static str, range: RangeInclusive<u32>) -> Option<u32> {
        if self.fields.contains_key(key) {
            return self.timeout(key, range, None);
        }
        self.absent(key, &format!("a whole number in {}..={}", range.start(), range.end()), "none");
        None
    }

    /// Whether `key` is there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.fields.contains_key(key)
    }

    /// A whole number; `default` if it is not there, missing without one.
    pub(crate) fn integer(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u64>,
        default: Option<u64>,
    ) -> Option<u64> {
        self.integer_advised(key, range, default, "choose a whole number in that range")
    }

    /// A whole number of 32 bits.
    pub(crate) fn integer_u32(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u32>,
        default: Option<u32>,
    ) -> Option<u32> {
        let range = u64::from(*range.start())..=u64::from(*range.end());
        self.integer(key, range, default.map(u64::from)).and_then(|value| u32::try_from(value).ok())
    }

    /// A whole number of 8 bits.
    pub(crate) fn integer_u8(&mut self, key: &'static str, range: RangeInclusive<u8>, default: u8) -> Option<u8> {
        let range = u64::from(*range.start())..=u64::from(*range.end());
        self.integer(key, range, Some(u64::from(default))).and_then(|value| u8::try_from(value).ok())
    }

    /// A port.
    pub(crate) fn integer_u16(&mut self, key: &'static str, range: RangeInclusive<u16>, default: u16) -> Option<u16> {
        let range = u64::from(*range.start())..=u64::from(*range.end());
        self.integer(key, range, Some(u64::from(default))).and_then(|value| u16::try_from(value).ok())
    }

    /// A time after which something counts as lost. 0 is refused with the reason.
    pub(crate) fn timeout(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u32>,
        default: Option<u32>,
    ) -> Option<u32> {
        let zero = matches!(self.fields.get(key).map(|field| &field.node.value),
            Some(Value::Integer(Some(0))) | Some(Value::Float(0.0)));
        let advice = if zero {
            "0 would mean never, and absent means stop: give the longest silence that is safe"
        } else {
            "choose a whole number in that range"
        };
        let range = u64::from(*range.start())..=u64::from(*range.end());
        let value = self.integer_advised(key, range, default.map(u64::from), advice);
        value.and_then(|value| u32::try_from(value).ok())
    }

    fn integer_advised(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u64>,
        default: Option<u64>,
        advice: &str,
    ) -> Option<u64> {
        let allowed = format!("a whole number in {}..={}", range.start(), range.end());
        let node = match self.scalar(key, &allowed, default.map(|value| value.to_string())) {
            Some(node) => node,
            None => return default.filter(|_| !self.fields.contains_key(key)),
        };
        match &node.value {
            Value::Integer(Some(value)) => match u64::try_from(*value) {
                Ok(value) if range.contains(&value) => return Some(value),
                Ok(_) | Err(_) => self.wrong(key, node, &allowed, advice),
            },
            Value::Integer(None) => self.wrong(key, node, &allowed, advice),
            Value::Float(_) => self.wrong(key, node, &allowed, "write it without a decimal point"),
            Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Bool(_) | Value::Date => {
                self.wrong(key, node, &allowed, number_advice(node));
            }
        }
        None
    }

    /// true or false.
    pub(crate) fn bool(&mut self, key: &'static str, default: Option<bool>) -> Option<bool> {
        let allowed = "true or false";
        let node = match self.scalar(key, allowed, default.map(|value| value.to_string())) {
            Some(node) => node,
            None => return default.filter(|_| !self.fields.contains_key(key)),
        };
        match &node.value {
            Value::Bool(truth) => Some(*truth),
            Value::Table(_) | Value::Array(_) | Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Date => {
                self.wrong(key, node, allowed, "write true or false, without quotes");
                None
            }
        }
    }

    /// Text that `rule` accepts; `default` if it is not there, missing without one.
    pub(crate) fn text(&mut self, key: &'static str, rule: &TextRule, default: Option<&str>) -> Option<String> {
        let shown = default.map(|value| format!("{value:?}"));
        let node = match self.scalar(key, rule.allowed, shown) {
            Some(node) => node,
            None => return default.filter(|_| !self.fields.contains_key(key)).map(str::to_owned),
        };
        match &node.value {
            Value::String(text) if (rule.accepts)(text) => return Some(text.clone()),
            Value::String(_) => self.wrong(key, node, rule.allowed, rule.advice),
            Value::Table(_) | Value::Array(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
                self.wrong(key, node, rule.allowed, "write it in quotes");
            }
        }
        None
    }

    /// Text that may be absent, without a default.
    pub(crate) fn optional_text(&mut self, key: &'static str, rule: &TextRule) -> Option<String> {
        if self.fields.contains_key(key) {
            return self.text(key, rule, None);
        }
        self.absent(key, rule.allowed, "none");
        None
    }

    /// Text that follows from other keys unless it is given. `derived`: what follows, if those could be read.
    pub(crate) fn derived_text(
        &mut self,
        key: &'static str,
        rule: &TextRule,
        derived: Option<String>,
    ) -> Option<String> {
        if self.has(key) {
            return self.text(key, rule, None);
        }
        self.absent(key, rule.allowed, "from the robot's id");
        derived
    }

    /// This table's key, as `--set` says it.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// One of `words`: its index.
    pub(crate) fn word(&mut self, key: &'static str, words: &[&str]) -> Option<usize> {
        let allowed = format!("one of {}", words.iter().map(|word| format!("{word:?}")).collect::<Vec<_>>().join(", "));
        let node = self.scalar(key, &allowed, None)?;
        let index = match &node.value {
            Value::String(text) => words.iter().position(|word| word == text),
            Value::Table(_) | Value::Array(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
                None
            }
        };
        if index.is_none() {
            let near = match &node.value {
                Value::String(text) => crate::suggest::nearest(text, words.iter().copied()),
                _ => None,
            };
            let advice = near.map_or("choose one of them".to_owned(), |near| format!("did you mean \"{near}\"?"));
            self.wrong(key, node, &allowed, &advice);
        }
        index
    }

    /// A table that must be there.
    pub(crate) fn table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Table<'_>) -> Option<T>,
    ) -> Option<T> {
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
        self.absent(key, "a table", "its defaults");
        read_table(self.report, node, (&join(&self.path, key), &join(&self.shape, key)), read)
    }

    /// A table that may be absent altogether. Outer `None`: it is there and wrong.
    pub(crate) fn optional_table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Table<'_>) -> Option<T>,
    ) -> Option<Option<T>> {
        if self.fields.contains_key(key) {
            return self.table(key, read).map(Some);
        }
        self.absent(key, "a table", "none");
        Some(None)
    }

    /// A list of at most `count_max` tables: those that are right, each with its index. Not there: empty.
    pub(crate) fn tables<T>(
        &mut self,
        key: &'static str,
        count_max: usize,
        mut read: impl FnMut(&mut Table<'_>) -> Option<T>,
    ) -> Option<Vec<(usize, T)>> {
        let Some(items) = self.list(key, &format!("a list of at most {count_max} tables"), count_max, true) else {
            return (!self.fields.contains_key(key)).then(Vec::new);
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
        let points: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(index, item)| self.point_of(item, &format!("{path}[{index}]")))
            .collect();
        points.into_iter().collect()
    }

    /// A point `[x, y]`, metres.
    pub(crate) fn point(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let node = self.scalar(key, POINT, None)?;
        let path = join(&self.path, key);
        self.point_of(node, &path)
    }

    /// A problem with `key` of this table.
    pub(crate) fn problem(&mut self, key: &str, words: Words) {
        let at = self.fields.get(key).map_or(self.at, |field| field.node.at);
        self.report.push(at, &join(&self.path, key), words);
    }

    /// A key that need not be there is known all the same.
    fn absent(&mut self, key: &'static str, allowed: &str, default: &str) {
        self.known.push(key);
        let doc = || KeyDoc { allowed: allowed.to_owned(), default: Some(default.to_owned()) };
        self.report.accept(&join(&self.shape, key), doc);
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

    /// The value of `key`; without one and without a default it is missing.
    fn scalar(&mut self, key: &'static str, allowed: &str, default: Option<String>) -> Option<&'r Node> {
        self.known.push(key);
        let required = default.is_none();
        self.report.accept(&join(&self.shape, key), || KeyDoc { allowed: allowed.to_owned(), default });
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
            if !self.known.contains(&key.as_str()) {
                let shown = crate::tree::shorten(&key.escape_debug().to_string());
                self.report.unknown_key(field.key_at, &join(&self.path, &shown), &self.known);
            }
        }
    }
}

/// Farthest coordinate, metres: a world is a site, not a country, and f64 keeps micrometres there.
pub(crate) const COORDINATE_M_MAX: f64 = 10_000.0;

const POINT: &str = "a point [x, y] with both in -10000..=10000";

const NAME_LEN_MAX: usize = 64;

/// What text may be.
pub(crate) struct TextRule {
    pub(crate) allowed: &'static str,
    pub(crate) advice: &'static str,
    pub(crate) accepts: fn(&str) -> bool,
}

/// A name: of a swarm, a kind, a world.
pub(crate) const NAME: TextRule = TextRule {
    allowed: "1 to 64 letters, digits, '_' or '-'",
    advice: "choose a name that a file could have",
    accepts: |text| crate::path::is_bare_key(text) && text.len() <= NAME_LEN_MAX,
};

/// A folder.
pub(crate) const FOLDER: TextRule = TextRule {
    allowed: "the path of a folder",
    advice: "name a folder; it is made if need be",
    accepts: |text| !text.is_empty() && text.len() <= 4_096 && !text.contains('\0'),
};

/// An IPv4 address.
pub(crate) const IPV4: TextRule = TextRule {
    allowed: "an IPv4 address",
    advice: "write four numbers with dots, such as \"127.0.0.1\"",
    accepts: |text| text.parse::<core::net::Ipv4Addr>().is_ok(),
};

/// An IPv4 multicast group.
pub(crate) const IPV4_GROUP: TextRule = TextRule {
    allowed: "an IPv4 multicast group in 224.0.0.0/4",
    advice: "choose one of the administratively scoped groups, such as \"239.255.77.1\"",
    accepts: |text| text.parse::<core::net::Ipv4Addr>().is_ok_and(|group| group.is_multicast()),
};

fn number_advice(node: &Node) -> &'static str {
    match &node.value {
        Value::String(_) => "write the number without quotes",
        Value::Table(_) | Value::Array(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
            "write a number"
        }
    }
}
