//! Where in the image events are, against where the reference has them.
//!
//! # Model
//! Images of signed events over 20 ms, measured `M` and of the reference `R`, are smoothed; a
//! displacement `d` makes `M - R = -d (grad R + grad M) / 2`, up to its third power. It is solved
//! for tile by tile with `grad R` as the instrument, so that noise of the measured image does not
//! shrink it, and the field over tiles is split into shift, scale, rotation and a term in the cube
//! of the radius. Displacement is in pixels, from the reference to the measured image.

use crate::probe::image::{Image, dot};
use crate::probe::{Probe, reference};
use crate::{Block, Entry, View};

/// Terms of the field of displacement, what is left of it, and correlations of images.
#[derive(Debug)]
pub(super) struct Geometry;

const SLICE_US: i64 = 20_000;
const MAX_SLICES: usize = 8;
/// Large images have enough events in fewer slices.
const MAX_PIXELS: usize = 250_000;
const TILES: (usize, usize) = (6, 4);
/// Events of one pixel in one slice beyond this tell nothing about geometry.
const MAX_COUNT: f32 = 8.0;
const TERMS: usize = 5;
/// Pixels at the border where the smooth images end in nothing, which does not move.
const BORDER: usize = 5;
/// Displacements beyond this are not found by gradients.
const MAX_PX: f64 = 5.0;
/// What pulls displacements to zero where the reference has few events or no gradient: a share of
/// its gradients, and as many squared counts.
const RIDGE: (f64, f64) = (0.005, 5.0);
const TOLERANCE_PX: f64 = 0.05;
const TOLERANCE: f64 = 0.02;

/// Equations of the displacement of a tile: their symmetric matrix and their right side.
#[derive(Debug, Clone, Copy, Default)]
struct Tile {
    xx: f64,
    xy: f64,
    yy: f64,
    bx: f64,
    by: f64,
    /// Squares of the gradient of the reference.
    weight: f64,
}

impl Tile {
    fn ridge(&self) -> f64 {
        RIDGE.0 * self.weight + RIDGE.1
    }

    fn displacement(&self) -> (f64, f64) {
        let (xx, yy) = (self.xx + self.ridge(), self.yy + self.ridge());
        let scale = xx * yy - self.xy * self.xy;
        if scale < self.ridge().powi(2) {
            return (0.0, 0.0);
        }
        let dx = (yy * self.bx - self.xy * self.by) / scale;
        let dy = (xx * self.by - self.xy * self.bx) / scale;
        (dx.clamp(-MAX_PX, MAX_PX), dy.clamp(-MAX_PX, MAX_PX))
    }
}

/// Signed counts of the slices in which the reference has most events, measured and expected.
fn images(view: &View<'_>) -> Vec<[Image; 2]> {
    let size = view.size();
    let slices = (view.window.length().0 / SLICE_US).max(1) as usize;
    let slice_of = |t_us: i64| (view.since_start_us(t_us) / SLICE_US) as usize;
    let mut expected: Vec<(usize, usize, f32)> = Vec::new();
    let mut counts = vec![0_u32; slices];
    for list in reference::lists(view, view.window) {
        let sign = if list.is_on { 1.0 } else { -1.0 };
        for slice in list.t_us.iter().map(|t| slice_of(*t)).filter(|slice| *slice < slices) {
            counts[slice] += 1;
            expected.push((slice, list.pixel, sign));
        }
    }
    let mut order: Vec<usize> = (0..slices).filter(|slice| counts[*slice] > 0).collect();
    order.sort_by_key(|slice| (std::cmp::Reverse(counts[*slice]), *slice));
    order.truncate((MAX_PIXELS / size.pixels()).clamp(2, MAX_SLICES));
    let mut image_of = vec![None; slices];
    order.iter().enumerate().for_each(|(image, slice)| image_of[*slice] = Some(image));
    let zeros = || Image::zeros(usize::from(size.width), usize::from(size.height));
    let mut images: Vec<[Image; 2]> = order.iter().map(|_| [zeros(), zeros()]).collect();
    for (slice, pixel, sign) in expected {
        if let Some(image) = image_of[slice] {
            images[image][1].data[pixel] += sign;
        }
    }
    for event in view.events() {
        if let Some(Some(image)) = image_of.get(slice_of(event.t_us)) {
            let sign = if event.is_on { 1.0 } else { -1.0 };
            images[*image][0].data[event.pixel as usize] += sign;
        }
    }
    for count in images.iter_mut().flatten().flat_map(|image| &mut image.data) {
        *count = count.clamp(-MAX_COUNT, MAX_COUNT);
    }
    images
}

