//! From a signed distance to a closed mesh of quadrilaterals.
//!
//! # Model
//! Naive surface nets: one vertex in every cell of a grid that the surface passes, at the mean of
//! the crossings of the cell's edges, and one quadrilateral around every edge that crosses. The
//! grid follows the arm: slices across it with square cells whose size grows towards the shoulder,
//! so that a finger gets as many vertices around as the upper arm.
//!
//! # Source
//! Gibson, *Constrained Elastic Surface Nets* (MICCAI 1998).

use glam::Vec3;

use super::frame::WRIST_M;

/// Where slices lie along x and the size of their cells, both in metres; linear between. Fine for
/// the fingers, coarser for palm and thumb, coarsest for the upper arm.
const CELL_SIZES_M: [(f32, f32); 6] = [
    (-0.888, 0.0046),
    (-0.785, 0.0046),
    (-0.745, 0.0059),
    (-0.660, 0.0066),
    (-0.560, 0.0140),
    (-0.090, 0.0230),
];
/// Centre of every slice.
const AXIS_M: Vec3 = Vec3::new(0.0, WRIST_M.y - 0.003, WRIST_M.z + 0.008);
/// Cells of a slice below and above its centre.
const HALF_HEIGHT_CELLS: usize = 10;
/// Cells of a slice behind and before its centre: room for the thumb.
const HALF_DEPTH_CELLS: usize = 17;

const HEIGHT: usize = 2 * HALF_HEIGHT_CELLS + 1;
const DEPTH: usize = 2 * HALF_DEPTH_CELLS + 1;
const SLICE: usize = HEIGHT * DEPTH;
/// Grid points to the next one along x, y and z.
const STRIDES: [usize; 3] = [SLICE, DEPTH, 1];
/// How deep a filled grid point lies: little, so that the surface hardly moves.
const FILLED_M: f32 = 1e-5;

/// A closed surface: vertices and outward-facing quadrilaterals, counterclockwise from outside.
pub(super) struct QuadMesh {
    pub(super) vertices_m: Vec<Vec3>,
    pub(super) quads: Vec<[u32; 4]>,
}

/// Size of the cells of the slice at `x_m`; `None` beyond the last slice.
fn cell_size_m(x_m: f32) -> Option<f32> {
    CELL_SIZES_M.windows(2).find_map(|ends| {
        let [(start, size), (end, next_size)] = [ends[0], ends[1]];
        let t = (x_m - start) / (end - start);
        (t < 1.0).then_some(size + (next_size - size) * t)
    })
}

/// Grid points, slice by slice, each row by row.
fn grid() -> Vec<Vec3> {
    let mut points_m = Vec::new();
    let mut x_m = CELL_SIZES_M[0].0;
    while let Some(size_m) = cell_size_m(x_m) {
        for (row, column) in (0..HEIGHT).flat_map(|row| (0..DEPTH).map(move |c| (row, c))) {
            let up = row as f32 - HALF_HEIGHT_CELLS as f32;
            let forward = column as f32 - HALF_DEPTH_CELLS as f32;
            points_m.push(AXIS_M.with_x(x_m) + Vec3::new(0.0, up, forward) * size_m);
        }
        x_m += size_m;
    }
    points_m
}

/// The surface where `distance` is zero.
pub(super) fn polygonise(distance: impl Fn(Vec3) -> f32) -> QuadMesh {
    let points_m = grid();
    let mut values: Vec<f32> = points_m.iter().map(|&point_m| distance(point_m)).collect();
    fill_pinches(&mut values);
    let mut mesh = QuadMesh { vertices_m: Vec::new(), quads: Vec::new() };
    let mut vertex_of_cell = vec![u32::MAX; points_m.len()];
    for cell in cells(points_m.len()) {
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
    for cell in cells(points_m.len()) {
        for axis in 0..3 {
            let (u, v) = (STRIDES[(axis + 1) % 3], STRIDES[(axis + 2) % 3]);
            let inside = values[cell] < 0.0;
            if inside == (values[cell + STRIDES[axis]] < 0.0) {
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
fn fill_pinches(values: &mut [f32]) {
    let single: Vec<bool> = (0..=u8::MAX).map(is_single_sheet).collect();
    loop {
        let mut filled = false;
        for cell in cells(values.len()) {
            let inside = (0..8).filter(|&bits| values[cell + corner(bits)] < 0.0);
            let mask = inside.fold(0u8, |mask, bits| mask | 1 << bits);
            if single[usize::from(mask)] {
                continue;
            }
            let outside = (0..8).map(|bits| cell + corner(bits)).filter(|&i| values[i] >= 0.0);
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
fn corner(bits: usize) -> usize {
    (0..3).map(|axis| (bits >> axis & 1) * STRIDES[axis]).sum()
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

/// The first grid point of every cell of a grid of `points`.
fn cells(points: usize) -> impl Iterator<Item = usize> {
    (0..points / SLICE - 1).flat_map(|slice| {
        (0..HEIGHT - 1).flat_map(move |row| {
            (0..DEPTH - 1).map(move |column| slice * SLICE + row * DEPTH + column)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_two_sheets_pass_are_told_apart() {
        assert!(is_single_sheet(0b0000_0001), "one corner");
        assert!(is_single_sheet(0b0000_1111), "one side");
        assert!(!is_single_sheet(0b0000_1001), "across a face");
        assert!(!is_single_sheet(0b1000_0001), "across the cell");
        assert!(!is_single_sheet(0b0111_1110), "the same from outside");
    }
}
