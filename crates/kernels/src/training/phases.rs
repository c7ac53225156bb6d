//! The input pixels of a strided convolution that the same taps of the kernel reach.

use super::blocks::Blocks;
use super::padded::Pitches;
use crate::simd::LANES;

/// Input pixels of one parity of row and column: their gradients sum the same taps.
pub(super) struct Phase {
    /// Row and column of the first pixel.
    pub(super) first: [usize; 2],
    /// Rows and columns of pixels, each `stride` apart.
    pub(super) size: [usize; 2],
    /// Positions of the output gradients in their padded image, relative to the pixel, one for each
    /// tap.
    pub(super) offsets: Vec<usize>,
    /// Indices of these taps in the kernel.
    pub(super) taps: Vec<usize>,
}

impl Phase {
    /// The phases of an input that have pixels and taps; `pitches` are those of the padded
    /// gradient.
    pub(super) fn all(input: &Blocks, kernel: usize, stride: usize, pitches: Pitches) -> Vec<Self> {
        (0..stride * stride)
            .map(|phase| {
                Self::new(input, kernel, stride, [phase / stride, phase % stride], pitches)
            })
            .filter(|phase| !phase.taps.is_empty() && phase.size.iter().all(|side| *side > 0))
            .collect()
    }

    fn new(
        input: &Blocks,
        kernel: usize,
        stride: usize,
        first: [usize; 2],
        pitches: Pitches,
    ) -> Self {
        let border = kernel / 2;
        // The output at `(first + border - tap) / stride` reads the pixel through a tap, if that is
        // whole.
        let reading = |first: usize, tap: usize| {
            let distance = first + border + stride * kernel - tap;
            distance.is_multiple_of(stride).then(|| border + distance / stride - kernel)
        };
        let (mut offsets, mut taps) = (Vec::new(), Vec::new());
        for tap in 0..kernel * kernel {
            let rows = reading(first[0], tap / kernel);
            if let (Some(y), Some(x)) = (rows, reading(first[1], tap % kernel)) {
                offsets.push(y * pitches.row + x * LANES);
                taps.push(tap);
            }
        }
        let pixels = |side: usize, first: usize| side.saturating_sub(first).div_ceil(stride);
        let size = [pixels(input.height, first[0]), pixels(input.width, first[1])];
        Self { first, size, offsets, taps }
    }
}
