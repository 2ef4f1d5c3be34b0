//! A chart of lines and points: what benches and runs are shown with.

use crate::axis::{Axis, extent};
use crate::plot::{Axes, BELOW, BESIDE, Frame, Key, Plane, legend};
use crate::{HEIGHT, PictureError, WIDTH, colour, paper};

/// A chart: series over a common x.
///
/// Numbers that are not finite, and on a logarithmic axis those that are not above 0, are left out: a line is broken
/// there. A chart without any number says "no data".
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Under what conditions; may be empty.
    pub subtitle: String,
    /// What is on the x axis, with its unit.
    pub x_label: String,
    /// What is on the y axis, with its unit.
    pub y_label: String,
    /// Whether x is logarithmic.
    pub x_log: bool,
    /// Whether y is logarithmic.
    pub y_log: bool,
    /// y goes at least from the first to the second; `None`: as far as the series. Not for a logarithmic axis.
    pub y_least: Option<[f64; 2]>,
    /// Whether y counts things, so that only whole numbers are named.
    pub y_whole: bool,
    /// What is drawn, in the legend's order.
    pub series: Vec<Series>,
    /// Lines across.
    pub rules: Vec<Rule>,
    /// Why there may be no data.
    pub why_empty: String,
}

/// A series of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Its name in the legend; a chart whose only series has no name has no legend.
    pub name: String,
    /// x and y, in the order in which they are joined. With at most 40, each has a marker.
    pub points: Vec<[f64; 2]>,
    /// From where to where each point's error bar goes, y; empty: no error bars.
    pub errors: Vec<[f64; 2]>,
    /// Whether y keeps its value until the next point.
    pub steps: bool,
}

/// A dashed line across a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rule {
    /// At which y.
    pub y: f64,
    /// What it means.
    pub words: String,
}

impl Chart {
    /// The chart as an SVG document.
    ///
    /// # Errors
    /// The drawing library refuses.
    pub fn svg(&self) -> Result<String, PictureError> {
        stacked(std::slice::from_ref(self))
    }

    /// The chart as a PNG file of [`WIDTH`](crate::WIDTH) by [`HEIGHT`](crate::HEIGHT) pixels.
    ///
    /// # Errors
    /// The drawing library refuses, or the SVG cannot be rendered.
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        paper::png(&self.svg()?)
    }

    fn clean(&self) -> Self {
        let shown = |value: f64, log: bool| if log && value <= 0.0 { f64::NAN } else { value };
        let mut clean = self.clone();
        for series in &mut clean.series {
            for point in &mut series.points {
                *point = [shown(point[0], self.x_log), shown(point[1], self.y_log)];
            }
            for ends in &mut series.errors {
                *ends = ends.map(|end| shown(end, self.y_log));
            }
        }
        clean
    }

    fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let all = self.series.iter().flat_map(|series| series.points.iter().copied());
        all.filter(|point| point.iter().all(|value| value.is_finite()))
    }

    fn x_extent(&self) -> Option<[f64; 2]> {
        extent(self.points().map(|point| point[0]))
    }

    fn x_axis(&self, range: [f64; 2]) -> Axis {
        if self.x_log { Axis::log(range) } else { Axis::tight(range, 10) }
    }

    fn y_axis(&self, count: usize) -> Axis {
        let values = self.points().map(|point| point[1]);
        let errors = self.series.iter().flat_map(|series| series.errors.iter().copied().flatten());
        let least = self.y_least.into_iter().flatten();
        let rules = self.rules.iter().map(|rule| rule.y).filter(|y| !self.y_log || *y > 0.0);
        match extent(values.chain(errors).chain(rules).chain(least.filter(|_| !self.y_log))) {
            Some(range) if self.y_log => Axis::log(range),
            Some(range) if self.y_whole => Axis::whole(range, count),
            range => Axis::wide(range.unwrap_or([0.0, 1.0]), count),
        }
    }

    fn legend(&self) -> Vec<(Key, String)> {
        let named = self.series.len() > 1 || self.series.iter().any(|series| !series.name.is_empty());
        let key = |(at, series): (usize, &Series)| {
            let (colour, shape) = colour::look(at);
            (Key::Line(colour, shape), series.name.clone())
        };
        if named { self.series.iter().enumerate().map(key).collect() } else { Vec::new() }
    }
}

/// Charts with one x axis, the first at the top. Title and legend are those of the first.
pub(crate) fn stacked(charts: &[Chart]) -> Result<String, PictureError> {
    let charts: Vec<Chart> = charts.iter().map(Chart::clean).collect();
    let Some(first) = charts.first() else { return Err(PictureError::Draw("no chart".to_owned())) };
    let Some(x_range) = extent(charts.iter().filter_map(Chart::x_extent).flatten()) else {
        return paper::nothing(&first.title, &first.subtitle, &first.why_empty);
    };
    paper::svg(&first.title, |sheet| {
        let top = paper::head(sheet, &first.title, &first.subtitle)?;
        let top = legend(sheet, top, &first.legend())? + 16;
        let frames = frames(top, charts.len() as i32);
        for (row, (chart, frame)) in charts.iter().zip(frames).enumerate() {
            let is_last = row + 1 == charts.len();
            let count = if charts.len() > 1 { 4 } else { 7 };
            let axes = Axes {
                x: chart.x_axis(x_range),
                y: chart.y_axis(count),
                x_label: if is_last { &chart.x_label } else { "" },
                y_label: &chart.y_label,
                grid: true,
            };
            let plane = Plane::draw(sheet, frame, axes)?;
            for rule in &chart.rules {
                plane.rule(sheet, rule.y, &rule.words)?;
            }
            for (at, series) in chart.series.iter().enumerate() {
                plane.series(sheet, series, (at, chart.series.len()))?;
            }
        }
        Ok(())
    })
}

fn frames(top: i32, count: i32) -> impl Iterator<Item = Frame> {
    let bottom = HEIGHT as i32 - 12;
    let each = (bottom - top) / count.max(1);
    (0..count).map(move |row| [BESIDE + 12, top + row * each, WIDTH as i32 - 36, top + (row + 1) * each - BELOW])
}
