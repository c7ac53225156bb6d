//! Matrices as cells of colours, with names of rows and columns, as SVG.

use std::fmt::Write as _;

use plotters::style::text_anchor::HPos;

use crate::colour::{Colour, INK};
use crate::drawing::{Area, DrawingError, Words, document, fill};
use crate::html::escape;

/// Font sizes of names and of cells, pixels.
const NAME_PX: f64 = 11.0;
const CELL_PX: f64 = 9.5;
/// Width of a letter of a name, about, pixels.
const LETTER: f64 = 6.1;
const BOLD_LETTER: f64 = 6.8;
/// Space around names, pixels.
const SPACE: f64 = 8.0;

/// A row or a column.
pub struct Name {
    /// Shown beside or above the cells.
    pub text: String,
    /// Whether it is set in bold.
    pub is_bold: bool,
}

impl Name {
    /// A name of usual weight.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), is_bold: false }
    }
}

/// A cell of a matrix.
pub struct HeatmapCell {
    /// Colour of the cell.
    pub fill: Colour,
    /// A value inside, in its colour; empty for none.
    pub text: String,
    /// Colour of the value.
    pub ink: Colour,
    /// Shown while the pointer is over the cell; empty for none.
    pub tooltip: String,
}

/// A matrix of colours.
pub struct Heatmap {
    /// Names of the rows, from top to bottom.
    pub rows: Vec<Name>,
    /// Names of the columns, from left to right.
    pub columns: Vec<Name>,
    /// Cells, row by row.
    pub cells: Vec<Vec<HeatmapCell>>,
    /// Width and height of a cell, pixels.
    pub cell_px: (f64, f64),
}

impl Heatmap {
    /// Draws it.
    ///
    /// # Errors
    /// If the SVG backend fails.
    pub fn svg(&self) -> Result<String, DrawingError> {
        let (left, top) = (names_px(&self.rows), names_px(&self.columns));
        let width = left + self.cell_px.0 * self.columns.len() as f64 + SPACE;
        let height = top + self.cell_px.1 * self.rows.len() as f64 + SPACE;
        let svg = document((width.ceil() as u32, height.ceil() as u32), |area| {
            self.draw_names(area, left, top)?;
            self.draw_cells(area, left, top)
        })?;
        Ok(self.with_tooltips(svg, left, top))
    }

    fn draw_names(&self, area: &Area<'_>, left: f64, top: f64) -> Result<(), DrawingError> {
        for (j, name) in self.columns.iter().enumerate() {
            let x = left + (j as f64 + 0.5) * self.cell_px.0;
            words(name, HPos::Left, true).draw(area, (x, top - 0.5 * SPACE))?;
        }
        for (i, name) in self.rows.iter().enumerate() {
            let y = top + (i as f64 + 0.5) * self.cell_px.1;
            words(name, HPos::Right, false).draw(area, (left - 0.5 * SPACE, y))?;
        }
        Ok(())
    }

    fn draw_cells(&self, area: &Area<'_>, left: f64, top: f64) -> Result<(), DrawingError> {
        let (width, height) = self.cell_px;
        for (i, cells) in self.cells.iter().enumerate() {
            for (j, cell) in cells.iter().enumerate() {
                let (x, y) = (left + j as f64 * width, top + i as f64 * height);
                // A pixel of paper separates each cell from the next.
                fill(area, (x, y), (x + width - 1.0, y + height - 1.0), cell.fill)?;
                if !cell.text.is_empty() {
                    let text = Words::new(&cell.text, CELL_PX, cell.ink, HPos::Center);
                    text.draw(area, (x + 0.5 * (width - 1.0), y + 0.5 * (height - 1.0)))?;
                }
            }
        }
        Ok(())
    }

    /// Adds tooltips, which `plotters` has none of: transparent rectangles with titles over cells.
    fn with_tooltips(&self, svg: String, left: f64, top: f64) -> String {
        let mut tooltips = String::new();
        for (i, cells) in self.cells.iter().enumerate() {
            for (j, cell) in cells.iter().enumerate().filter(|(_, cell)| !cell.tooltip.is_empty()) {
                // A shape without a fill catches no pointer unless it asks for all events.
                let _ = write!(
                    tooltips,
                    "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{}\" height=\"{}\" fill=\"none\" \
                     pointer-events=\"all\"><title>{}</title></rect>",
                    left + j as f64 * self.cell_px.0,
                    top + i as f64 * self.cell_px.1,
                    self.cell_px.0,
                    self.cell_px.1,
                    escape(&cell.tooltip)
                );
            }
        }
        // At the end, so that they lie above everything else.
        match svg.rfind("</svg>") {
            Some(end) => format!("{}{tooltips}{}", &svg[..end], &svg[end..]),
            None => svg,
        }
    }
}

/// Space that the longest name takes, pixels.
fn names_px(names: &[Name]) -> f64 {
    let width = |name: &Name| {
        let letter = if name.is_bold { BOLD_LETTER } else { LETTER };
        letter * name.text.chars().count() as f64
    };
    names.iter().map(width).fold(0.0, f64::max) + SPACE
}

fn words(name: &Name, anchor: HPos, is_upright: bool) -> Words<'_> {
    Words { is_bold: name.is_bold, is_upright, ..Words::new(&name.text, NAME_PX, INK, anchor) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_values_and_tooltips_are_in_the_document() -> Result<(), DrawingError> {
        let cell = HeatmapCell {
            fill: (10, 20, 30),
            text: "42".to_owned(),
            ink: (255, 255, 255),
            tooltip: "a<b".to_owned(),
        };
        let heatmap = Heatmap {
            rows: vec![Name::new("row & more")],
            columns: vec![Name { text: "column".to_owned(), is_bold: true }],
            cells: vec![vec![cell]],
            cell_px: (24.0, 17.0),
        };
        let svg = heatmap.svg()?;
        for text in ["row &amp; more", "column", "bold", "42", "<title>a&lt;b</title>", "#0A141E"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.trim_end().ends_with("</svg>"));
        Ok(())
    }
}
