//! Pictures of a run, and a report around them.
//!
//! Every picture is drawn once, as SVG; its PNG is a rendering of that SVG, so both show the same. Nothing depends on
//! the fonts of the machine: text is measured, and rendered in PNGs, with a font that is part of the program.

mod axis;
mod chart;
mod colour;
mod measures;
mod paper;
mod plot;
mod report;
mod timeline;
mod trajectories;
mod words;

pub use chart::{Chart, Rule, Series};
pub use report::report;

use drover_record::{Moment, Setting};

/// Width of a PNG, pixels.
pub const WIDTH: u32 = 1280;
/// Height of a PNG, pixels.
pub const HEIGHT: u32 = 800;

/// A run as it was recorded.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// What did not change.
    pub setting: Setting,
    /// What was seen, about ten times a second, in the order of time.
    pub moments: Vec<Moment>,
    /// What the supervisors changed.
    pub interventions: Vec<Intervention>,
    /// The run's summary document, if there is one.
    pub summary: Option<serde_json::Value>,
    /// What the report is called.
    pub title: String,
}

/// A tick whose command the supervisor changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Intervention {
    /// When, s since the run began.
    pub time_s: f64,
    /// Whose supervisor.
    pub robot: u32,
    /// Why, in words.
    pub reason: String,
}

/// A picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Stem of the name of a file for it.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// The picture as an SVG document; text in the reader's sans-serif.
    pub svg: String,
    /// The same as a PNG file of [`WIDTH`] by [`HEIGHT`] pixels.
    pub png: Vec<u8>,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The drawing library refused.
    #[error("cannot draw: {0}")]
    Draw(String),
    /// The SVG could not be turned into a PNG.
    #[error("cannot render the PNG: {0}")]
    Render(String),
}

/// A picture that is drawn, but not rendered.
struct Figure {
    name: &'static str,
    title: &'static str,
    caption: &'static str,
    svg: String,
}

/// Every picture of a run: where the robots went, gaps, connectivity, coverage, velocity order, speeds, interventions.
///
/// What there is no data for is a picture that says so and why.
///
/// # Errors
/// The drawing library refuses, or the PNG cannot be rendered; not for anything that a run can hold.
pub fn pictures(run: &Run) -> Result<Vec<Picture>, PictureError> {
    figures(run, &measures::Measures::of(run))?
        .into_iter()
        .map(|figure| {
            let png = paper::png(&figure.svg)?;
            Ok(Picture { name: figure.name, title: figure.title.to_owned(), svg: figure.svg, png })
        })
        .collect()
}

fn figures(run: &Run, measures: &measures::Measures) -> Result<Vec<Figure>, PictureError> {
    let mut figures = vec![trajectories::figure(run)?];
    figures.extend(measures::figures(run, measures)?);
    figures.push(timeline::figure(run)?);
    Ok(figures)
}

#[cfg(test)]
mod tests;
