//! Smooth random fields that repeat, made row by row.

use evpose_core::{CounterRng, Plane};

/// A sum of value noise over octaves: `octaves` grids, each twice as fine and `persistence` times
/// as strong as the one before, the coarsest with `columns` and `rows`. Values average 0 and stay
/// in [-1, 1]; the field repeats at its borders.
pub(super) fn fractal_noise(
    (width, height): (usize, usize),
    (columns, rows): (usize, usize),
    octaves: u32,
    persistence: f32,
    rng: &mut CounterRng,
) -> Plane<f32> {
    let mut field = Plane::filled(width, height, 0.0);
    let mut amplitude = 1.0;
    let mut total = 0.0;
    for octave in 0..octaves {
        let (columns, rows) = (columns << octave, rows << octave);
        // Finer than the texels there is nothing to add.
        if columns > width || rows > height {
            break;
        }
        add_octave(&mut field, (columns, rows), amplitude, rng);
        total += amplitude;
        amplitude *= persistence;
    }
    // By what was added: a field without its finest octaves is as strong.
    if total > 0.0 {
        field.data_mut().iter_mut().for_each(|value| *value /= total);
    }
    field
}

/// Adds one grid of random values, smoothly interpolated.
fn add_octave(
    field: &mut Plane<f32>,
    (columns, rows): (usize, usize),
    amplitude: f32,
    rng: &mut CounterRng,
) {
    let grid: Vec<f32> = (0..columns * rows).map(|_| rng.uniform(-amplitude, amplitude)).collect();
    // All rows have the same weights along them.
    let across: Vec<_> = (0..field.width()).map(|x| between(x, field.width(), columns)).collect();
    // Down first, once a row for the few grid columns; then across, once a pixel.
    let mut line = vec![0.0; columns];
    for y in 0..field.height() {
        let (above, below, weight) = between(y, field.height(), rows);
        let (above, below) = (&grid[above * columns..], &grid[below * columns..]);
        for (value, (a, b)) in line.iter_mut().zip(above.iter().zip(below)) {
            *value = a + (b - a) * weight;
        }
        for (value, &(left, right, weight)) in field.row_mut(y).iter_mut().zip(&across) {
            *value += line[left] + (line[right] - line[left]) * weight;
        }
    }
}

/// The two grid lines around the centre of texel `i` of `n`, and the smooth weight of the second.
fn between(i: usize, n: usize, cells: usize) -> (usize, usize, f32) {
    let position = (i as f32 + 0.5) / n as f32 * cells as f32;
    let cell = (position as usize).min(cells - 1);
    (cell, (cell + 1) % cells, smoothstep(position - cell as f32))
}

/// The cubic that runs from 0 to 1 with level ends.
pub(super) fn smoothstep(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_is_bounded_continuous_and_repeats() {
        let n = 64;
        let field = fractal_noise((n, n), (4, 4), 1, 0.5, &mut CounterRng::new(1, "noise", 0));
        // One octave of 4 cells: the steepest smoothstep climbs 1.5 · 2 in 16 texels.
        let steepest = 2.0 * 1.5 / 16.0;
        for y in 0..n {
            for x in 0..n {
                let here = *field.at(x, y);
                assert!(here.abs() <= 1.0);
                let right = *field.at((x + 1) % n, y);
                let below = *field.at(x, (y + 1) % n);
                assert!((here - right).abs() <= steepest && (here - below).abs() <= steepest);
            }
        }
    }
}
