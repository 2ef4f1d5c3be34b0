//! What charts are made of: a legend, a plane with axes, series and rules on it.

use crate::axis::Axis;
use crate::chart::Series;
use crate::colour::{self, FAINT, GRID, INK, Shape, WARNING};
use crate::paper::{self, Drawn, FINE, Fine, Label, MARGIN, Sheet, fine, pen, refused};
use crate::{PictureError, WIDTH};
use plotters::element::DashedPathElement;
use plotters::prelude::ChartBuilder;
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, IntoFont, RGBColor};

/// Sizes of text, pixels.
pub(crate) const TICK_TEXT: f64 = 15.0;
pub(crate) const TEXT: f64 = 16.0;

/// Room for the names of values below and left of a plane, pixels.
pub(crate) const BELOW: i32 = 64;
pub(crate) const BESIDE: i32 = 96;

/// A rectangle, pixels: left, top, right, bottom.
pub(crate) type Frame = [i32; 4];

/// A plane with axes, ready to be drawn on.
pub(crate) struct Plane {
    x: Axis,
    y: Axis,
    frame: Frame,
}

/// A plane before it is drawn.
pub(crate) struct Axes<'a> {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) x_label: &'a str,
    pub(crate) y_label: &'a str,
    /// Whether lines go through the named values.
    pub(crate) grid: bool,
}

impl Plane {
    /// Draw axes around a frame; the names of values stand outside of it.
    pub(crate) fn draw(sheet: &Sheet, frame: Frame, axes: Axes) -> Result<Self, PictureError> {
        let [left, top, right, bottom] = frame;
        let area = sheet
            .clone()
            .shrink(fine(left - BESIDE, top), ((right - left + BESIDE) * FINE, (bottom - top + BELOW) * FINE));
        let mut chart = ChartBuilder::on(&area)
            .x_label_area_size(BELOW * FINE)
            .y_label_area_size(BESIDE * FINE)
            .build_cartesian_2d(axes.x.clone(), axes.y.clone())
            .map_err(refused)?;
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(GRID.mix(0.0)).bold_line_style(pen(GRID, 1.0)).axis_style(pen(INK, 1.0));
        mesh.label_style(paper::font(TICK_TEXT).into_font().color(&INK)).set_all_tick_mark_size(6 * FINE);
        if !axes.grid {
            mesh.disable_mesh();
        }
        mesh.draw().map_err(refused)?;
        let middle = (left + right) / 2;
        Label { anchor: HPos::Center, ..Label::new(axes.x_label, fine(middle, bottom + BELOW - 18), TEXT) }
            .draw(sheet)?;
        let words = paper::fitted(axes.y_label, TEXT, bottom - top + 2 * MARGIN);
        let at = fine(left - BESIDE + 18, (top + bottom) / 2);
        Label { anchor: HPos::Center, upright: true, ..Label::new(&words, at, TEXT) }.draw(sheet)?;
        Ok(Self { x: axes.x, y: axes.y, frame })
    }

    /// Where a point is, fine units.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> Fine {
        let [left, top, right, bottom] = self.frame.map(|edge| f64::from(edge * FINE));
        // Far outside stays outside, and a number that fits.
        let (x, y) = (self.x.share(x).clamp(-10.0, 10.0), self.y.share(y).clamp(-10.0, 10.0));
        ((left + (right - left) * x).round() as i32, (bottom - (bottom - top) * y).round() as i32)
    }

    /// The plane's frame, pixels.
    pub(crate) fn frame(&self) -> Frame {
        self.frame
    }

    /// A dashed line across at a value of y, with words above its right end.
    pub(crate) fn rule(&self, sheet: &Sheet, y: f64, words: &str) -> Drawn {
        let [left, _, right, _] = self.frame;
        let height = self.at([0.0, y]).1;
        dashed(sheet, &[(left * FINE, height), (right * FINE, height)], WARNING)?;
        let at = ((right - 8) * FINE, height - 12 * FINE);
        Label { anchor: HPos::Right, colour: WARNING, ..Label::new(words, at, TICK_TEXT) }.draw(sheet)
    }

    /// A series: its line, broken where a value is missing, its error bars and its markers. `at`: which of how many.
    pub(crate) fn series(&self, sheet: &Sheet, series: &Series, at: (usize, usize)) -> Drawn {
        let (at, count) = at;
        let look = colour::look(at);
        let (colour, _) = look;
        for (point, [low, high]) in series.points.iter().zip(&series.errors) {
            self.error_bar(sheet, point[0], [*low, *high], colour)?;
        }
        let few = series.points.len() <= 40;
        for piece in pieces(&series.points, |[x, y]| x.is_finite() && y.is_finite()) {
            let corners = if series.steps { stairs(piece) } else { thinned(piece) };
            let points: Vec<Fine> = corners.into_iter().map(|point| self.at(point)).collect();
            // A value with none beside it would have no length.
            if points.len() == 1 && !few {
                paper::disc(sheet, points[0], 2 * FINE, colour.filled())?;
            }
            paper::line(sheet, points, pen(colour, 2.0))?;
        }
        // Markers on a dense line are for telling lines apart, so one that is alone needs none.
        let apart = if few { 1 } else { (series.points.len() / 10).max(1) };
        let marked = series.points.iter().filter(|[x, y]| x.is_finite() && y.is_finite() && (few || count > 1));
        // Those of different lines stand at different places, so that none hides another.
        for point in marked.skip(apart * (at + 1) / (count + 1)).step_by(apart) {
            paper::marker(sheet, self.at(*point), look, 5.0, false)?;
        }
        Ok(())
    }

    fn error_bar(&self, sheet: &Sheet, x: f64, [low, high]: [f64; 2], colour: RGBColor) -> Drawn {
        if !(x.is_finite() && low.is_finite() && high.is_finite()) {
            return Ok(());
        }
        let (bottom, top) = (self.at([x, low]), self.at([x, high]));
        paper::line(sheet, vec![bottom, top], pen(colour, 1.5))?;
        for end in [bottom, top] {
            paper::line(sheet, vec![(end.0 - 6 * FINE, end.1), (end.0 + 6 * FINE, end.1)], pen(colour, 1.5))?;
        }
        Ok(())
    }
}