/// Adds what two smooth images say about displacement.
fn add_moments(measured: &Image, expected: &Image, tiles: &mut [Tile]) {
    let (width, height) = (expected.width, expected.height());
    for y in BORDER..height.saturating_sub(BORDER) {
        let row = y * TILES.1 / height * TILES.0;
        for x in BORDER..width.saturating_sub(BORDER) {
            let at = y * width + x;
            let (rx, ry) = expected.gradient(at);
            if rx == 0.0 && ry == 0.0 {
                continue;
            }
            let (mx, my) = measured.gradient(at);
            let (ax, ay) = (0.5 * (rx + mx), 0.5 * (ry + my));
            let change = expected.data[at] - measured.data[at];
            let tile = &mut tiles[row + x * TILES.0 / width];
            tile.xx += f64::from(rx * ax);
            tile.xy += 0.5 * f64::from(rx * ay + ry * ax);
            tile.yy += f64::from(ry * ay);
            tile.bx += f64::from(rx * change);
            tile.by += f64::from(ry * change);
            tile.weight += f64::from(rx * rx + ry * ry);
        }
    }
}

/// How shift in x and y, scale, rotation and the cube of the radius move the centre of a tile, in
/// units of half the diagonal of the image.
fn basis(tile: usize, aspect: f64) -> [[f64; TERMS]; 2] {
    let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * 2.0 - 1.0;
    let half = (1.0 + aspect * aspect).sqrt();
    let (x, y) = (at(tile % TILES.0, TILES.0) / half, aspect * at(tile / TILES.0, TILES.1) / half);
    let square = x * x + y * y;
    [[1.0, 0.0, x, -y, x * square], [0.0, 1.0, y, x, y * square]]
}

/// Least squares over tiles.
fn field(tiles: &[Tile], bases: &[[[f64; TERMS]; 2]]) -> [f64; TERMS] {
    let mut matrix = [[0.0; TERMS + 1]; TERMS];
    for (tile, [bx, by]) in tiles.iter().zip(bases) {
        for (i, row) in matrix.iter_mut().enumerate() {
            let (along, across) =
                (tile.xx * bx[i] + tile.xy * by[i], tile.xy * bx[i] + tile.yy * by[i]);
            for j in 0..TERMS {
                row[j] += along * bx[j] + across * by[j];
            }
            row[TERMS] += tile.bx * bx[i] + tile.by * by[i];
        }
    }
    let ridge = tiles.iter().map(Tile::ridge).sum::<f64>() / tiles.len() as f64;
    (0..TERMS).for_each(|i| matrix[i][i] += ridge);
    solved(matrix).map(|term| term.clamp(-MAX_PX, MAX_PX))
}

/// Gauss elimination with pivots; a term that nothing says anything about is zero.
fn solved(mut matrix: [[f64; TERMS + 1]; TERMS]) -> [f64; TERMS] {
    for i in 0..TERMS {
        let pivot = (i..TERMS).max_by(|a, b| matrix[*a][i].abs().total_cmp(&matrix[*b][i].abs()));
        matrix.swap(i, pivot.unwrap_or(i));
        if matrix[i][i].abs() < 1e-9 {
            return [0.0; TERMS];
        }
        let row = matrix[i];
        for (_, other) in matrix.iter_mut().enumerate().filter(|(j, _)| *j != i) {
            let factor = other[i] / row[i];
            other.iter_mut().zip(row).for_each(|(value, take)| *value -= factor * take);
        }
    }
    std::array::from_fn(|i| matrix[i][TERMS] / matrix[i][i])
}

/// What displacements of tiles are from those of the field, root of mean squares.
fn rest(tiles: &[Tile], bases: &[[[f64; TERMS]; 2]], terms: &[f64; TERMS]) -> f64 {
    let (mut squares, mut weights) = (0.0, 0.0);
    for (tile, [bx, by]) in tiles.iter().zip(bases) {
        let (dx, dy) = tile.displacement();
        let along = |basis: &[f64; TERMS]| -> f64 {
            basis.iter().zip(terms).map(|(b, term)| b * term).sum()
        };
        squares += tile.weight * ((dx - along(bx)).powi(2) + (dy - along(by)).powi(2));
        weights += tile.weight;
    }
    (squares / (weights + RIDGE.1 * tiles.len() as f64)).sqrt()
}

impl Probe for Geometry {
    fn entries(&self) -> Vec<Entry> {
        let terms = [
            "shift in x",
            "shift in y",
            "scale, at the corner",
            "rotation, at the corner",
            "cube of the radius, at the corner",
            "rest of displacement",
        ];
        let terms =
            terms.map(|name| Entry::number(Block::Geometry, format!("{name}, px"), TOLERANCE_PX));
        let likeness = [0, 1, 2].map(|blur| {
            let name = format!("correlation of images, blur {blur} px");
            Entry::number(Block::Geometry, name, TOLERANCE)
        });
        terms.into_iter().chain(likeness).collect()
    }

