//! The visibility buffer: nearest triangle of each pixel.

use std::ops::Range;

use evpose_cpu::LANES_8;

use super::fragment::PixelRect;

/// 1/depth and triangle index of every pixel. Rows are padded by [`LANES_8`] pixels, which are
/// written and never read.
///
/// # Source
/// Burns and Hunt, *The Visibility Buffer* (JCGT 2013).
#[derive(Debug, Clone)]
pub(super) struct VisibilityBuffer {
    stride: usize,
    /// Bits of 1/depth, which compare as the floats do because they are not negative.
    inverse_depth: Vec<i32>,
    triangle: Vec<i32>,
}

impl VisibilityBuffer {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let stride = width + LANES_8;
        Self { stride, inverse_depth: vec![0; stride * height], triangle: vec![0; stride * height] }
    }

    /// Clears the pixels of `rect`.
    pub(super) fn clear(&mut self, rect: PixelRect) {
        for y in rect.top..rect.bottom {
            let row = y * self.stride;
            self.inverse_depth[row + rect.left..row + rect.right].fill(0);
        }
    }

    /// Bits of 1/depth, zero where nothing is drawn, and triangle indices of the pixels of `rect`
    /// in a row.
    #[inline(always)]
    pub(super) fn row(&self, y: usize, rect: PixelRect) -> (&[i32], &[i32]) {
        let pixels = y * self.stride + rect.left..y * self.stride + rect.right;
        (&self.inverse_depth[pixels.clone()], &self.triangle[pixels])
    }

    /// The same of pixel (x, y) and the next ones to the right.
    #[inline(always)]
    pub(super) fn lanes(&self, x: usize, y: usize) -> Option<(&[i32; LANES_8], &[i32; LANES_8])> {
        let pixel = y * self.stride + x;
        let inverse_depth = self.inverse_depth.get(pixel..)?.first_chunk()?;
        Some((inverse_depth, self.triangle.get(pixel..)?.first_chunk()?))
    }

    /// The same of whole padded rows, mutably.
    #[inline(always)]
    pub(super) fn rows_mut(
        &mut self,
        rows: Range<usize>,
    ) -> impl Iterator<Item = (&mut [i32], &mut [i32])> {
        let pixels = rows.start * self.stride..rows.end * self.stride;
        let inverse_depth = self.inverse_depth[pixels.clone()].chunks_exact_mut(self.stride);
        inverse_depth.zip(self.triangle[pixels].chunks_exact_mut(self.stride))
    }

    /// Depth-tests a triangle at a pixel; of two at the same depth the first stays.
    pub(super) fn show(&mut self, x: usize, y: usize, inverse_depth: f32, triangle: u32) {
        let (pixel, bits) = (y * self.stride + x, inverse_depth.to_bits() as i32);
        if bits > self.inverse_depth[pixel] {
            self.inverse_depth[pixel] = bits;
            self.triangle[pixel] = triangle as i32;
        }
    }
}
