//! Shape of a convolution.

use crate::simd::LANES;

/// Shape of a square convolution with padding `kernel / 2` ("same" padding up to the stride).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConvShape {
    /// Input channels.
    pub channels_in: usize,
    /// Output channels.
    pub channels_out: usize,
    /// Height and width of the kernel; odd.
    pub kernel: usize,
    /// Stride: 1 or 2.
    pub stride: usize,
}

impl ConvShape {
    /// Height (or width) of the output for an input of `pixels` rows (or columns).
    pub fn output(&self, pixels: usize) -> usize {
        pixels.div_ceil(self.stride)
    }

    /// Zero padding on each side.
    pub fn padding(&self) -> usize {
        self.kernel / 2
    }

    /// Number of blocks of input channels.
    pub(super) fn blocks_in(&self) -> usize {
        self.channels_in.div_ceil(LANES)
    }
}
