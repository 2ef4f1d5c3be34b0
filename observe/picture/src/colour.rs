//! Colours that people with any colour vision can tell apart, and shapes for those who see none.

use plotters::style::RGBColor;

/// Okabe and Ito's colours, without the yellow that is lost on white paper.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];
const SHAPES: [Shape; 5] = [Shape::Circle, Shape::Square, Shape::Up, Shape::Diamond, Shape::Down];

pub(crate) const INK: RGBColor = RGBColor(34, 34, 34);
pub(crate) const FAINT: RGBColor = RGBColor(95, 95, 95);
pub(crate) const GRID: RGBColor = RGBColor(224, 224, 224);
pub(crate) const PAPER: RGBColor = RGBColor(255, 255, 255);
pub(crate) const WARNING: RGBColor = RGBColor(190, 30, 45);

/// The form of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
}

/// What stands for the `index`th of several things: no two of the first 35 look the same.
pub(crate) fn look(index: usize) -> (RGBColor, Shape) {
    (COLOURS[index % COLOURS.len()], SHAPES[index % SHAPES.len()])
}
