//! How alike effects look in a recording, as a table of colours.

use std::fmt::Write as _;

use evpose_gap::report::Confusability;

use crate::html::escape;

/// Side of a cell and room for names, pixels.
const CELL: f64 = 19.0;
const NAMES: f64 = 178.0;
/// From here on two effects cannot be told apart.
pub(crate) const ALIKE: f64 = 0.95;
/// From here on they are hard to tell apart.
const NEAR: f64 = 0.8;

/// Draws all pairs; names that are `told` are bold.
pub(crate) fn svg(matrix: &Confusability, told: &[String]) -> String {
    let n = matrix.names.len() as f64;
    let (width, height) = (NAMES + n * CELL + 110.0, NAMES * 0.8 + n * CELL + 6.0);
    let top = NAMES * 0.8;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" font-size=\"11\">"
    );
    for (i, name) in matrix.names.iter().enumerate() {
        let weight = if told.contains(name) { " font-weight=\"700\"" } else { "" };
        let at = (i as f64 + 0.5) * CELL;
        let words = escape(name);
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\"{weight}>{words}</text>\
             <text transform=\"translate({:.1} {:.1}) rotate(-50)\"{weight}>{words}</text>",
            NAMES - 6.0,
            top + at + 4.0,
            NAMES + at + 3.0,
            top - 5.0
        );
        for (j, other) in matrix.names.iter().enumerate() {
            let value = matrix.cosines.get(i).and_then(|row| row.get(j)).copied();
            let value = value.filter(|value| value.is_finite()).unwrap_or(0.0).clamp(0.0, 1.0);
            let (x, y) = (NAMES + j as f64 * CELL, top + i as f64 * CELL);
            let fill = match i == j {
                true => "#eceef2".to_owned(),
                false => colour(value),
            };
            let _ = write!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{0}\" height=\"{0}\" fill=\"{fill}\">\
                 <title>{words} and {1}: {value:.2}</title></rect>",
                CELL - 1.0,
                escape(other)
            );
            if i != j && value >= NEAR {
                let _ = write!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"9\" fill=\"#fff\" \
                     text-anchor=\"middle\">{:.0}</text>",
                    x + CELL / 2.0,
                    y + CELL / 2.0 + 3.0,
                    100.0 * value
                );
            }
        }
    }
    svg + "</svg>"
}

/// From white over orange to a dark red.
fn colour(value: f64) -> String {
    const STOPS: [[f64; 3]; 3] = [[252.0, 252.0, 253.0], [240.0, 160.0, 80.0], [128.0, 16.0, 40.0]];
    let place = 2.0 * value * value;
    let (low, share) = if place < 1.0 { (0, place) } else { (1, place - 1.0) };
    let channel = |c: usize| STOPS[low][c] + (STOPS[low + 1][c] - STOPS[low][c]) * share;
    format!("rgb({:.0},{:.0},{:.0})", channel(0), channel(1), channel(2))
}

/// Pairs that cannot be told apart.
pub(crate) fn alike(matrix: &Confusability) -> Vec<String> {
    let n = matrix.names.len();
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i)));
    let value = |i: usize, j: usize| matrix.cosines.get(i).and_then(|row| row.get(j)).copied();
    pairs
        .filter(|(i, j)| value(*i, *j).is_some_and(|value| value >= ALIKE))
        .map(|(i, j)| format!("{} and {}", matrix.names[i], matrix.names[j]))
        .collect()
}
