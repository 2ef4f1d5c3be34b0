//! A page that holds everything about a run, and needs nothing but itself.

use crate::measures::Measures;
use crate::{Figure, PictureError, Run, figures, words};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// What tells rows apart stands first.
const FIRST: [&str; 5] = ["id", "kind", "state", "reached", "reached_s"];

const STYLE: &str = include_str!("report.css");

/// A run as one HTML page: its conditions, what it came to, its pictures and what they mean.
///
/// The page loads nothing, runs nothing, follows the reader's choice of light or dark, and can be printed. All words
/// that come from the run are escaped.
///
/// # Errors
/// A picture cannot be drawn; not for anything that a run can hold.
pub fn report(run: &Run) -> Result<String, PictureError> {
    let measures = Measures::of(run);
    let figures = figures(run, &measures)?;
    let title = words::plain(if run.title.is_empty() { "A run of a swarm" } else { &run.title });
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    header { h1 { (title) } p.conditions { (words::plain(&words::conditions(run))) } }
                    div.columns {
                        section { h2 { "Conditions" } (conditions(run)) }
                        section { h2 { "Measured from the recording" } (results(run, &measures)) }
                    }
                    @if let Some(summary) = &run.summary { (summary_section(summary)) }
                    section {
                        h2 { "Pictures" }
                        @for (index, figure) in figures.iter().enumerate() { (picture(index + 1, figure)) }
                    }
                    footer { p { "Made by drover from the run's recording." } }
                }
            }
        }
    };
    Ok(page.into_string())
}

fn picture(number: usize, figure: &Figure) -> Markup {
    html! {
        figure id=(figure.name) {
            (PreEscaped(&figure.svg))
            figcaption { b { "Figure " (number) ". " (figure.title) ". " } (figure.caption) }
        }
    }
}

fn pairs<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> Markup {
    html! {
        table.pairs {
            tbody {
                @for (name, value) in rows {
                    tr { th scope="row" { (words::plain(name)) } td { (words::plain(&value)) } }
                }
            }
        }
    }
}

fn conditions(run: &Run) -> Markup {
    let setting = &run.setting;
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for robot in &setting.robots {
        *kinds.entry(robot.kind.as_str()).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.into_iter().map(|(kind, count)| format!("{count} × {kind}")).collect();
    let robots = match kinds.is_empty() {
        true => "0".to_owned(),
        false => format!("{} ({})", setting.robots.len(), kinds.join(", ")),
    };
    let seen = run.moments.first().zip(run.moments.last()).map(|(first, last)| last.time_s - first.time_s);
    pairs([
        ("swarm", named(&setting.swarm)),
        ("behaviour", named(&setting.behaviour)),
        ("robots", robots),
        ("place", named(&setting.place.name)),
        ("source", words::source(run).to_owned()),
        ("seed", setting.seed.to_string()),
        ("began", began(setting.started_unix_us)),
        ("at most", setting.duration_s.map_or("until somebody ends it".to_owned(), |limit_s| format!("{limit_s} s"))),
        ("recorded", seen.map_or("nothing".to_owned(), |seen_s| format!("{seen_s:.1} s"))),
    ])
}

fn named(name: &str) -> String {
    if name.is_empty() { "–".to_owned() } else { name.to_owned() }
}

fn began(unix_us: u64) -> String {
    let second = i64::try_from(unix_us / 1_000_000).ok().filter(|second| *second > 0);
    let moment = second.and_then(|second| OffsetDateTime::from_unix_timestamp(second).ok());
    moment.and_then(|moment| moment.format(&Rfc3339).ok()).unwrap_or_else(|| "–".to_owned())
}

fn results(run: &Run, measures: &Measures) -> Markup {
    let mut rows = measures.results();
    rows.push(("ticks whose command the supervisor changed", run.interventions.len().to_string()));
    pairs(rows)
}

/// The summary document: what is simple as pairs, every list of objects as a table.
fn summary_section(summary: &Value) -> Markup {
    let none = Map::new();
    let fields = summary.as_object().unwrap_or(&none);
    let is_table = |value: &Value| value.as_array().is_some_and(|rows| rows.iter().any(Value::is_object));
    let simple = fields.iter().filter(|(_, value)| !is_table(value));
    let rows: Vec<(String, String)> = simple.map(|(key, value)| pair(key, value)).collect();
    html! {
        section {
            h2 { "Summary" }
            @if rows.is_empty() { p { (said(summary)) } }
            (pairs(rows.iter().map(|(name, value)| (name.as_str(), value.clone()))))
        }
        @for (key, value) in fields.iter().filter(|(_, value)| is_table(value)) {
            section { h2 { (words::plain(&heading(key))) } (table(value.as_array().map_or(&[], Vec::as_slice))) }
        }
    }
}

fn heading(key: &str) -> String {
    let (name, _) = words::quantity(key);
    let mut letters = name.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}", letters.as_str())
}

fn pair(key: &str, value: &Value) -> (String, String) {
    let (name, unit) = words::quantity(key);
    let value = said(value);
    let unit = if value.starts_with('–') { "" } else { unit };
    (name, format!("{value} {unit}").trim_end().to_owned())
}

fn table(rows: &[Value]) -> Markup {
    let cells = rows.iter().filter_map(Value::as_object).flatten();
    // A column in which nothing stands is left out.
    let keys: BTreeSet<&String> = cells.filter(|(_, value)| !value.is_null()).map(|(key, _)| key).collect();
    let mut keys: Vec<&String> = keys.into_iter().collect();
    keys.sort_by_key(|key| FIRST.iter().position(|first| first == key).unwrap_or(FIRST.len()));
    html! {
        div.wide {
            table.many {
                thead { tr { @for key in &keys { (column(key)) } } }
                tbody {
                    @for row in rows {
                        tr { @for key in &keys { (cell(row.get(key.as_str()).unwrap_or(&Value::Null))) } }
                    }
                }
            }
        }
    }
}

fn column(key: &str) -> Markup {
    let (name, unit) = words::quantity(key);
    html! { th scope="col" { (words::plain(&name)) @if !unit.is_empty() { br; span.unit { "(" (unit) ")" } } } }
}

fn cell(value: &Value) -> Markup {
    let said = words::plain(&said(value));
    html! { @if value.is_number() { td.number { (said) } } @else { td { (said) } } }
}

/// A value in words.
fn said(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(value) => rounded(value),
            None => number.to_string(),
        },
        Value::String(words) => named(words),
        Value::Array(values) if values.is_empty() => "–".to_owned(),
        Value::Array(values) => values.iter().map(said).collect::<Vec<_>>().join(", "),
        Value::Object(fields) if fields.is_empty() => "–".to_owned(),
        Value::Object(fields) => {
            let field = |(key, value): (&String, &Value)| {
                let (name, value) = pair(key, value);
                format!("{name}: {value}")
            };
            fields.iter().map(field).collect::<Vec<_>>().join("; ")
        }
    }
}

/// Thousandths are enough for anybody who reads a table.
fn rounded(value: f64) -> String {
    if value.abs() >= 1e9 || (value.abs() < 5e-4 && value.abs() > 0.0) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
