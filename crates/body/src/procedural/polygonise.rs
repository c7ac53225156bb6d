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

use super::cone::smooth_step;
use super::frame::{ELBOW_M, WRIST_M};

/// Cell size at the hand, the elbow and the shoulder.
const CELLS_M: [f32; 3] = [0.0043, 0.0145, 0.024];
/// Where the first slice lies, beyond the finger tips.
const FIRST_SLICE_X_M: f32 = -0.885;
/// Where slices end, beyond the upper arm.
const LAST_SLICE_X_M: f32 = -0.09;
/// Slices have cells from -`HALF_CELLS` to `HALF_CELLS` around the arm's axis, down and up.
const HALF_HEIGHT_CELLS: usize = 12;
/// The same, back and forward: room for the thumb.
const HALF_DEPTH_CELLS: usize = 21;

const HEIGHT: usize = 2 * HALF_HEIGHT_CELLS + 1;
const DEPTH: usize = 2 * HALF_DEPTH_CELLS + 1;
const SLICE: usize = HEIGHT * DEPTH;

/// A closed surface: vertices and outward-facing quadrilaterals, counterclockwise from outside.
pub(super) struct QuadMesh {
    pub(super) vertices_m: Vec<Vec3>,
    pub(super) quads: Vec<[u32; 4]>,
}

/// Size of the cells of the slice at `x_m`.
fn cell_size(x_m: f32) -> f32 {
    let [hand, elbow, shoulder] = CELLS_M;
    let beyond_wrist = WRIST_M.x + 0.015;
    if x_m < ELBOW_M.x {
        hand + (elbow - hand) * smooth_step(beyond_wrist, ELBOW_M.x + 0.05, x_m)
    } else {
        let from = hand + (elbow - hand) * smooth_step(beyond_wrist, ELBOW_M.x + 0.05, ELBOW_M.x);
        from + (shoulder - from) * smooth_step(ELBOW_M.x, LAST_SLICE_X_M, x_m)
    }
}

/// Grid points, slice by slice.
fn grid() -> Vec<Vec3> {
    let mut points_m = Vec::new();
    let mut x_m = FIRST_SLICE_X_M;
    while x_m < LAST_SLICE_X_M {
        let size_m = cell_size(x_m);
        for row in 0..HEIGHT {
            for column in 0..DEPTH {
                let up = row as f32 - HALF_HEIGHT_CELLS as f32;
                let forward = column as f32 - HALF_DEPTH_CELLS as f32;
                points_m.push(Vec3::new(x_m, WRIST_M.y + up * size_m, WRIST_M.z + 0.008 + forward * size_m));
            }
        }
        x_m += size_m;
    }
    points_m
}

/// The surface where `distance` is zero.
pub(super) fn polygonise(distance: impl Fn(Vec3) -> f32) -> QuadMesh {
    let points_m = grid();
    let values: Vec<f32> = points_m.iter().map(|&point_m| distance(point_m)).collect();
    // Offsets of a cell's corners from its first one; bit 0 is x, bit 1 y, bit 2 z.
    let strides = [SLICE, DEPTH, 1];
    let corner = |bits: usize| (0..3).map(|axis| (bits >> axis & 1) * strides[axis]).sum::<usize>();
    let mut vertex_of_cell = vec![u32::MAX; points_m.len()];
    let mut mesh = QuadMesh { vertices_m: Vec::new(), quads: Vec::new() };

    let slices = points_m.len() / SLICE;
    for (slice, row, column) in cells(slices) {
        let first = slice * SLICE + row * DEPTH + column;
        let (mut sum, mut crossings) = (Vec3::ZERO, 0.0);
        for (a, b) in CELL_EDGES {
            let (a, b) = (first + corner(a), first + corner(b));
            if (values[a] < 0.0) != (values[b] < 0.0) {
                let t = values[a] / (values[a] - values[b]);
                sum += points_m[a].lerp(points_m[b], t);
                crossings += 1.0;
            }
        }
        if crossings > 0.0 {
            vertex_of_cell[first] = mesh.vertices_m.len() as u32;
            mesh.vertices_m.push(sum / crossings);
        }
    }

    for (slice, row, column) in cells(slices) {
        let first = slice * SLICE + row * DEPTH + column;
        for axis in 0..3 {
            let (u, v) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
            let inside = values[first] < 0.0;
            if inside == (values[first + strides[axis]] < 0.0) {
                continue;
            }
            // The grid ends outside the surface, so all four cells around the edge exist.
            let around = [first - u - v, first - v, first, first - u].map(|cell| vertex_of_cell[cell]);
            let [a, b, c, d] = around;
            mesh.quads.push(if inside { [a, b, c, d] } else { [d, c, b, a] });
        }
    }
    mesh
}

/// The twelve edges of a cell as pairs of corners.
const CELL_EDGES: [(usize, usize); 12] = [
    (0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7),
];

/// Slice, row and column of every cell.
fn cells(slices: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..slices - 1).flat_map(|slice| {
        (0..HEIGHT - 1).flat_map(move |row| (0..DEPTH - 1).map(move |column| (slice, row, column)))
    })
}
