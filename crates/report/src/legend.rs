//! The head of a chart: its title, and below it the legend, so that no curve is hidden by it.

use plotters::style::text_anchor::HPos;

use crate::colour::{Colour, INK};
use crate::drawing::{Area, DrawingError, Words, fill};

/// Height of the title and of a row of the legend, pixels.
const TITLE_PX: f64 = 20.0;
const ROW_PX: f64 = 15.0;
/// Above the title, and left and right of the legend.
const MARGIN_PX: f64 = 8.0;
const TITLE_SIZE: f64 = 12.0;
const LABEL_SIZE: f64 = 10.5;
/// Mean width of a letter at the size of labels; no font is measured.
const LETTER_PX: f64 = 5.8;
/// Length of a stroke in the colour of a series, with the gap behind it, and the gap behind a label.
const STROKE_PX: f64 = 16.0;
const STROKE_GAP_PX: f64 = 5.0;
const ENTRY_GAP_PX: f64 = 16.0;

/// A series in the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Entry<'a> {
    pub(crate) label: &'a str,
    pub(crate) colour: Colour,
}

impl Entry<'_> {
    fn width_px(&self) -> f64 {
        let label = self.label.chars().count() as f64 * LETTER_PX;
        STROKE_PX + STROKE_GAP_PX + label + ENTRY_GAP_PX
    }
}

/// Title and legend of a chart.
pub(crate) struct ChartHead<'a> {
    title: &'a str,
    rows: Vec<Vec<Entry<'a>>>,
    width_px: f64,
}

impl<'a> ChartHead<'a> {
    /// Lays the legend out in rows over this width.
    pub(crate) fn new(title: &'a str, entries: &[Entry<'a>], width_px: f64) -> Self {
        // No gap follows the last entry.
        let room = width_px - 2.0 * MARGIN_PX + ENTRY_GAP_PX;
        let mut rows: Vec<Vec<Entry<'a>>> = Vec::new();
        // Any value serves: the first entry begins a row, which sets it.
        let mut used = f64::INFINITY;
        for entry in entries {
            used += entry.width_px();
            match rows.last_mut() {
                Some(row) if used <= room => row.push(*entry),
                _ => {
                    rows.push(vec![*entry]);
                    used = entry.width_px();
                }
            }
        }
        Self { title, rows, width_px }
    }

    /// Height of the head, pixels.
    pub(crate) fn height_px(&self) -> f64 {
        let title = if self.title.is_empty() { 0.0 } else { TITLE_PX };
        MARGIN_PX + title + ROW_PX * self.rows.len() as f64
    }

    /// Draws it at the top of an area.
    pub(crate) fn draw(&self, area: &Area<'_>) -> Result<(), DrawingError> {
        let mut y = MARGIN_PX;
        if !self.title.is_empty() {
            let title = Words::new(self.title, TITLE_SIZE, INK, HPos::Center);
            let at = (0.5 * self.width_px, y + 0.5 * TITLE_PX);
            Words { is_bold: true, ..title }.draw(area, at)?;
            y += TITLE_PX;
        }
        for row in &self.rows {
            let width: f64 = row.iter().map(Entry::width_px).sum::<f64>() - ENTRY_GAP_PX;
            // A row that is too long begins at the margin instead of left of the chart.
            let mut x = (0.5 * (self.width_px - width)).max(MARGIN_PX);
            let middle = y + 0.5 * ROW_PX;
            for entry in row {
                let stroke = [(x, middle - 1.5), (x + STROKE_PX, middle + 1.5)];
                fill(area, stroke[0], stroke[1], entry.colour)?;
                let words = Words::new(entry.label, LABEL_SIZE, INK, HPos::Left);
                words.draw(area, (x + STROKE_PX + STROKE_GAP_PX, middle))?;
                x += entry.width_px();
            }
            y += ROW_PX;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_that_do_not_fit_begin_another_row() {
        let entries = ["network", "mean pose", "a method of a long name"]
            .map(|label| Entry { label, colour: INK });
        let rows = |width| -> Vec<usize> {
            ChartHead::new("title", &entries, width).rows.iter().map(Vec::len).collect()
        };
        assert_eq!(rows(600.0), [3]);
        assert_eq!(rows(250.0), [2, 1]);
        assert_eq!(rows(20.0), [1, 1, 1]);
        assert_eq!(ChartHead::new("", &[], 300.0).height_px(), MARGIN_PX);
        assert_eq!(ChartHead::new("t", &entries, 250.0).height_px(), MARGIN_PX + TITLE_PX + 30.0);
    }
}
