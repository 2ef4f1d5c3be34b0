//! The paper that pictures are drawn on: an SVG of a fixed size, text on it, and the PNG of it.
//!
//! Lengths are pixels of the PNG unless they are called fine. Plotters knows whole numbers only: it draws on a canvas
//! [`FINE`] times as large, which the SVG's header scales down.

use crate::colour::{FAINT, INK, PAPER, Shape};
use crate::{HEIGHT, PictureError, WIDTH, words};
use plotters::coord::Shift;
use plotters::prelude::{Circle, DrawingArea, IntoDrawingArea, IntoFont, PathElement, Polygon, SVGBackend, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoTextStyle, RGBColor, ShapeStyle, register_font};
use resvg::{tiny_skia, usvg};
use std::sync::LazyLock;

/// Fine units in a pixel.
pub(crate) const FINE: i32 = 4;
/// Of the paper, pixels.
pub(crate) const MARGIN: i32 = 24;
const FAMILY: &str = "sans-serif";
/// Plotters counts a font's size with its line gap, SVG without.
const LINE: f64 = 1.24;

/// A point, fine units, y down.
pub(crate) type Fine = (i32, i32);
/// What is drawn on.
pub(crate) type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing comes to.
pub(crate) type Drawn = Result<(), PictureError>;

pub(crate) fn refused(error: impl std::fmt::Display) -> PictureError {
    PictureError::Draw(error.to_string())
}

static FONT: LazyLock<Result<(), PictureError>> = LazyLock::new(|| {
    register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| PictureError::Draw("the font that is part of the program is not one".to_owned()))
});

/// An SVG document with what `paint` paints on it.
pub(crate) fn svg(title: &str, paint: impl FnOnce(&Sheet) -> Drawn) -> Result<String, PictureError> {
    LazyLock::force(&FONT).as_ref().map_err(refused)?;
    let (width, height) = (WIDTH * FINE.unsigned_abs(), HEIGHT * FINE.unsigned_abs());
    let mut drawn = String::new();
    {
        let sheet = SVGBackend::with_string(&mut drawn, (width, height)).into_drawing_area();
        sheet.fill(&PAPER).map_err(refused)?;
        paint(&sheet)?;
        sheet.present().map_err(refused)?;
    }
    let body = drawn.split_once('>').map_or("", |(_, body)| body);
    let label = words::escaped(title);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\" stroke-linejoin=\"round\" \
         stroke-linecap=\"round\">{body}"
    ))
}

static RENDERING: LazyLock<usvg::Options<'static>> = LazyLock::new(|| {
    let mut options = usvg::Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    options
});

/// The PNG file of such a document.
pub(crate) fn png(svg: &str) -> Result<Vec<u8>, PictureError> {
    let failed = |error: &dyn std::fmt::Display| PictureError::Render(error.to_string());
    let tree = usvg::Tree::from_str(svg, &RENDERING).map_err(|error| failed(&error))?;
    let mut pixels = tiny_skia::Pixmap::new(WIDTH, HEIGHT).ok_or_else(|| failed(&"no pixels"))?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| failed(&error))
}

/// A font of this size, pixels.
pub(crate) fn font(size: f64) -> (&'static str, f64) {
    (FAMILY, size * LINE * f64::from(FINE))
}

/// How wide words are, pixels; a little more than less.
pub(crate) fn width(words: &str, size: f64) -> i32 {
    let measured = font(size).into_font().box_size(words).map(|(width, _)| width as i32 / FINE);
    // Without a font there is no picture either: a guess will do.
    measured.unwrap_or((words.chars().count() as f64 * size * 0.6) as i32)
}

/// Words that are not wider than `room` pixels: their end is cut off if need be.
pub(crate) fn fitted(words: &str, size: f64, room: i32) -> String {
    if width(words, size) <= room {
        return words.to_owned();
    }
    let mut kept: Vec<char> = words.chars().collect();
    while !kept.is_empty() && width(&format!("{}…", kept.iter().collect::<String>()), size) > room {
        kept.pop();
    }
    format!("{}…", kept.into_iter().collect::<String>().trim_end())
}

