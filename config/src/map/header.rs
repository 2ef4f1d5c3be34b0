//! The YAML half of a map.

use crate::reader::COORDINATE_M_MAX;
use crate::report::{Report, Words};
use crate::source::At;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_saphyr::options::NonFiniteFloatPolicy;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::RangeInclusive;

/// What a map's YAML file says. Keys that map_server does not read are ignored, as it does.
#[derive(Debug)]
pub(crate) struct Header {
    pub(crate) image: String,
    pub(crate) resolution_m: f64,
    pub(crate) origin_m: [f64; 2],
    pub(crate) origin_yaw_rad: f64,
    pub(crate) occupied_thresh: f64,
    pub(crate) free_thresh: f64,
    pub(crate) negate: bool,
    pub(crate) mode: Mode,
}

/// How a pixel is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Free, occupied or unknown; transparency counts as one more colour.
    Trinary,
    /// In between there are shades; what is not opaque is unknown.
    Scale,
}

impl Header {
    /// Reads source `source`; `None`, and problems, if it is wrong.
    pub(crate) fn read(report: &mut Report, source: usize) -> Option<Self> {
        let text = report.source(source).text().to_owned();
        // A number that is none is refused by its key, like every other value.
        let options = serde_saphyr::options! { non_finite_float_policy: NonFiniteFloatPolicy::PassThrough };
        let fields: BTreeMap<String, Yaml> = match serde_saphyr::from_str_with_options(&text, options) {
            Ok(fields) => fields,
            Err(error) => {
                let line = error.location().and_then(|at| usize::try_from(at.line()).ok()).unwrap_or(1);
                let offset = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
                let said = error.without_snippet().to_string();
                let found = crate::tree::shorten(said.lines().next().unwrap_or("no YAML"));
                let expected = "YAML with image, resolution, origin, occupied_thresh, free_thresh, negate";
                report.push(At { source, offset }, "", Words::new(found, expected, "name a map that map_server reads"));
                return None;
            }
        };
        let mut keys = Keys { report, source, fields };
        let image = keys.text("image");
        let resolution_m = keys.number("resolution", 0.001..=100.0);
        let origin = keys.origin();
        let occupied_thresh = keys.number("occupied_thresh", 0.0..=1.0);
        let free_thresh = keys.number("free_thresh", 0.0..=1.0);
        let negate = keys.negate();
        let mode = keys.mode();
        let (occupied_thresh, free_thresh) = (occupied_thresh?, free_thresh?);
        if free_thresh > occupied_thresh {
            let allowed = format!("at most occupied_thresh, {occupied_thresh}");
            keys.problem("free_thresh", Words::new(free_thresh.to_string(), allowed, "swap them?"));
            return None;
        }
        let [x_m, y_m, origin_yaw_rad] = origin?;
        Some(Self {
            image: image?,
            resolution_m: resolution_m?,
            origin_m: [x_m, y_m],
            origin_yaw_rad,
            occupied_thresh,
            free_thresh,
            negate: negate?,
            mode: mode?,
        })
    }

    /// A problem with what stands behind `key`.
    pub(crate) fn problem(&self, report: &mut Report, source: usize, key: &str, words: Words) {
        let offset = offset_of(report.source(source).text(), key);
        report.push(At { source, offset }, key, words);
    }
}

/// Where the line of a top-level key begins.
fn offset_of(text: &str, key: &str) -> usize {
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        if line.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(':')) {
            return offset;
        }
        offset += line.len();
    }
    0
}

/// The keys of a YAML file, each with its value.
struct Keys<'r> {
    report: &'r mut Report,
    source: usize,
    fields: BTreeMap<String, Yaml>,
}

