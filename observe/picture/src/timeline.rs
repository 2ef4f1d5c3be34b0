//! When supervisors changed what was asked for, and why.

use crate::axis::{Axis, extent};
use crate::colour::{self, FAINT, GRID};
use crate::paper::{self, Drawn, FINE, Sheet, line, pen, polygon};
use crate::plot::{Axes, BELOW, BESIDE, Key, Plane, legend};
use crate::{Figure, HEIGHT, Intervention, PictureError, Run, WIDTH, words};
use plotters::style::{Color, RGBColor};
use std::collections::BTreeMap;

/// More reasons than this share one colour.
const REASONS_APART: usize = 6;
/// Ticks nearer to each other than this are one bar, s.
const TOGETHER_S: f64 = 0.15;

pub(crate) fn figure(run: &Run) -> Result<Figure, PictureError> {
    let title = "What the supervisors changed";
    let caption = "A row a robot. Each mark is a tick whose command was not what the law had asked for, coloured by \
                   the supervisor's reason; marks of successive ticks make a bar. The legend counts the ticks.";
    Ok(Figure { name: "interventions", title, caption, svg: draw(run, title)? })
}

fn draw(run: &Run, title: &str) -> Result<String, PictureError> {
    let conditions = words::conditions(run);
    let seen: Vec<&Intervention> = run.interventions.iter().filter(|seen| seen.time_s.is_finite()).collect();
    let times = run.moments.iter().map(|moment| moment.time_s).chain(seen.iter().map(|seen| seen.time_s));
    let Some(times) = extent(times).filter(|_| !seen.is_empty()) else {
        return paper::nothing(title, &conditions, "the supervisors changed no command");
    };
    let reasons = reasons(&seen);
    let rows = rows(run, &seen);
    paper::svg(title, |sheet| {
        let top = paper::head(sheet, title, &conditions)?;
        let named: Vec<(Key, String)> = reasons
            .iter()
            .enumerate()
            .map(|(at, (reason, count))| (Key::Patch(colour_of(at)), format!("{reason} ({count})")))
            .collect();
        let top = legend(sheet, top, &named)? + 16;
        let bottom = HEIGHT as i32 - 12 - BELOW;
        let names: Vec<String> = rows.iter().map(|id| id.to_string()).collect();
        let axes = Axes {
            x: Axis::tight(times, 10),
            y: Axis::rows(&names, ((bottom - top) / 20).max(1) as usize),
            x_label: "time (s)",
            y_label: "robot",
            grid: false,
        };
        let plane = Plane::draw(sheet, [BESIDE + 12, top, WIDTH as i32 - 36, bottom], axes)?;
        for (row, id) in rows.iter().enumerate() {
            let own: Vec<&Intervention> = seen.iter().copied().filter(|seen| seen.robot == *id).collect();
            draw_row(sheet, &plane, (row, &own), &reasons)?;
        }
        Ok(())
    })
}

/// Reasons with the number of their ticks, the most frequent first; the rare ones in one.
fn reasons(seen: &[&Intervention]) -> Vec<(String, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for seen in seen {
        *counts.entry(seen.reason.as_str()).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> =
        counts.into_iter().map(|(reason, count)| (reason.to_owned(), count)).collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    if counts.len() > REASONS_APART {
        let rare = counts.split_off(REASONS_APART - 1);
        let ticks = rare.iter().map(|(_, count)| count).sum();
        counts.push((format!("{} other reasons", rare.len()), ticks));
    }
    counts
}

fn colour_of(reason: usize) -> RGBColor {
    if reason + 1 == REASONS_APART { FAINT } else { colour::look(reason).0 }
}

/// The setting's robots, and then those that only the interventions know.
fn rows(run: &Run, seen: &[&Intervention]) -> Vec<u32> {
    let mut rows: Vec<u32> = run.setting.robots.iter().map(|robot| robot.id).collect();
    for seen in seen {
        if !rows.contains(&seen.robot) {
            rows.push(seen.robot);
        }
    }
    rows
}

/// A row: a lane a reason, so that no reason hides another.
fn draw_row(sheet: &Sheet, plane: &Plane, row: (usize, &[&Intervention]), reasons: &[(String, usize)]) -> Drawn {
    let (row, own) = row;
    let [left, _, right, _] = plane.frame();
    let middle = -(row as f64);
    let height = plane.at([0.0, middle]).1;
    let border = plane.at([0.0, middle - 0.5]).1;
    // Between rows that are hardly thicker than a line, lines are all that would be seen.
    if border - height > 5 * FINE {
        line(sheet, vec![(left * FINE, border), (right * FINE, border)], pen(GRID, 1.0))?;
    }
    let (top, bottom) = (plane.at([0.0, middle + 0.42]).1, plane.at([0.0, middle - 0.42]).1);
    let lanes = reasons.len().max(1) as i32;
    // Lanes that would be too thin to see are one on top of the other.
    let apart = (bottom - top) / lanes >= 3 * FINE;
    for (reason, (words, _)) in reasons.iter().enumerate() {
        let last = reason + 1 == REASONS_APART;
        let is_this = |seen: &&&Intervention| {
            seen.reason == *words || (last && !reasons.iter().any(|(named, _)| *named == seen.reason))
        };
        let times: Vec<f64> = own.iter().filter(is_this).map(|seen| seen.time_s).collect();
        let lane = reason as i32;
        let (from, to) = if apart {
            (top + (bottom - top) * lane / lanes, top + (bottom - top) * (lane + 1) / lanes)
        } else {
            (top, bottom)
        };
        for [first, last] in bars(times) {
            let (west, east) = (plane.at([first, middle]).0, plane.at([last, middle]).0.max(0));
            let (west, east) = if east - west < 2 * FINE { (west - FINE, west + FINE) } else { (west, east) };
            let corners = vec![(west, from), (east, from), (east, to), (west, to)];
            polygon(sheet, corners, colour_of(reason).filled())?;
        }
    }
    Ok(())
}

/// From when to when ticks follow each other closely.
fn bars(mut times: Vec<f64>) -> Vec<[f64; 2]> {
    times.sort_by(f64::total_cmp);
    let mut bars: Vec<[f64; 2]> = Vec::new();
    for time_s in times {
        match bars.last_mut() {
            Some(bar) if time_s - bar[1] <= TOGETHER_S => bar[1] = time_s,
            _ => bars.push([time_s, time_s]),
        }
    }
    bars
}
