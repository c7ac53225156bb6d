//! The confusion matrix as a heatmap.

use crate::confusion::{Cell, Confusion};
use evpose_report::colour::{Colour, mix};
use evpose_report::drawing::DrawingError;
use evpose_report::heatmap::{Heatmap, HeatmapCell, Name};

/// Size of a cell, pixels.
const CELL_PX: (f64, f64) = (24.0, 17.0);
/// Colours of full cells: wrong names, expected answers, neither; and of empty cells.
const WRONG: Colour = (176, 32, 48);
const MET: Colour = (10, 125, 86);
const NEITHER: Colour = (96, 104, 120);
const EMPTY: Colour = (243, 244, 246);
const WHITE: Colour = (255, 255, 255);
const INK: Colour = (29, 36, 48);

/// Draws the matrix; a colour is the stronger, the larger the share of its row.
pub(super) fn svg(matrix: &Confusion) -> Result<String, DrawingError> {
    let row = |cells: &Vec<Cell>| {
        let all: usize = cells.iter().map(|cell| cell.n).sum();
        cells.iter().map(|cell| drawn(cell, all)).collect()
    };
    let names = |names: &[String]| names.iter().map(Name::new).collect();
    let heatmap = Heatmap {
        rows: names(&matrix.rows),
        columns: names(&matrix.columns),
        cells: matrix.cells.iter().map(row).collect(),
        cell_px: CELL_PX,
    };
    heatmap.svg()
}

fn drawn(cell: &Cell, all: usize) -> HeatmapCell {
    HeatmapCell {
        fill: colour(cell, all),
        text: if cell.n > 0 { cell.n.to_string() } else { String::new() },
        ink: if strength(cell, all) > 0.7 { WHITE } else { INK },
        tooltip: String::new(),
    }
}

/// How strong a colour is: by the share of the row, so that few are still seen.
fn strength(cell: &Cell, all: usize) -> f64 {
    0.25 + 0.75 * cell.n as f64 / all.max(1) as f64
}

/// Green for what is to be said, red for wrong names, grey for neither, pale for nothing.
fn colour(cell: &Cell, all: usize) -> Colour {
    if cell.n == 0 {
        return EMPTY;
    }
    let full = if 2 * cell.wrong > cell.n {
        WRONG
    } else if 2 * cell.met > cell.n {
        MET
    } else {
        NEITHER
    };
    mix(WHITE, full, strength(cell, all))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_names_are_red_right_ones_green_and_silence_is_grey() {
        let cell = |met, wrong| Cell { n: 4, met, wrong };
        assert_eq!(colour(&cell(0, 4), 4), WRONG);
        assert_eq!(colour(&cell(4, 0), 4), MET);
        assert_eq!(colour(&cell(0, 0), 4), NEITHER);
        assert_eq!(colour(&Cell::default(), 4), EMPTY);
    }

    #[test]
    fn all_names_and_counts_are_in_the_heatmap() -> Result<(), DrawingError> {
        let matrix = Confusion {
            rows: vec!["a<b".to_owned()],
            columns: vec!["said".to_owned()],
            cells: vec![vec![Cell { n: 42, met: 42, wrong: 0 }]],
        };
        let svg = svg(&matrix)?;
        assert!(svg.contains("a&lt;b") && svg.contains("said") && svg.contains("\n42\n"), "{svg}");
        Ok(())
    }
}