    fn measure(&self, view: &View<'_>, out: &mut Vec<f64>) {
        let mut tiles = [Tile::default(); TILES.0 * TILES.1];
        // Of measured and expected, measured and measured, expected and expected.
        let mut products = [[0.0; 3]; 3];
        for [mut measured, mut expected] in images(view) {
            for (blur, products) in products.iter_mut().enumerate() {
                if blur > 0 {
                    measured = measured.smoothed(blur);
                    expected = expected.smoothed(blur);
                }
                products[0] += dot(&measured.data, &expected.data);
                products[1] += dot(&measured.data, &measured.data);
                products[2] += dot(&expected.data, &expected.data);
            }
            add_moments(&measured, &expected, &mut tiles);
        }
        let size = view.size();
        let aspect = f64::from(size.height) / f64::from(size.width);
        let bases: Vec<_> = (0..tiles.len()).map(|tile| basis(tile, aspect)).collect();
        let terms = field(&tiles, &bases);
        out.extend(terms);
        out.push(rest(&tiles, &bases, &terms));
        out.extend(products.map(|[both, measured, expected]| {
            let scale = (measured * expected).sqrt();
            if scale > 0.0 { both / scale } else { 0.0 }
        }));
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream};

    use super::*;
    use crate::probe::testing;

    fn moved(map: impl Fn(f64, f64) -> (f64, f64)) -> EventStream {
        testing::changed(|event| {
            let (x, y) = map(f64::from(event.x), f64::from(event.y));
            let (x, y) = (x.round(), y.round());
            let is_inside = (0.0..96.0).contains(&x) && (0.0..72.0).contains(&y);
            is_inside.then_some(Event { x: x as u16, y: y as u16, ..event })
        })
    }

    fn number(events: &EventStream, name: &str) -> f64 {
        testing::number(&Geometry, events, name)
    }

    #[test]
    fn events_in_their_place_are_not_displaced() {
        for entry in Geometry.entries() {
            let value = number(testing::events(), &entry.name);
            let expected = if entry.name.starts_with("correlation") { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-3, "{}: {value}", entry.name);
        }
    }

    #[test]
    fn a_shift_by_a_pixel_is_a_pixel() {
        for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (1.0, -1.0)] {
            let shifted = moved(|x, y| (x + dx, y + dy));
            let found = ["x", "y"].map(|axis| number(&shifted, &format!("shift in {axis}, px")));
            assert!((found[0] - dx).abs() < 0.1, "{dx} {dy}: {found:?}");
            assert!((found[1] - dy).abs() < 0.1, "{dx} {dy}: {found:?}");
            assert!(number(&shifted, "correlation of images, blur 0 px") < 0.95);
        }
    }

    #[test]
    fn noise_does_not_shrink_a_shift() {
        let shifted = moved(|x, y| (x + 1.0, y));
        let noisy = testing::stream(shifted.iter().chain(testing::noise(20_000, 7)));
        let dx = number(&noisy, "shift in x, px");
        assert!((dx - 1.0).abs() < 0.15, "{dx}");
    }

    #[test]
    fn scale_and_rotation_are_those_at_the_corner() {
        let (cx, cy) = (47.5, 35.5);
        let corner = f64::from(48 * 48 + 36 * 36).sqrt();
        let scaled = moved(|x, y| (cx + (x - cx) * 1.03, cy + (y - cy) * 1.03));
        let found = number(&scaled, "scale, at the corner, px")
            + number(&scaled, "cube of the radius, at the corner, px");
        assert!((found - 0.03 * corner).abs() < 0.4, "{found}");
        let turned = moved(|x, y| (x - 0.03 * (y - cy), y + 0.03 * (x - cx)));
        let found = number(&turned, "rotation, at the corner, px");
        assert!((found - 0.03 * corner).abs() < 0.4, "{found}");
    }

    #[test]
    fn a_system_of_equations_is_solved() {
        let matrix = [
            [0.0, 2.0, 0.0, 0.0, 1.0, 9.0],
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 3.0, 0.0, 0.0, 9.0],
            [0.0, 0.0, 1.0, 1.0, 0.0, 7.0],
            [1.0, 0.0, 0.0, 0.0, 1.0, 6.0],
        ];
        assert_eq!(solved(matrix), [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(solved([[0.0; TERMS + 1]; TERMS]), [0.0; TERMS]);
    }
}
