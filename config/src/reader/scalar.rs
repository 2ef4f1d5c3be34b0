//! Values of single keys: numbers, timeouts, text, words.

use super::{Table, TextRule};
use crate::suggest::nearest;
use crate::tree::{Node, Value};
use std::ops::RangeInclusive;

impl Table<'_> {
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
            None => return default,
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
        self.optional(key, &format!("a number in {}..={}", range.start(), range.end()), "none");
        if self.has(key) { self.number(key, range, None) } else { None }
    }

    /// A number that follows from others unless it is given; `default` says how. Outer `None`: it is there and wrong.
    pub(crate) fn derived_number(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        default: &str,
    ) -> Option<Option<f64>> {
        self.optional(key, &format!("a number in {}..={}", range.start(), range.end()), default);
        if self.has(key) { self.number(key, range, None).map(Some) } else { Some(None) }
    }

    /// A whole number that may be absent; `otherwise` says what counts then. Outer `None`: it is there and wrong.
    pub(crate) fn optional_integer(
        &mut self,
        key: &'static str,
        range: RangeInclusive<u64>,
        otherwise: &str,
    ) -> Option<Option<u64>> {
        self.optional(key, &format!("a whole number in {}..={}", range.start(), range.end()), otherwise);
        if self.has(key) { self.integer(key, range, None).map(Some) } else { Some(None) }
    }

    /// A timeout that may be absent, without a default.
    pub(crate) fn optional_timeout(&mut self, key: &'static str, range: RangeInclusive<u32>) -> Option<u32> {
        self.optional(key, &format!("a whole number in {}..={}", range.start(), range.end()), "none");
        if self.has(key) { self.timeout(key, range, None) } else { None }
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
        let zero = matches!(
            self.fields.get(key).map(|field| &field.node.value),
            Some(Value::Integer(Some(0))) | Some(Value::Float(0.0))
        );
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
            None => return default,
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
            None => return default,
        };
        match &node.value {
            Value::Bool(truth) => Some(*truth),
            Value::Table(_)
            | Value::Array(_)
            | Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Date => {
                self.wrong(key, node, allowed, "write true or false, without quotes");
                None
            }
        }
    }

    /// true or false, that follows from another key unless it is given; `shown` says how.
    pub(crate) fn derived_bool(&mut self, key: &'static str, default: bool, shown: &str) -> Option<bool> {
        self.optional(key, "true or false", shown);
        if self.has(key) { self.bool(key, None) } else { Some(default) }
    }

    /// Text that `rule` accepts; `default` if it is not there, missing without one.
    pub(crate) fn text(&mut self, key: &'static str, rule: &TextRule, default: Option<&str>) -> Option<String> {
        let shown = default.map(|value| format!("{value:?}"));
        let node = match self.scalar(key, rule.allowed, shown) {
            Some(node) => node,
            None => return default.map(str::to_owned),
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
        self.optional(key, rule.allowed, "none");
        if self.has(key) { self.text(key, rule, None) } else { None }
    }

    /// Text that follows from other keys unless it is given. `derived`: what follows, if those could be read.
    pub(crate) fn derived_text(
        &mut self,
        key: &'static str,
        rule: &TextRule,
        derived: Option<String>,
    ) -> Option<String> {
        self.optional(key, rule.allowed, "from the robot's id");
        if self.has(key) { self.text(key, rule, None) } else { derived }
    }

    /// One of `words`, which decides what other keys may stand here: its index.
    pub(crate) fn word(&mut self, key: &'static str, words: &[&str]) -> Option<usize> {
        let allowed = one_of(words);
        let node = self.scalar(key, &allowed, None);
        let found = match node.map(|node| &node.value) {
            Some(Value::String(text)) => text.as_str(),
            Some(_) | None => "",
        };
        let index = words.iter().position(|word| *word == found);
        self.undecided = index.is_none();
        if let (Some(node), None) = (node, index) {
            let near = nearest(found, words.iter().copied());
            let advice = near.map_or("choose one of them".to_owned(), |near| format!("did you mean \"{near}\"?"));
            self.wrong(key, node, &allowed, &advice);
        }
        index
    }

    /// One of `words`, the first of which is the default; no other key depends on it. Its index.
    pub(crate) fn choice(&mut self, key: &'static str, words: &[&str]) -> Option<usize> {
        let default = words.first().map(|word| format!("{word:?}"));
        self.derived_choice(key, words, (0, &default.unwrap_or_default()))
    }

    /// One of `words`, on which no other key depends; without it the one at `default`, of which `shown` says why. Its
    /// index.
    pub(crate) fn derived_choice(
        &mut self,
        key: &'static str,
        words: &[&str],
        (default, shown): (usize, &str),
    ) -> Option<usize> {
        self.optional(key, &one_of(words), shown);
        if !self.has(key) {
            return Some(default);
        }
        let undecided = self.undecided;
        let index = self.word(key, words);
        self.undecided = undecided;
        index
    }
}

fn one_of(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("{word:?}")).collect();
    format!("one of {}", quoted.join(", "))
}

fn number_advice(node: &Node) -> &'static str {
    match &node.value {
        Value::String(_) => "write the number without quotes",
        Value::Table(_) | Value::Array(_) | Value::Integer(_) | Value::Float(_) | Value::Bool(_) | Value::Date => {
            "write a number"
        }
    }
}
