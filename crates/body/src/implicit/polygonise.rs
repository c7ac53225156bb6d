//! From a signed distance to a closed mesh of quadrilaterals.
//!
//! # Model
//! Naive surface nets: one vertex in every cell of a grid that the surface passes, at the mean of
//! the crossings of the cell's edges, and one quadrilateral around every edge that crosses.
//!
//! # Source
//! Gibson, *Constrained Elastic Surface Nets* (MICCAI 1998).

use glam::Vec3;

/// Points at which a distance is looked up: slices of rows of points, not necessarily evenly
/// spaced.
pub(crate) struct Grid {
    /// Slice by slice, each row by row.
    pub(crate) points_m: Vec<Vec3>,
    /// Slices, rows of a slice, points of a row.
    pub(crate) size: [usize; 3],
}

impl Grid {
    /// Cubic cells of `cell_m` between two corners, the upper of which may be passed by less than a
    /// cell.
    pub(crate) fn even(low_m: Vec3, high_m: Vec3, cell_m: f32) -> Self {
        let size = ((high_m - low_m) / cell_m).ceil().to_array().map(|cells| cells as usize + 1);
        let mut points_m = Vec::with_capacity(size.iter().product());
        for x in 0..size[0] {
            for y in 0..size[1] {
                let place = |z: usize| Vec3::new(x as f32, y as f32, z as f32);
                points_m.extend((0..size[2]).map(|z| low_m + place(z) * cell_m));
            }
        }
        Self { points_m, size }
    }

    /// Grid points to the next one along x, y and z.
    fn strides(&self) -> [usize; 3] {
        [self.size[1] * self.size[2], self.size[2], 1]
    }

    /// The first grid point of every cell.
    fn cells(&self) -> impl Iterator<Item = usize> + use<> {
        let ([slices, rows, columns], [slice, row, _]) = (self.size, self.strides());
        (0..slices - 1).flat_map(move |x| {
            (0..rows - 1).flat_map(move |y| (0..columns - 1).map(move |z| x * slice + y * row + z))
        })
    }
}

/// How deep a filled grid point lies: little, so that the surface hardly moves.
const FILLED_M: f32 = 1e-5;

/// A closed surface: vertices and outward-facing quadrilaterals, counterclockwise from outside.
pub(crate) struct QuadMesh {
    pub(crate) vertices_m: Vec<Vec3>,
    pub(crate) quads: Vec<[u32; 4]>,
}

/// The surface where `distance` is zero. All of it has to lie within `grid`.
pub(crate) fn polygonise(distance: impl Fn(Vec3) -> f32, grid: &Grid) -> QuadMesh {
    let (points_m, strides) = (&grid.points_m, grid.strides());
    let corner = |bits: usize| corner(strides, bits);
    let mut values: Vec<f32> = points_m.iter().map(|&point_m| distance(point_m)).collect();
    // A cell with two sheets of surface would join both in one vertex.
    fill_pinches(&mut values, grid);
    let mut mesh = QuadMesh { vertices_m: Vec::new(), quads: Vec::new() };
    let mut vertex_of_cell = vec![u32::MAX; points_m.len()];
    for cell in grid.cells() {
        // One vertex a cell, amid the crossings of its edges.
        let (mut sum, mut crossings) = (Vec3::ZERO, 0.0);
        for (a, b) in CELL_EDGES {
            let (a, b) = (cell + corner(a), cell + corner(b));
            if (values[a] < 0.0) != (values[b] < 0.0) {
                sum += points_m[a].lerp(points_m[b], values[a] / (values[a] - values[b]));
                crossings += 1.0;
            }
        }
        if crossings > 0.0 {
            vertex_of_cell[cell] = mesh.vertices_m.len() as u32;
            mesh.vertices_m.push(sum / crossings);
        }
    }
    for cell in grid.cells() {
        for axis in 0..3 {
            let (u, v) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
            // Where an edge crosses the surface, the four cells around it share a face.
            let inside = values[cell] < 0.0;
            if inside == (values[cell + strides[axis]] < 0.0) {
                continue;
            }
            // The grid ends outside the surface, so all four cells around the edge exist.
            let [a, b, c, d] =
                [cell - u - v, cell - v, cell, cell - u].map(|cell| vertex_of_cell[cell]);
            mesh.quads.push(if inside { [a, b, c, d] } else { [d, c, b, a] });
        }
    }
    mesh
}

/// Adds grid points to the inside until no cell has two sheets of surface to make one vertex of.
///
/// A sheet that passes a cell twice would meet itself there, with edges between four faces.
fn fill_pinches(values: &mut [f32], grid: &Grid) {
    let strides = grid.strides();
    let corner = |bits: usize| corner(strides, bits);
    let single: Vec<bool> = (0..=u8::MAX).map(is_single_sheet).collect();
    // Again and again, since a filled point may pinch a neighbouring cell.
    loop {
        let mut filled = false;
        for cell in grid.cells() {
            let inside = (0..8).filter(|&bits| values[cell + corner(bits)] < 0.0);
            let mask = inside.fold(0u8, |mask, bits| mask | 1 << bits);
            if single[usize::from(mask)] {
                continue;
            }
            let outside = (0..8).map(|bits| cell + corner(bits)).filter(|&i| values[i] >= 0.0);
            // The point nearest to the surface changes the shape least.
            if let Some(nearest) = outside.min_by(|&a, &b| values[a].total_cmp(&values[b])) {
                values[nearest] = -FILLED_M;
                filled = true;
            }
        }
        if !filled {
            return;
        }
    }
}

/// Whether one sheet of surface passes a cell whose corners in `mask` are inside.
fn is_single_sheet(mask: u8) -> bool {
    let crossed_face = (0..3).any(|axis| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        [0, 1 << axis].into_iter().any(|first| {
            let [a, b, c, d] =
                [first, first | u, first | u | v, first | v].map(|bits: usize| mask >> bits & 1);
            a == c && b == d && a != b
        })
    });
    !crossed_face && is_connected(mask) && is_connected(!mask)
}

/// Whether the corners in `mask` hang together along edges of the cell.
fn is_connected(mask: u8) -> bool {
    let mut reached = mask & mask.wrapping_neg();
    for _ in 0..8 {
        for (a, b) in CELL_EDGES {
            if (reached >> a & 1) != (reached >> b & 1) {
                reached |= (1 << a | 1 << b) & mask;
            }
        }
    }
    reached == mask
}

/// Offset of a cell's corner from its first grid point; bit 0 is x, bit 1 y, bit 2 z.
fn corner(strides: [usize; 3], bits: usize) -> usize {
    (0..3).map(|axis| (bits >> axis & 1) * strides[axis]).sum()
}

/// The twelve edges of a cell as pairs of corners.
const CELL_EDGES: [(usize, usize); 12] = [
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_two_sheets_pass_are_distinguished() {
        assert!(is_single_sheet(0b0000_0001), "one corner");
        assert!(is_single_sheet(0b0000_1111), "one side");
        assert!(!is_single_sheet(0b0000_1001), "across a face");
        assert!(!is_single_sheet(0b1000_0001), "across the cell");
        assert!(!is_single_sheet(0b0111_1110), "the same from outside");
    }
}
