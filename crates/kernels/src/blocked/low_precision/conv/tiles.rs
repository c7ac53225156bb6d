//! Convolution by products of tiles (AMX).

use std::marker::PhantomData;
use std::ops::Range;

use super::ConvExec;
use super::packing::TapGroups;
use crate::blocked::conv_shape::ConvShape;
use crate::simd::tiles::{TILE_ROW_BYTES, TILE_ROWS, TileConfig, TileElement, TileShape, TileUnit};
use crate::simd::{Kernel, LANES, Lanes};

/// Sums of the first and second pixels by the first and second block of output channels.
const SUMS_00: usize = 0;
const SUMS_01: usize = 1;
const SUMS_10: usize = 2;
const SUMS_11: usize = 3;
/// Inputs of the first and second pixels.
const INPUTS_0: usize = 4;
const INPUTS_1: usize = 5;
/// Weights of the first and second block.
const WEIGHTS_0: usize = 6;
const WEIGHTS_1: usize = 7;

/// A stored tile of sums: 16 output channels of each of 16 pixels.
#[repr(align(64))]
#[derive(Clone, Copy)]
struct Sums<T>([[T; LANES]; TILE_ROWS]);

/// Kernel for some rows of one group of one or two channel blocks, on a unit with tiles.
///
/// A row of an input tile is a pixel: the channels of a block at neighbouring taps lie side by side
/// in the image, and are read where they lie.
pub(super) struct TileKernel<'a, S, U> {
    exec: &'a ConvExec<'a>,
    blocks: Range<usize>,
    rows: Range<usize>,
    /// Packed weights of the group.
    weights: *const u8,
    /// Pixels of a tile. They divide a row of the output; the last ones of a row may be some of
    /// the tile before, which are then computed twice.
    pixels: usize,
    taps: TapGroups,
    unit: PhantomData<(S, U)>,
}

impl<'a, S: TileElement, U: TileUnit> TileKernel<'a, S, U> {
    /// A kernel for the channel blocks `blocks`, whose packed weights are at `weights`.
    pub(super) fn new(
        exec: &'a ConvExec<'a>,
        blocks: Range<usize>,
        rows: Range<usize>,
        weights: *const u8,
    ) -> Self {
        let [_, _, width] = exec.size;
        let pixels = width.div_ceil(width.div_ceil(TILE_ROWS));
        let taps = TapGroups::new(exec.conv.shape.kernel[1], S::DEPTH);
        Self { exec, blocks, rows, weights, pixels, taps, unit: PhantomData }
    }

    /// Rows of a tile of weights: a word of channels each.
    fn weight_rows(&self) -> usize {
        self.taps.taps * LANES / S::DEPTH
    }

    fn config(&self) -> TileConfig {
        let (pixels, depth) = (self.pixels, self.weight_rows());
        let sums = TileShape { rows: pixels, row_bytes: TILE_ROW_BYTES };
        let inputs = TileShape { rows: pixels, row_bytes: 4 * depth };
        let weights = TileShape { rows: depth, row_bytes: TILE_ROW_BYTES };
        TileConfig::new([sums, sums, sums, sums, inputs, inputs, weights, weights])
    }
}

impl<S: TileElement, U: TileUnit> Kernel for TileKernel<'_, S, U> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [_, _, width] = self.exec.size;
        let mut sums = [[Sums([[S::Sum::default(); LANES]; TILE_ROWS]); 2]; 2];
        // The last tile overlaps the one before, so that all are equally wide.
        let column = |tile: usize| (tile * self.pixels).min(width - self.pixels);
        let tiles = width.div_ceil(self.pixels);
        // SAFETY: the caller's; pixels are inside the output.
        unsafe {
            let mut unit = U::configure(&self.config());
            for y in self.rows.clone() {
                // Two tiles share the weights that were loaded.
                for first in (0..tiles).step_by(2) {
                    let second = (first + 1 < tiles).then(|| column(first + 1));
                    let columns = [Some(column(first)), second];
                    self.multiply(&mut unit, y, columns, &mut sums);
                    for (x, sums) in columns.iter().flatten().zip(&sums) {
                        for (block, sums) in self.blocks.clone().zip(sums) {
                            self.exec.store(block, [y, *x], self.pixels, |pixel| {
                                V::load(sums.0[pixel].map(S::sum_to_f32).as_ptr())
                            });
                        }
                    }
                }
            }
            unit.release();
        }
    }
}

