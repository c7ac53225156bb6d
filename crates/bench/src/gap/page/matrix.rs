//! The confusion matrix as a heatmap.

use std::fmt::Write as _;

use crate::gap::confusion::{Cell, Confusion};
use evpose_report::html::escape;

/// Size of a cell, pixels.
const CELL: (f64, f64) = (24.0, 17.0);
/// Width of a letter, about, pixels.
const LETTER: f64 = 6.1;

/// Draws it.
pub(super) fn svg(matrix: &Confusion) -> String {
    let longest =
        |names: &[String]| names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let left = LETTER * longest(&matrix.rows) as f64 + 12.0;
    // Names of columns go up at 50 degrees.
    let reach = LETTER * longest(&matrix.columns) as f64;
    let (top, right) = (0.77 * reach + 14.0, 0.65 * reach + 10.0);
    let width = left + CELL.0 * matrix.columns.len() as f64 + right;
    let height = top + CELL.1 * matrix.rows.len() as f64 + 6.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" font-size=\"11\">"
    );
    for (j, name) in matrix.columns.iter().enumerate() {
        let x = left + (j as f64 + 0.6) * CELL.0;
        let _ = write!(
            svg,
            "<text transform=\"translate({x:.1} {:.1}) rotate(-50)\">{}</text>",
            top - 4.0,
            escape(name)
        );
    }
    for (i, (name, cells)) in matrix.rows.iter().zip(&matrix.cells).enumerate() {
        let y = top + i as f64 * CELL.1;
        let all: usize = cells.iter().map(|cell| cell.n).sum();
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 6.0,
            y + CELL.1 - 4.0,
            escape(name)
        );
        for (j, cell) in cells.iter().enumerate() {
            let x = left + j as f64 * CELL.0;
            let _ = write!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                CELL.0 - 1.0,
                CELL.1 - 1.0,
                colour(cell, all)
            );
            if cell.n > 0 {
                let ink = if is_dark(cell, all) { "#fff" } else { "#1d2430" };
                let _ = write!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"{ink}\">{}</text>",
                    x + 0.5 * (CELL.0 - 1.0),
                    y + CELL.1 - 5.0,
                    cell.n
                );
            }
        }
    }
    svg + "</svg>"
}

/// How strong a colour is: by the share of the row, so that few are still seen.
fn strength(cell: &Cell, all: usize) -> f64 {
    0.25 + 0.75 * cell.n as f64 / all.max(1) as f64
}

fn is_dark(cell: &Cell, all: usize) -> bool {
    strength(cell, all) > 0.7
}

/// Green for what is to be said, red for wrong names, grey for neither, pale for nothing.
fn colour(cell: &Cell, all: usize) -> String {
    if cell.n == 0 {
        return "#f3f4f6".to_owned();
    }
    let full = if 2 * cell.wrong > cell.n {
        [176.0, 32.0, 48.0]
    } else if 2 * cell.met > cell.n {
        [10.0, 125.0, 86.0]
    } else {
        [96.0, 104.0, 120.0]
    };
    let share = strength(cell, all);
    let [r, g, b] = full.map(|c| 255.0 + (c - 255.0) * share);
    format!("rgb({r:.0},{g:.0},{b:.0})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_names_are_red_right_ones_green_and_silence_is_grey() {
        let cell = |met, wrong| Cell { n: 4, met, wrong };
        assert_eq!(colour(&cell(0, 4), 4), "rgb(176,32,48)");
        assert_eq!(colour(&cell(4, 0), 4), "rgb(10,125,86)");
        assert_eq!(colour(&cell(0, 0), 4), "rgb(96,104,120)");
        assert_eq!(colour(&Cell::default(), 4), "#f3f4f6");
    }

    #[test]
    fn all_names_and_counts_are_in_the_heatmap() {
        let matrix = Confusion {
            rows: vec!["a<b".to_owned()],
            columns: vec!["said".to_owned()],
            cells: vec![vec![Cell { n: 42, met: 42, wrong: 0 }]],
        };
        let svg = svg(&matrix);
        assert!(svg.contains("a&lt;b") && svg.contains("said") && svg.contains(">42<"));
    }
}
