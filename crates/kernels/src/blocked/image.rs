//! Images in the blocked layout nChw16c.

use super::lines::Lines;
use super::views::{F32Dst, F32Src};
use crate::simd::LANES;

/// Sixteen channels of a pixel: one cache line of 64 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [f32; LANES]);

impl Line {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// The values of consecutive pixels.
    pub(crate) fn values_mut(lines: &mut [Self]) -> &mut [f32] {
        let count = lines.len() * LANES;
        // SAFETY: a line is sixteen f32 and nothing else, 64 bytes of alignment 64.
        unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), count) }
    }
}

/// Pixels past the right and lower border that kernels may read: the tiles of a row are of one
/// width, so that the last one may extend past the image. The values read there are discarded.
pub(super) const OVERREAD: usize = 4;

/// An f32 image `[channels / 16][height][width][16]` (nChw16c, batch 1) with a zero border, so that
/// kernels need no bounds tests at the edges.
///
/// Lanes that pad the last block are zero in every image that an operator of this module has
/// written.
#[derive(Debug, Clone)]
pub struct Image {
    channels: usize,
    height: usize,
    width: usize,
    border: usize,
    lines: Lines,
}

impl Image {
    /// A zero image with `border` pixels on each side.
    pub fn zeros(channels: usize, height: usize, width: usize, border: usize) -> Self {
        let mut image = Self { channels, height, width, border, lines: Lines::default() };
        image.lines = Lines::zeros(image.blocks() * image.block_pitch());
        image
    }

    /// Channels, without those that pad the last block.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Rows without the border.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Columns without the border.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Zero pixels on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// Memory of the image in bytes, its border included.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.lines[..])
    }

    /// Number of channel blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Lines from a row to the next.
    pub(crate) fn row_pitch(&self) -> usize {
        self.width + 2 * self.border + OVERREAD
    }

    /// Lines from a block of channels to the next.
    pub(crate) fn block_pitch(&self) -> usize {
        (self.height + 2 * self.border + OVERREAD) * self.row_pitch()
    }

    /// Index of the line of the pixel at row 0 and column 0 of the first block.
    pub(crate) fn origin(&self) -> usize {
        self.border * self.row_pitch() + self.border
    }

    /// Pointer to a block of the pixel `padding` above and to the left of row `y` and column `x`:
    /// the first tap of the kernel's window there.
    ///
    /// # Panics
    /// If that pixel is outside of the image and its border.
    pub(crate) fn tap(&self, block: usize, y: usize, x: usize, padding: usize) -> *const f32 {
        let at = block * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        self.lines[at - padding * (self.row_pitch() + 1)..].as_ptr().cast()
    }

    /// Pointer to the first pixel, valid for writes to the whole image from there on.
    pub(crate) fn first_mut(&mut self) -> *mut f32 {
        let origin = self.origin();
        self.lines[origin..].as_mut_ptr().cast()
    }

    /// Source view.
    pub(super) fn src(&self) -> F32Src {
        let pixels = self.lines[self.origin()..].as_ptr().cast();
        let [row_pitch, block_pitch] =
            [self.row_pitch(), self.block_pitch()].map(|lines| lines * LANES);
        F32Src { pixels, row_pitch, block_pitch, is_nchw: false }
    }

    /// Destination view.
    pub(super) fn dst(&mut self) -> F32Dst {
        F32Dst {
            pixels: self.first_mut(),
            row_pitch: self.row_pitch() * LANES,
            block_pitch: self.block_pitch() * LANES,
            width: self.width,
        }
    }

    /// Whether the border and the lanes that pad the last block are zero.
    #[cfg(test)]
    pub(super) fn is_zero_outside(&self) -> bool {
        let mut values = vec![0.0; self.channels * self.height * self.width];
        self.copy_to_nchw(&mut values);
        let mut inside = Self::zeros(self.channels, self.height, self.width, self.border);
        inside.copy_from_nchw(&values);
        inside.lines[..] == self.lines[..]
    }

    pub(super) fn lines(&self) -> &[Line] {
        &self.lines
    }

    pub(super) fn lines_mut(&mut self) -> &mut [Line] {
        &mut self.lines
    }

    /// Line and lane of a value.
    pub(super) fn position(&self, channel: usize, y: usize, x: usize) -> (usize, usize) {
        let line = channel / LANES * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        (line, channel % LANES)
    }

    /// Fills the image from `[channels][height][width]`.
    ///
    /// # Panics
    /// If `values` has another length.
    pub fn copy_from_nchw(&mut self, values: &[f32]) {
        assert_eq!(values.len(), self.channels * self.height * self.width, "values of this size");
        for channel in 0..self.channels {
            for y in 0..self.height {
                let (first, lane) = self.position(channel, y, 0);
                let row = &values[(channel * self.height + y) * self.width..][..self.width];
                for (line, value) in self.lines[first..].iter_mut().zip(row) {
                    line.0[lane] = *value;
                }
            }
        }
    }

    /// Minimum and maximum of the values.
    pub fn min_max(&self) -> [f32; 2] {
        let mut ends = [f32::INFINITY, f32::NEG_INFINITY];
        for block in 0..self.blocks() {
            // Without the lanes that pad the last block.
            let channels = LANES.min(self.channels - block * LANES);
            for y in 0..self.height {
                let (first, _) = self.position(block * LANES, y, 0);
                for line in &self.lines[first..first + self.width] {
                    for value in &line.0[..channels] {
                        ends = [ends[0].min(*value), ends[1].max(*value)];
                    }
                }
            }
        }
        ends
    }

    /// Copies the image to `[channels][height][width]`.
    ///
    /// # Panics
    /// If `values` has another length.
    pub fn copy_to_nchw(&self, values: &mut [f32]) {
        assert_eq!(values.len(), self.channels * self.height * self.width, "values of this size");
        for (channel, plane) in values.chunks_mut((self.height * self.width).max(1)).enumerate() {
            self.copy_channel_to(channel, plane);
        }
    }

    /// Copies a channel to `[height][width]`.
    pub(super) fn copy_channel_to(&self, channel: usize, values: &mut [f32]) {
        for (y, row) in values.chunks_mut(self.width.max(1)).enumerate() {
            let (first, lane) = self.position(channel, y, 0);
            for (value, line) in row.iter_mut().zip(&self.lines[first..]) {
                *value = line.0[lane];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_come_back_and_the_border_stays_zero() {
        let (channels, height, width) = (19, 3, 5);
        let planes: Vec<f32> = (1..=channels * height * width).map(|v| v as f32).collect();
        let mut image = Image::zeros(channels, height, width, 2);
        image.copy_from_nchw(&planes);
        let mut back = vec![0.0; planes.len()];
        image.copy_to_nchw(&mut back);
        assert_eq!(back, planes);
        let inside: f32 = planes.iter().sum();
        let all: f32 = image.lines.iter().flat_map(|line| line.0).sum();
        assert!((all - inside).abs() < 1e-3 * inside);
        assert_eq!(image.lines.as_ptr().addr() % 64, 0);
    }
}