/// A dashed line, fine units.
pub(crate) fn dashed(sheet: &Sheet, points: &[Fine], colour: RGBColor) -> Drawn {
    let dashes = DashedPathElement::new(points.to_vec(), 8 * FINE, 6 * FINE, pen(colour, 1.5));
    sheet.draw(&dashes).map_err(refused)
}

/// The longest runs of values that hold.
pub(crate) fn pieces<T>(values: &[T], holds: impl Fn(&T) -> bool) -> impl Iterator<Item = &[T]> {
    values.split(move |value| !holds(value)).filter(|piece| !piece.is_empty())
}

fn stairs(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for (at, point) in points.iter().enumerate() {
        match corners.last().copied() {
            // A long step is one line, not one a value.
            Some([_, height]) if (height - point[1]).abs() <= 0.0 => {
                if at + 1 == points.len() {
                    corners.push(*point);
                }
            }
            Some([_, height]) => corners.extend([[point[0], height], *point]),
            None => corners.push(*point),
        }
    }
    corners
}

/// At most about 4,000 points that look the same: the least and the greatest of as many as fall on one spot.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let together = points.len().div_ceil(2000);
    if together < 3 {
        return points.to_vec();
    }
    let ends = |chunk: &[[f64; 2]]| {
        let by_height = |one: &&[f64; 2], other: &&[f64; 2]| one[1].total_cmp(&other[1]);
        let mut ends: Vec<[f64; 2]> =
            chunk.iter().min_by(by_height).into_iter().chain(chunk.iter().max_by(by_height)).copied().collect();
        ends.sort_by(|one, other| one[0].total_cmp(&other[0]));
        ends
    };
    points.chunks(together).flat_map(ends).collect()
}

/// What stands for something in a legend.
#[derive(Clone, Copy)]
pub(crate) enum Key {
    /// A line with a marker.
    Line(RGBColor, Shape),
    /// A patch of colour.
    Patch(RGBColor),
}

impl Key {
    pub(crate) fn draw(self, sheet: &Sheet, (x, y): (i32, i32)) -> Drawn {
        match self {
            Key::Line(colour, shape) => {
                paper::line(sheet, vec![fine(x, y), fine(x + 28, y)], pen(colour, 2.5))?;
                paper::marker(sheet, fine(x + 14, y), (colour, shape), 5.0, false)
            }
            Key::Patch(colour) => {
                let corners = [(x, y - 8), (x + 28, y - 8), (x + 28, y + 8), (x, y + 8)];
                paper::polygon(sheet, corners.map(|(x, y)| fine(x, y)).to_vec(), colour.filled())
            }
        }
    }
}

/// A legend in rows from the left. Gives the first free height below it, pixels.
pub(crate) fn legend(sheet: &Sheet, top: i32, entries: &[(Key, String)]) -> Result<i32, PictureError> {
    const KEY: i32 = 36;
    let (left, right) = (MARGIN, WIDTH as i32 - MARGIN);
    let (mut x, mut y) = (left, top + 12);
    for (key, words) in entries {
        let words = paper::fitted(words, TEXT, right - left - KEY);
        let room = KEY + paper::width(&words, TEXT);
        if x > left && x + room > right {
            (x, y) = (left, y + 26);
        }
        key.draw(sheet, (x, y))?;
        Label { colour: FAINT, ..Label::new(&words, fine(x + KEY, y), TEXT) }.draw(sheet)?;
        x += room + 28;
    }
    Ok(if entries.is_empty() { top } else { y + 22 })
}
