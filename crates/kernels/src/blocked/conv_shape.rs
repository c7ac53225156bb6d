//! Shape of a convolution.

use crate::simd::LANES;

/// Shape of a convolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConvShape {
    /// Input channels.
    pub channels_in: usize,
    /// Output channels.
    pub channels_out: usize,
    /// Rows and columns of the kernel.
    pub kernel: [usize; 2],
    /// Stride in both directions: 1 or 2.
    pub stride: usize,
    /// Zeros above and below, and on the left and on the right.
    pub padding: [usize; 2],
}

impl ConvShape {
    /// A square kernel with padding `kernel / 2` ("same" padding up to the stride).
    pub fn square(channels_in: usize, channels_out: usize, kernel: usize, stride: usize) -> Self {
        let (kernel, padding) = ([kernel; 2], [kernel / 2; 2]);
        Self { channels_in, channels_out, kernel, stride, padding }
    }

    /// Rows (and columns) of a kernel made by [`square`](Self::square) of odd size; none for others.
    pub fn square_side(&self) -> Option<usize> {
        let [rows, columns] = self.kernel;
        (rows == columns && rows % 2 == 1 && self.padding == [rows / 2; 2]).then_some(rows)
    }

    /// Height and width of the output for an input of such a size; 0 where the kernel does not fit.
    pub fn output(&self, size: [usize; 2]) -> [usize; 2] {
        std::array::from_fn(|axis| {
            let room = (size[axis] + 2 * self.padding[axis]).checked_sub(self.kernel[axis]);
            room.map_or(0, |room| room / self.stride + 1)
        })
    }

    /// Weights of one pair of channels.
    pub fn taps(&self) -> usize {
        self.kernel[0] * self.kernel[1]
    }

    /// Width of the zero border that the input needs.
    pub fn border(&self) -> usize {
        self.padding[0].max(self.padding[1])
    }

    /// Number of blocks of input channels.
    pub(super) fn blocks_in(&self) -> usize {
        self.channels_in.div_ceil(LANES)
    }
}