impl<S: TileElement, U: TileUnit> TileKernel<'_, S, U> {
    /// Computes the sums of the pixels of row `y` from the one or two columns on.
    ///
    /// # Safety
    /// That of [`Kernel::run`]; the pixels are inside the output.
    #[inline(always)]
    unsafe fn multiply(
        &self,
        unit: &mut U,
        y: usize,
        columns: [Option<usize>; 2],
        sums: &mut [[Sums<S::Sum>; 2]; 2],
    ) {
        let ConvExec { conv, input, .. } = self.exec;
        let ConvShape { channels_in, kernel: [kernel, _], stride, .. } = conv.shape;
        let pixel_bytes = LANES * size_of::<S>();
        let row_bytes = input.row_pitch() * pixel_bytes;
        let weight_pitch = self.blocks.len() * TILE_ROW_BYTES;
        let (is_wide, is_deep) = (columns[1].is_some(), self.blocks.len() == 2);
        let mut weights = self.weights;
        // SAFETY: the caller's. A tile's rows are the taps of pixels of the output, which are
        // inside the input and its border; weights are packed in this order.
        unsafe {
            // All four are stored below, those that are not used as well.
            unit.zero::<SUMS_00>();
            unit.zero::<SUMS_01>();
            unit.zero::<SUMS_10>();
            unit.zero::<SUMS_11>();
            for block in 0..channels_in.div_ceil(LANES) {
                let window = |x| input.tap::<S>(block, y * stride, x * stride, kernel / 2).cast();
                let window = columns.map(|x| x.map_or(std::ptr::null::<u8>(), window));
                for ky in 0..kernel {
                    for kx in self.taps.first_taps() {
                        let at = ky * row_bytes + kx * pixel_bytes;
                        // Each tile of weights and of inputs is loaded once for two products.
                        unit.load::<WEIGHTS_0>(weights, weight_pitch);
                        unit.load::<INPUTS_0>(window[0].add(at), stride * pixel_bytes);
                        S::add_products::<U, SUMS_00, INPUTS_0, WEIGHTS_0>(unit);
                        if is_wide {
                            unit.load::<INPUTS_1>(window[1].add(at), stride * pixel_bytes);
                            S::add_products::<U, SUMS_10, INPUTS_1, WEIGHTS_0>(unit);
                        }
                        if is_deep {
                            unit.load::<WEIGHTS_1>(weights.add(TILE_ROW_BYTES), weight_pitch);
                            S::add_products::<U, SUMS_01, INPUTS_0, WEIGHTS_1>(unit);
                            if is_wide {
                                S::add_products::<U, SUMS_11, INPUTS_1, WEIGHTS_1>(unit);
                            }
                        }
                        // Packed in the order of these loops, so that one pointer moves on.
                        weights = weights.add(self.weight_rows() * weight_pitch);
                    }
                }
            }
            let [[sums_00, sums_01], [sums_10, sums_11]] =
                sums.each_mut().map(|sums| sums.each_mut().map(|sums| sums.0.as_mut_ptr().cast()));
            unit.store::<SUMS_00>(sums_00, TILE_ROW_BYTES);
            unit.store::<SUMS_01>(sums_01, TILE_ROW_BYTES);
            unit.store::<SUMS_10>(sums_10, TILE_ROW_BYTES);
            unit.store::<SUMS_11>(sums_11, TILE_ROW_BYTES);
        }
    }
}