impl Keys<'_> {
    fn problem(&mut self, key: &str, words: Words) {
        let offset = offset_of(self.report.source(self.source).text(), key);
        self.report.push(At { source: self.source, offset }, key, words);
    }

    /// The value of `key`, which must be there.
    fn required(&mut self, key: &str, allowed: &str) -> Option<Yaml> {
        let value = self.fields.get(key).cloned();
        if value.is_none() {
            self.problem(key, Words::new("nothing", allowed, format!("add {key}: map_server needs it")));
        }
        value
    }

    fn text(&mut self, key: &str) -> Option<String> {
        const ALLOWED: &str = "the path of a PGM or PNG image, relative to this file";
        match self.required(key, ALLOWED)? {
            Yaml::Text(text) if !text.is_empty() && !text.contains('\0') => Some(text),
            other => {
                self.problem(key, Words::new(other.shown(), ALLOWED, "name the image"));
                None
            }
        }
    }

    fn number(&mut self, key: &str, range: RangeInclusive<f64>) -> Option<f64> {
        let allowed = format!("a number in {}..={}", range.start(), range.end());
        match self.required(key, &allowed)? {
            Yaml::Number(value) if range.contains(&value) => Some(value),
            other => {
                self.problem(key, Words::new(other.shown(), allowed, "choose a number in that range"));
                None
            }
        }
    }

    fn origin(&mut self) -> Option<[f64; 3]> {
        let allowed = format!("[x, y, yaw] within {COORDINATE_M_MAX} m and a turn");
        let value = self.required("origin", &allowed)?;
        let numbers: Option<Vec<f64>> = match &value {
            Yaml::List(items) => items.iter().map(Yaml::number).collect(),
            Yaml::Bool(_) | Yaml::Number(_) | Yaml::Text(_) | Yaml::Other => None,
        };
        match numbers.as_deref() {
            Some([x_m, y_m, yaw_rad])
                if x_m.abs() <= COORDINATE_M_MAX
                    && y_m.abs() <= COORDINATE_M_MAX
                    && yaw_rad.abs() <= std::f64::consts::TAU =>
            {
                Some([*x_m, *y_m, *yaw_rad])
            }
            Some(_) | None => {
                let advice = "write the pose of the map's south-west corner: metres, metres, radians";
                self.problem("origin", Words::new(value.shown(), allowed, advice));
                None
            }
        }
    }

    fn negate(&mut self) -> Option<bool> {
        const ALLOWED: &str = "0 or 1";
        match self.required("negate", ALLOWED)? {
            Yaml::Bool(truth) => Some(truth),
            Yaml::Number(0.0) => Some(false),
            Yaml::Number(1.0) => Some(true),
            other => {
                self.problem("negate", Words::new(other.shown(), ALLOWED, "write 0 (dark is occupied) or 1"));
                None
            }
        }
    }

    fn mode(&mut self) -> Option<Mode> {
        let Some(value) = self.fields.get("mode").cloned() else { return Some(Mode::Trinary) };
        match &value {
            Yaml::Text(text) if text == "trinary" => return Some(Mode::Trinary),
            Yaml::Text(text) if text == "scale" => return Some(Mode::Scale),
            Yaml::Text(_) | Yaml::Bool(_) | Yaml::Number(_) | Yaml::List(_) | Yaml::Other => {}
        }
        let advice = "use trinary: raw pixels say costs, not what is an obstacle";
        self.problem("mode", Words::new(value.shown(), "trinary or scale", advice));
        None
    }
}

/// A value of a YAML file, as far as a map needs it.
#[derive(Clone, Debug)]
enum Yaml {
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Self>),
    /// Nothing, or a mapping.
    Other,
}

impl Yaml {
    fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Bool(_) | Self::Text(_) | Self::List(_) | Self::Other => None,
        }
    }

    fn shown(&self) -> String {
        match self {
            Self::Bool(truth) => truth.to_string(),
            Self::Number(value) => value.to_string(),
            Self::Text(text) => crate::tree::shorten(&format!("{text:?}")),
            Self::List(items) => {
                let shown: Vec<String> = items.iter().take(4).map(Self::shown).collect();
                crate::tree::shorten(&format!("[{}{}]", shown.join(", "), if items.len() > 4 { ", ..." } else { "" }))
            }
            Self::Other => "neither number, text nor list".to_owned(),
        }
    }
}

impl<'de> Deserialize<'de> for Yaml {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(YamlVisitor)
    }
}

struct YamlVisitor;

impl<'de> Visitor<'de> for YamlVisitor {
    type Value = Yaml;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, text or a list")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Yaml, E> {
        Ok(Yaml::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Yaml, E> {
        Ok(Yaml::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Yaml, E> {
        Ok(Yaml::Number(value as f64))
    }

    fn visit_i128<E>(self, value: i128) -> Result<Yaml, E> {
        Ok(Yaml::Number(value as f64))
    }

    fn visit_u128<E>(self, value: u128) -> Result<Yaml, E> {
        Ok(Yaml::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Yaml, E> {
        Ok(Yaml::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Yaml, E> {
        Ok(Yaml::Text(value.to_owned()))
    }

    fn visit_unit<E>(self) -> Result<Yaml, E> {
        Ok(Yaml::Other)
    }

    fn visit_none<E>(self) -> Result<Yaml, E> {
        Ok(Yaml::Other)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Yaml, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Yaml::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<Yaml, A::Error> {
        while fields.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Yaml::Other)
    }
}
