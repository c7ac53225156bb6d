//! SVG documents by `plotters`: the one place where a drawing begins and ends.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use thiserror::Error;

use crate::colour::Colour;

/// Fonts of all drawings.
pub(crate) const FONT: &str = "system-ui, sans-serif";

/// An area in pixels from its upper left corner.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A drawing that failed.
#[derive(Debug, Error)]
#[error("drawing a chart: {0}")]
pub struct DrawingError(String);

impl DrawingError {
    /// An error of the backend, whose type would hold the borrowed document.
    pub(crate) fn new(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

/// Draws a document of this size in pixels.
pub(crate) fn document(
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), DrawingError>,
) -> Result<String, DrawingError> {
    let mut svg = String::new();
    {
        // The drawing area borrows the text, and has to end before that is returned.
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        draw(&root)?;
        root.present().map_err(DrawingError::new)?;
    }
    Ok(svg)
}

pub(crate) fn rgb((r, g, b): Colour) -> RGBColor {
    RGBColor(r, g, b)
}

/// Draws a line of text whose baseline or middle is at a point.
pub(crate) struct Words<'a> {
    pub(crate) text: &'a str,
    /// Font size in pixels.
    pub(crate) size: f64,
    pub(crate) colour: Colour,
    pub(crate) anchor: HPos,
    pub(crate) is_bold: bool,
    /// From bottom to top.
    pub(crate) is_upright: bool,
}

impl<'a> Words<'a> {
    /// Text of usual weight from left to right.
    pub(crate) fn new(text: &'a str, size: f64, colour: Colour, anchor: HPos) -> Self {
        Self { text, size, colour, anchor, is_bold: false, is_upright: false }
    }

    /// Draws it, vertically centred at `y`.
    pub(crate) fn draw(&self, area: &Area<'_>, (x, y): (f64, f64)) -> Result<(), DrawingError> {
        // The backend divides font sizes by 1.24, the ratio of the em box to its font metrics.
        let font = (FONT, 1.24 * self.size).into_font();
        let font = if self.is_bold { font.style(FontStyle::Bold) } else { font };
        let font = if self.is_upright { font.transform(FontTransform::Rotate270) } else { font };
        let style = font.color(&rgb(self.colour)).pos(Pos::new(self.anchor, VPos::Center));
        area.draw(&Text::new(self.text, pixel(x, y), style)).map_err(DrawingError::new)
    }
}

pub(crate) fn pixel(x: f64, y: f64) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

/// Fills a rectangle.
pub(crate) fn fill(
    area: &Area<'_>,
    from: (f64, f64),
    to: (f64, f64),
    colour: Colour,
) -> Result<(), DrawingError> {
    let corners = [pixel(from.0, from.1), pixel(to.0, to.1)];
    area.draw(&Rectangle::new(corners, rgb(colour).filled())).map_err(DrawingError::new)
}

/// Draws a straight line.
pub(crate) fn line(
    area: &Area<'_>,
    from: (f64, f64),
    to: (f64, f64),
    colour: Colour,
) -> Result<(), DrawingError> {
    let ends = [pixel(from.0, from.1), pixel(to.0, to.1)];
    area.draw(&PathElement::new(ends, rgb(colour).stroke_width(1))).map_err(DrawingError::new)
}
