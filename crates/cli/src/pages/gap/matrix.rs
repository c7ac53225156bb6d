//! Similarity of effects in a recording, as a heatmap.

use evpose_gap::report::Confusability;

use evpose_report::colour::{Colour, mix};
use evpose_report::drawing::DrawingError;
use evpose_report::heatmap::{Heatmap, HeatmapCell, Name};

/// Side of a cell, pixels.
const CELL_PX: f64 = 19.0;
/// Cosine from which two effects cannot be distinguished.
pub(crate) const ALIKE: f64 = 0.95;
/// Cosine from which they are hard to distinguish.
const NEAR: f64 = 0.8;
const DIAGONAL: Colour = (236, 238, 242);
/// Colours of cosines 0, about 0.7, and 1.
const STOPS: [Colour; 3] = [(252, 252, 253), (240, 160, 80), (128, 16, 40)];

/// Draws all pairs; the effects in `named` are bold.
pub(crate) fn svg(matrix: &Confusability, named: &[String]) -> Result<String, DrawingError> {
    let names = || {
        let name = |name: &String| Name { text: name.clone(), is_bold: named.contains(name) };
        matrix.names.iter().map(name).collect()
    };
    let n = matrix.names.len();
    let heatmap = Heatmap {
        rows: names(),
        columns: names(),
        cells: (0..n).map(|i| (0..n).map(|j| cell(matrix, i, j)).collect()).collect(),
        cell_px: (CELL_PX, CELL_PX),
    };
    heatmap.svg()
}

fn cell(matrix: &Confusability, i: usize, j: usize) -> HeatmapCell {
    let value = matrix.cosines.get(i).and_then(|row| row.get(j)).copied();
    let value = value.filter(|value| value.is_finite()).unwrap_or(0.0).clamp(0.0, 1.0);
    let is_marked = i != j && value >= NEAR;
    HeatmapCell {
        fill: if i == j { DIAGONAL } else { colour(value) },
        text: if is_marked { format!("{:.0}", 100.0 * value) } else { String::new() },
        ink: (255, 255, 255),
        tooltip: format!("{} and {}: {value:.2}", matrix.names[i], matrix.names[j]),
    }
}

/// From white over orange to a dark red, by the square: small cosines differ little.
fn colour(value: f64) -> Colour {
    let place = 2.0 * value * value;
    match place < 1.0 {
        true => mix(STOPS[0], STOPS[1], place),
        false => mix(STOPS[1], STOPS[2], place - 1.0),
    }
}

/// Pairs that cannot be distinguished.
pub(crate) fn alike(matrix: &Confusability) -> Vec<String> {
    let n = matrix.names.len();
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i)));
    let value = |i: usize, j: usize| matrix.cosines.get(i).and_then(|row| row.get(j)).copied();
    pairs
        .filter(|(i, j)| value(*i, *j).is_some_and(|value| value >= ALIKE))
        .map(|(i, j)| format!("{} and {}", matrix.names[i], matrix.names[j]))
        .collect()
}
