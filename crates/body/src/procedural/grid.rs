//! The sampling grid of the arm's implicit surface.
//!
//! The grid follows the arm: slices across it with square cells whose size grows towards the
//! shoulder, so that a finger gets as many vertices around as the upper arm.

use glam::Vec3;

use super::frame::WRIST_M;
use crate::implicit::Grid;

/// Positions of slices along x and sizes of their cells, both in metres; linear between. Fine for
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

/// Size of the cells of the slice at `x_m`; `None` beyond the last slice.
fn cell_size_m(x_m: f32) -> Option<f32> {
    CELL_SIZES_M.windows(2).find_map(|ends| {
        let [(start, size), (end, next_size)] = [ends[0], ends[1]];
        let t = (x_m - start) / (end - start);
        (t < 1.0).then_some(size + (next_size - size) * t)
    })
}

/// The grid around the arm at rest.
pub(super) fn grid() -> Grid {
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
    let slices = points_m.len() / (HEIGHT * DEPTH);
    Grid { points_m, size: [slices, HEIGHT, DEPTH] }
}
