//! The displacement between two smooth images, as a field over tiles.
//!
//! # Model
//! A displacement `d` makes of an image `R` an image `M` with `M - R = -d (grad R + grad M) / 2`,
//! up to its third power. It is solved for by least squares with `grad R` as the instrument, so
//! that noise of `M` does not shrink it, and the field over tiles is split into shift, scale,
//! rotation and a term in the cube of the radius.

use evpose_core::stats::linear::solve;

use crate::probe::image::Image;

pub(crate) const TILES: (usize, usize) = (6, 4);
/// Shift in x and in y, scale, rotation and the cube of the radius, the latter at the corner.
pub(super) const TERMS: usize = 5;
/// Width of the border, pixels, in which smoothed images are truncated.
const BORDER: usize = 5;
/// Largest displacement, pixels, that image gradients can determine.
const MAX_PX: f64 = 5.0;
/// Ridge regularisation where the reference has few events or no gradient: a fraction of the
/// squared gradients, and a constant in squared counts.
const RIDGE: (f64, f64) = (0.005, 5.0);

/// Smallest sum of squared gradients of a tile whose displacement is determined.
const MIN_GRADIENT: f64 = 10.0;

/// Normal equations of the displacement of a tile: symmetric matrix and right side.
#[derive(Debug, Clone, Copy, Default)]
struct Tile {
    xx: f64,
    xy: f64,
    yy: f64,
    bx: f64,
    by: f64,
    /// Sum of squared gradients of the reference.
    weight: f64,
}

impl Tile {
    fn ridge(&self) -> f64 {
        RIDGE.0 * self.weight + RIDGE.1
    }

    fn displacement(&self) -> (f64, f64) {
        let (xx, yy) = (self.xx + self.ridge(), self.yy + self.ridge());
        let scale = xx * yy - self.xy * self.xy;
        // Edges of one direction only: the motion along them is not determined.
        if scale < self.ridge().powi(2) {
            return (0.0, 0.0);
        }
        let dx = (yy * self.bx - self.xy * self.by) / scale;
        let dy = (xx * self.by - self.xy * self.bx) / scale;
        (dx.clamp(-MAX_PX, MAX_PX), dy.clamp(-MAX_PX, MAX_PX))
    }
}

/// Displacement field over tiles, from pairs of images.
#[derive(Debug, Default)]
pub(super) struct Displacement {
    tiles: [Tile; TILES.0 * TILES.1],
}

impl Displacement {
    pub(super) fn add(&mut self, measured: &Image, expected: &Image) {
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
                // Gradients of both images, averaged: second order in the displacement, without
                // iterations.
                let (ax, ay) = (0.5 * (rx + mx), 0.5 * (ry + my));
                let change = expected.data[at] - measured.data[at];
                let tile = &mut self.tiles[row + x * TILES.0 / width];
                tile.xx += f64::from(rx * ax);
                tile.xy += 0.5 * f64::from(rx * ay + ry * ax);
                tile.yy += f64::from(ry * ay);
                tile.bx += f64::from(rx * change);
                tile.by += f64::from(ry * change);
                tile.weight += f64::from(rx * rx + ry * ry);
            }
        }
    }

    /// Displacements of tiles, row by row; none where too little moves to determine one.
    pub(super) fn of_tiles(&self) -> Vec<Option<(f64, f64)>> {
        let is_determined = |tile: &Tile| tile.weight > MIN_GRADIENT;
        self.tiles.iter().map(|tile| is_determined(tile).then(|| tile.displacement())).collect()
    }

    /// Terms of the field in pixels, and the root mean square of its residuals, for an image of
    /// aspect ratio (height over width) `aspect`.
    pub(super) fn field(&self, aspect: f64) -> ([f64; TERMS], f64) {
        let bases: Vec<_> = (0..self.tiles.len()).map(|tile| basis(tile, aspect)).collect();
        let terms = field(&self.tiles, &bases);
        (terms, rest(&self.tiles, &bases, &terms))
    }
}

/// Displacement of the centre of a tile by a unit of each term: shift in x and y, scale, rotation
/// and the cube of the radius; coordinates in units of half the image diagonal.
fn basis(tile: usize, aspect: f64) -> [[f64; TERMS]; 2] {
    let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * 2.0 - 1.0;
    let half = (1.0 + aspect * aspect).sqrt();
    let (x, y) = (at(tile % TILES.0, TILES.0) / half, aspect * at(tile / TILES.0, TILES.1) / half);
    let square = x * x + y * y;
    [[1.0, 0.0, x, -y, x * square], [0.0, 1.0, y, x, y * square]]
}

/// Least-squares fit of the terms to all tiles.
fn field(tiles: &[Tile], bases: &[[[f64; TERMS]; 2]]) -> [f64; TERMS] {
    let mut matrix = vec![vec![0.0; TERMS]; TERMS];
    let mut right = vec![0.0; TERMS];
    for (tile, [bx, by]) in tiles.iter().zip(bases) {
        for (i, row) in matrix.iter_mut().enumerate() {
            let (along, across) =
                (tile.xx * bx[i] + tile.xy * by[i], tile.xy * bx[i] + tile.yy * by[i]);
            for j in 0..TERMS {
                row[j] += along * bx[j] + across * by[j];
            }
            right[i] += tile.bx * bx[i] + tile.by * by[i];
        }
    }
    // Edges of one direction leave the motion along them open: the ridge takes it to be none.
    let ridge = tiles.iter().map(Tile::ridge).sum::<f64>() / tiles.len() as f64;
    (0..TERMS).for_each(|i| matrix[i][i] += ridge);
    // Without a solution all terms are zero.
    let terms = solve(matrix, right).unwrap_or_else(|| vec![0.0; TERMS]);
    std::array::from_fn(|i| terms[i].clamp(-MAX_PX, MAX_PX))
}

/// Root mean square of the residuals of tiles about the field, weighted.
fn rest(tiles: &[Tile], bases: &[[[f64; TERMS]; 2]], terms: &[f64; TERMS]) -> f64 {
    let (mut squares, mut weights) = (0.0, 0.0);
    for (tile, [bx, by]) in tiles.iter().zip(bases) {
        let (dx, dy) = tile.displacement();
        let along = |basis: &[f64; TERMS]| -> f64 {
            basis.iter().zip(terms).map(|(b, term)| b * term).sum()
        };
        // Weighted by contrast: tiles without edges say nothing.
        squares += tile.weight * ((dx - along(bx)).powi(2) + (dy - along(by)).powi(2));
        weights += tile.weight;
    }
    (squares / (weights + RIDGE.1 * tiles.len() as f64)).sqrt()
}