/// Words at a place.
pub(crate) struct Label<'a> {
    pub(crate) words: &'a str,
    /// Where, fine units; the words' middle in height.
    pub(crate) at: Fine,
    /// Pixels.
    pub(crate) size: f64,
    pub(crate) colour: RGBColor,
    /// Which part of the words is there.
    pub(crate) anchor: HPos,
    /// Written from the bottom to the top.
    pub(crate) upright: bool,
}

impl<'a> Label<'a> {
    pub(crate) fn new(words: &'a str, at: Fine, size: f64) -> Self {
        Self { words, at, size, colour: INK, anchor: HPos::Left, upright: false }
    }

    pub(crate) fn draw(&self, sheet: &Sheet) -> Drawn {
        let transform = if self.upright { FontTransform::Rotate270 } else { FontTransform::None };
        let face = font(self.size).into_font().transform(transform);
        let style = face.into_text_style(sheet).pos(Pos::new(self.anchor, VPos::Center)).color(&self.colour);
        // What XML cannot hold would make the whole document unreadable.
        sheet.draw(&Text::new(words::plain(self.words), self.at, style)).map_err(refused)
    }
}

/// Title and what the run was, at the top. Gives the first free height, pixels.
pub(crate) fn head(sheet: &Sheet, title: &str, subtitle: &str) -> Result<i32, PictureError> {
    let room = WIDTH as i32 - 2 * MARGIN;
    Label::new(&fitted(title, 24.0, room), fine(MARGIN, 36), 24.0).draw(sheet)?;
    if subtitle.is_empty() {
        return Ok(64);
    }
    let subtitle = fitted(subtitle, 16.0, room);
    Label { colour: FAINT, ..Label::new(&subtitle, fine(MARGIN, 68), 16.0) }.draw(sheet)?;
    Ok(92)
}

/// A picture that says why there is none.
pub(crate) fn nothing(title: &str, subtitle: &str, why: &str) -> Result<String, PictureError> {
    svg(title, |sheet| {
        head(sheet, title, subtitle)?;
        let words = fitted(&format!("no data: {why}"), 20.0, WIDTH as i32 - 4 * MARGIN);
        let at = fine(WIDTH as i32 / 2, HEIGHT as i32 / 2);
        Label { anchor: HPos::Center, colour: FAINT, ..Label::new(&words, at, 20.0) }.draw(sheet)
    })
}

pub(crate) fn fine(x: i32, y: i32) -> Fine {
    (x * FINE, y * FINE)
}

/// A pen this wide, pixels.
pub(crate) fn pen(colour: RGBColor, width: f64) -> ShapeStyle {
    ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: (width * f64::from(FINE)).round() as u32 }
}

pub(crate) fn line(sheet: &Sheet, points: Vec<Fine>, pen: ShapeStyle) -> Drawn {
    sheet.draw(&PathElement::new(points, pen)).map_err(refused)
}

pub(crate) fn polygon(sheet: &Sheet, points: Vec<Fine>, fill: ShapeStyle) -> Drawn {
    sheet.draw(&Polygon::new(points, fill)).map_err(refused)
}

pub(crate) fn disc(sheet: &Sheet, at: Fine, radius: i32, style: ShapeStyle) -> Drawn {
    sheet.draw(&Circle::new(at, radius, style)).map_err(refused)
}

/// A marker of about `radius` pixels; an open one is white within.
pub(crate) fn marker(sheet: &Sheet, at: Fine, look: (RGBColor, Shape), radius: f64, open: bool) -> Drawn {
    let (colour, shape) = look;
    let fill = if open { PAPER } else { colour };
    let edge = if open { pen(colour, 2.0) } else { pen(PAPER, 1.0) };
    let radius = radius * f64::from(FINE);
    let corners: &[(f64, f64)] = match shape {
        Shape::Circle => {
            disc(sheet, at, radius as i32, fill.filled())?;
            return disc(sheet, at, radius as i32, edge);
        }
        Shape::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
        Shape::Up => &[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)],
        Shape::Diamond => &[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)],
        Shape::Down => &[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)],
    };
    let place = |(x, y): &(f64, f64)| (at.0 + (x * radius) as i32, at.1 + (y * radius) as i32);
    let mut outline: Vec<Fine> = corners.iter().map(place).collect();
    polygon(sheet, outline.clone(), fill.filled())?;
    outline.extend(outline.first().copied());
    line(sheet, outline, edge)
}
