//! What pictures and the report say about a run.

use crate::Run;
use drover_record::Source;

/// Words without what XML cannot hold.
pub(crate) fn plain(words: &str) -> String {
    words.chars().map(|letter| if is_plain(letter) { letter } else { ' ' }).collect()
}

fn is_plain(letter: char) -> bool {
    !letter.is_control() && letter != '\u{fffe}' && letter != '\u{ffff}'
}

/// Words for an attribute.
pub(crate) fn escaped(words: &str) -> String {
    let mut safe = String::with_capacity(words.len());
    for letter in plain(words).chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            letter => safe.push(letter),
        }
    }
    safe
}

pub(crate) fn source(run: &Run) -> &'static str {
    match run.setting.source {
        Source::Simulation => "simulation",
        Source::Field => "field",
    }
}

/// What the run was, in a line.
pub(crate) fn conditions(run: &Run) -> String {
    let setting = &run.setting;
    let mut parts = Vec::new();
    if !setting.swarm.is_empty() {
        parts.push(format!("swarm {}", setting.swarm));
    }
    if !setting.behaviour.is_empty() {
        parts.push(setting.behaviour.clone());
    }
    let robots = setting.robots.len();
    parts.push(format!("{robots} robot{}", if robots == 1 { "" } else { "s" }));
    // In the field nothing is drawn from the seed.
    if setting.source == Source::Simulation {
        parts.push(format!("seed {}", setting.seed));
    }
    parts.push(source(run).to_owned());
    parts.join("  ·  ")
}

/// From a key of a document to words and a unit: "min_gap_robot_m" is "min gap robot" in "m".
pub(crate) fn quantity(key: &str) -> (String, &'static str) {
    const UNITS: [(&str, &str); 14] = [
        ("_mps2", "m/s²"),
        ("_radps", "rad/s"),
        ("_mps", "m/s"),
        ("_m2", "m²"),
        ("_deg", "°"),
        ("_rad", "rad"),
        ("_bytes", "bytes"),
        ("_pct", "%"),
        ("_hz", "Hz"),
        ("_ms", "ms"),
        ("_us", "µs"),
        ("_ns", "ns"),
        ("_s", "s"),
        ("_m", "m"),
    ];
    // A qualifier may stand behind the unit: "gap_m_min".
    for (suffix, unit) in UNITS {
        if let Some(name) = key.strip_suffix(suffix) {
            return (name.replace('_', " "), unit);
        }
        for qualifier in ["_min", "_max", "_mean"] {
            if let Some(name) = key.strip_suffix(qualifier).and_then(|key| key.strip_suffix(suffix)) {
                return (format!("{}{}", name, qualifier).replace('_', " "), unit);
            }
        }
    }
    (key.replace('_', " "), "")
}
