//! The kernels of depthwise convolution: sixteen channels of a few pixels, all sums in registers.

use crate::blocked::Line;
use crate::simd::{Kernel, LANES, Lanes};

/// Outputs `bias + Σ weight input` over the taps of each channel. Pitches and offsets are in `f32`.
///
/// Inputs of every output and tap are readable from `from` on, outputs are writable from `to` on
/// and written by nobody else, and there are as many weights as offsets.
pub(super) struct ChannelSums<'a> {
    /// Positions of the taps, relative to the first input of an output.
    pub(super) offsets: &'a [usize],
    /// `[tap][16]`.
    pub(super) weights: &'a [Line],
    pub(super) bias: Line,
    /// Columns and rows of the output.
    pub(super) size: [usize; 2],
    /// Distance between the inputs of neighbouring columns, and of rows.
    pub(super) from_pitch: [usize; 2],
    /// Distance between neighbouring columns, and rows, of the output.
    pub(super) to_pitch: [usize; 2],
    pub(super) from: *const f32,
    pub(super) to: *mut f32,
}

impl Kernel for ChannelSums<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [columns, rows] = self.size;
        for y in 0..rows {
            let mut x = 0;
            while x < columns {
                // SAFETY: the struct's; these pixels are among the outputs.
                x += unsafe {
                    let from = self.from.add(y * self.from_pitch[1] + x * self.from_pitch[0]);
                    let to = self.to.add(y * self.to_pitch[1] + x * self.to_pitch[0]);
                    self.tile_up_to::<V>(columns - x, from, to)
                };
            }
        }
    }
}

impl ChannelSums<'_> {
    /// Computes the largest tile of at most this many pixels; returns its pixels.
    ///
    /// # Safety
    /// That of [`tile`](Self::tile).
    #[inline(always)]
    unsafe fn tile_up_to<V: Lanes>(&self, pixels: usize, from: *const f32, to: *mut f32) -> usize {
        macro_rules! tiles {
            ($($n:literal)*) => {
                match pixels {
                    // SAFETY: the caller's. Tiles that registers do not hold are not compiled.
                    $($n.. if $n <= V::TILE[0] => unsafe {
                        self.tile::<V, $n>(from, to);
                        $n
                    },)*
                    _ => unreachable!("{pixels} pixels in a tile"),
                }
            };
        }
        tiles!(12 8 6 4 3 2 1)
    }

    /// Computes `N` neighbouring outputs.
    ///
    /// # Safety
    /// The processor has the instructions of `V`. Readable are the taps of `N` pixels from `from`
    /// on, writable are `N` pixels from `to` on.
    #[inline(always)]
    unsafe fn tile<V: Lanes, const N: usize>(&self, from: *const f32, to: *mut f32) {
        // SAFETY: the caller's.
        unsafe {
            let mut sums = [V::load(self.bias.0.as_ptr()); N];
            for (offset, weight) in self.offsets.iter().zip(self.weights) {
                let (from, weight) = (from.add(*offset), V::load(weight.0.as_ptr()));
                for (pixel, sum) in sums.iter_mut().enumerate() {
                    *sum = V::load(from.add(pixel * self.from_pitch[0])).mul_add(weight, *sum);
                }
            }
            for (pixel, sum) in sums.iter().enumerate() {
                sum.store(to.add(pixel * self.to_pitch[0]));
            }
        }
    }
}

/// For each tap the sums `Σ input gradient` over all pixels. Pitches and offsets are in `f32`.
///
/// Inputs of every output and tap are readable from `from` on, `size` pixels from `gradient` on
/// without gaps, and one line for each offset is writable from `sums` on.
pub(super) struct ChannelProducts<'a> {
    pub(super) offsets: &'a [usize],
    /// Columns and rows of the gradient.
    pub(super) size: [usize; 2],
    /// Distance between the inputs of neighbouring columns, and of rows.
    pub(super) from_pitch: [usize; 2],
    pub(super) from: *const f32,
    pub(super) gradient: *const f32,
    /// `[tap][16]`.
    pub(super) sums: *mut f32,
}

impl Kernel for ChannelProducts<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let mut first = 0;
        while first < self.offsets.len() {
            // SAFETY: the struct's.
            first += unsafe { self.taps_from::<V>(first) };
        }
    }
}

impl ChannelProducts<'_> {
    /// Sums as many taps from `first` on as registers hold; returns how many.
    ///
    /// # Safety
    /// That of [`taps`](Self::taps).
    #[inline(always)]
    unsafe fn taps_from<V: Lanes>(&self, first: usize) -> usize {
        macro_rules! chunks {
            ($($n:literal)*) => {
                match self.offsets.len() - first {
                    // SAFETY: the caller's. Chunks that registers do not hold are not compiled.
                    $($n.. if $n <= V::TILE[0] => unsafe {
                        self.taps::<V, $n>(first);
                        $n
                    },)*
                    taps => unreachable!("{taps} taps in a chunk"),
                }
            };
        }
        // Nine are a 3x3 kernel, five a row of a 5x5 kernel.
        chunks!(9 5 3 2 1)
    }

    /// Sums `N` taps from `first` on.
    ///
    /// # Safety
    /// The processor has the instructions of `V`; that of the struct, for these taps.
    #[inline(always)]
    unsafe fn taps<V: Lanes, const N: usize>(&self, first: usize) {
        let [columns, rows] = self.size;
        // SAFETY: the caller's.
        unsafe {
            let mut sums = [V::splat(0.0); N];
            for y in 0..rows {
                let from = self.from.add(y * self.from_pitch[1]);
                let from: [*const f32; N] =
                    std::array::from_fn(|tap| from.add(self.offsets[first + tap]));
                let gradient = self.gradient.add(y * columns * LANES);
                for x in 0..columns {
                    let dy = V::load(gradient.add(x * LANES));
                    for (sum, from) in sums.iter_mut().zip(from) {
                        *sum = V::load(from.add(x * self.from_pitch[0])).mul_add(dy, *sum);
                    }
                }
            }
            for (tap, sum) in sums.iter().enumerate() {
                sum.store(self.sums.add((first + tap) * LANES));
            }
        }
    }
}
