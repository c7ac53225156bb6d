//! The algorithm of a 3x3 convolution, by what the candidates cost.
//!
//! # Model
//! Costs are counted in vector instructions of one thread: multiply-adds, and loads and stores where they are
//! more. A register tile of `n` pixels by two blocks of channels multiplies and adds `2 n` times and loads
//! `n + 2` vectors for each input channel. Winograd's algorithm adds its transforms: of inputs, of outputs, and
//! of weights, which are transformed for every image where the transformed ones exceed the L2 cache of this
//! machine. Nothing is timed, so that a network runs by the same algorithms each time.

use evpose_kernels::blocked::{ConvShape, TileSize, Winograd};

use crate::shapes::Shape;

/// Channels of a block.
const LANES: usize = 16;
/// Widest register tile, in pixels or tiles.
const MAX_REGISTER_TILE: usize = 12;
/// Smallest number of channels for Winograd: convolutions of fewer have too few multiplications to
/// save.
const MIN_CHANNELS: usize = 16;
/// Taps of a kernel.
const TAPS: usize = 9;
/// Tile sizes of Winograd's algorithm.
const TILE_SIZES: [TileSize; 3] = [TileSize::Four, TileSize::TwoByFour, TileSize::Two];

/// Tile size of the fastest Winograd algorithm for a convolution whose output is `output`; none if direct
/// convolution is faster.
pub(super) fn winograd_tile(shape: ConvShape, output: Shape) -> Option<TileSize> {
    let is_small = shape.channels_in.min(shape.channels_out) < MIN_CHANNELS;
    if shape.square_side() != Some(3) || shape.stride != 1 || is_small {
        return None;
    }
    let costs = TILE_SIZES.map(|size| (winograd_cost(shape, output, size), size));
    let (cost, size) = costs.into_iter().min_by_key(|(cost, _)| *cost)?;
    (cost < direct_cost(shape, output)).then_some(size)
}

fn direct_cost(shape: ConvShape, [_, height, width]: Shape) -> usize {
    let products = TAPS * shape.channels_in * shape.channels_out.div_ceil(LANES);
    height * products * row_cost(width) / 2
}

/// Cost of Winograd's algorithm.
fn winograd_cost(shape: ConvShape, [_, height, width]: Shape, size: TileSize) -> usize {
    let [rows, columns] = size.outputs();
    let tiles = height.div_ceil(rows) * width.div_ceil(columns);
    let points = size.points();
    let ConvShape { channels_in, channels_out, .. } = shape;
    let [blocks_in, blocks_out] = [channels_in, channels_out].map(|count| count.div_ceil(LANES));
    let gemm = points * channels_in * blocks_out * row_cost(tiles) / 2;
    // A point is loaded, passes two sums along rows and columns, and is stored.
    let inputs = 4 * points * tiles * blocks_in;
    let outputs = 3 * points * tiles * blocks_out;
    let weights = if Winograd::transforms_weights_on_the_fly(shape, size) {
        // A store takes as long as two loads.
        (TAPS + 3 * points) * channels_in * blocks_out
    } else {
        0
    };
    gemm + inputs + outputs + weights
}

/// Cost of `pixels` pixels by one channel of two blocks: register tiles of nearly the same width.
fn row_cost(pixels: usize) -> usize {
    let tiles = pixels.div_ceil(MAX_REGISTER_TILE);
    let width = pixels.div_ceil(tiles.max(1));
    tiles * (2 * width).max(width + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(channels: usize, height: usize, width: usize) -> Option<TileSize> {
        winograd_tile(ConvShape::square(channels, channels, 3, 1), [channels, height, width])
    }

    /// Algorithms that were the fastest on processors with 1 MiB of L2 (measured layer by layer).
    #[test]
    fn layers_of_resnet_get_the_algorithms_that_were_measured_to_be_fastest() {
        assert_eq!(chosen(64, 45, 60), Some(TileSize::Four));
        assert_eq!(chosen(128, 23, 30), Some(TileSize::Four));
        assert_eq!(chosen(256, 12, 15), Some(TileSize::Four));
        assert_eq!(chosen(512, 6, 8), Some(TileSize::TwoByFour));
    }

    #[test]
    fn a_pixel_is_convolved_directly_and_so_are_few_channels_and_strides() {
        assert_eq!(chosen(512, 1, 1), None);
        assert_eq!(chosen(8, 40, 40), None);
        assert_eq!(winograd_tile(ConvShape::square(64, 64, 3, 2), [64, 40, 40]), None);
    }
}
