//! Raw views of f32 images: source and destination pointers with their strides.
//!
//! Kernels of one layer write disjoint parts of the same image from several threads and read images
//! with a row offset, neither of which a slice expresses.

use crate::simd::LANES;

/// Source view of an f32 image. Pitches are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct F32Src {
    /// Pixel at row 0 and column 0 of the first block.
    pub(super) pixels: *const f32,
    /// Distance from a row to the next.
    pub(super) row_pitch: usize,
    /// Distance between channel blocks; between channels in nchw.
    pub(super) block_pitch: usize,
    /// Whether the layout is nchw instead of nChw16c.
    pub(super) is_nchw: bool,
}

// SAFETY: an image that somebody holds a reference to, or rows that the thread itself wrote.
unsafe impl Send for F32Src {}
// SAFETY: as above.
unsafe impl Sync for F32Src {}

impl F32Src {
    /// Source view of rows that were written through a destination view.
    pub(super) fn from_dst(dst: F32Dst, is_nchw: bool) -> Self {
        let F32Dst { pixels, row_pitch, block_pitch, .. } = dst;
        Self { pixels, row_pitch, block_pitch, is_nchw }
    }

    /// The same view with row `row` as row 0.
    pub(super) fn with_first_row(self, row: isize) -> Self {
        let pixels = self.pixels.wrapping_offset(row * self.row_pitch as isize);
        Self { pixels, ..self }
    }

    /// Pointer to a block of the pixel `padding` above and to the left of row `y` and column `x`:
    /// the first tap of the kernel's window there.
    #[inline(always)]
    pub(super) fn tap(&self, block: usize, y: usize, x: usize, padding: usize) -> *const f32 {
        self.corner(block, y, x, [padding; 2])
    }

    /// The same with this padding, in rows and in columns.
    #[inline(always)]
    pub(super) fn corner(
        &self,
        block: usize,
        y: usize,
        x: usize,
        [rows, columns]: [usize; 2],
    ) -> *const f32 {
        let pixel = if self.is_nchw { 1 } else { LANES };
        let at = block * self.block_pitch + y * self.row_pitch + x * pixel;
        // Wrapping: the view of a band may begin at a row outside of its memory.
        self.pixels.wrapping_add(at).wrapping_sub(rows * self.row_pitch + columns * pixel)
    }
}

/// Destination view of an f32 image. Pitches are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct F32Dst {
    /// Pixel at row 0 and column 0 of the first block.
    pub(super) pixels: *mut f32,
    /// Distance from a row to the next.
    pub(super) row_pitch: usize,
    /// Distance between channel blocks; between channels in nchw.
    pub(super) block_pitch: usize,
    pub(super) width: usize,
}

impl F32Dst {
    /// The same view with row `row` as row 0.
    pub(super) fn with_first_row(self, row: isize) -> Self {
        let pixels = self.pixels.wrapping_offset(row * self.row_pitch as isize);
        Self { pixels, ..self }
    }

    /// Pointer to a block of a pixel.
    ///
    /// # Safety
    /// The pixel is inside the image.
    #[inline(always)]
    pub(super) unsafe fn pixel(&self, block: usize, y: usize, x: usize) -> *mut f32 {
        let at = block * self.block_pitch + y * self.row_pitch + x * LANES;
        // SAFETY: the caller's.
        unsafe { self.pixels.add(at) }
    }
}

// SAFETY: each part of a parallel region writes its own pixels through it.
unsafe impl Send for F32Dst {}
// SAFETY: as above.
unsafe impl Sync for F32Dst {}
