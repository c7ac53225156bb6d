//! Max-pooling of stride 2: over 3x3 pixels as in ResNets, over 2x2 as in VGG.

use evpose_cpu::vectorize;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::norm::{NormalizedInput, ScaleShift};
use crate::simd::LANES;

const STRIDE: usize = 2;

/// A max-pooling of stride 2 of images of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaxPool {
    /// Shape of the input.
    pub input: Blocks,
    /// Rows and columns of the window; at most 15.
    pub kernel: usize,
    /// Pixels around the image that never win; less than the window.
    pub padding: usize,
}

impl MaxPool {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        let [height, width] = [self.input.height, self.input.width].map(|side| {
            let rest = (side + 2 * self.padding).checked_sub(self.kernel);
            rest.map_or(0, |rest| rest / STRIDE + 1)
        });
        Blocks { height, width, ..self.input }
    }

    /// The largest value of every window, and its index in the window, the first of equals. NaN
    /// counts as larger than any other value.
    pub fn forward(&self, input: NormalizedInput<'_>) -> (Vec<f32>, Vec<u8>) {
        let (shape, out) = (self.input, self.output());
        assert_eq!(input.values.len(), shape.value_count(), "values of this shape");
        let (mut values, mut taps) = (vec![0.0; out.value_count()], vec![0; out.value_count()]);
        let size = out.block().max(1);
        let outputs = values.par_chunks_mut(size).zip(taps.par_chunks_mut(size));
        let pairs = outputs.zip(input.values.par_chunks(shape.block().max(1))).enumerate();
        pairs.for_each(|(k, ((values, taps), from))| {
            let line = input.scale_shift(k % shape.blocks());
            vectorize(
                #[inline(always)]
                || self.largest(line, from, values, taps),
            );
        });
        (values, taps)
    }

    /// The gradient by the normalised input, from that by the output and the second result of
    /// [`forward`](Self::forward).
    pub fn backward(&self, gradient: &[f32], taps: &[u8]) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        assert_eq!([gradient.len(), taps.len()], [out.value_count(); 2], "values of the output");
        let mut input = vec![0.0; shape.value_count()];
        let size = out.block().max(1);
        let sources = gradient.par_chunks(size).zip(taps.par_chunks(size));
        input.par_chunks_mut(shape.block().max(1)).zip(sources).for_each(|(to, (dys, taps))| {
            vectorize(
                #[inline(always)]
                || self.scatter(dys, taps, to),
            );
        });
        input
    }

    #[inline(always)]
    fn largest(&self, line: ScaleShift, from: &[f32], values: &mut [f32], taps: &mut [u8]) {
        let columns = self.output().width;
        let outputs = values.as_chunks_mut::<LANES>().0.iter_mut();
        for (k, (best, which)) in outputs.zip(taps.as_chunks_mut::<LANES>().0).enumerate() {
            let mut largest = [f32::NEG_INFINITY; LANES];
            let mut index = [u32::MAX; LANES];
            self.each_tap(k / columns, k % columns, |tap, at| {
                let pixel = &from[at * LANES..][..LANES];
                for lane in 0..LANES {
                    let value = line.value(lane, pixel[lane]);
                    // The first tap wins even if it is minus infinity, and NaN wins always.
                    let is_new =
                        (value > largest[lane]) | value.is_nan() | (index[lane] == u32::MAX);
                    largest[lane] = if is_new { value } else { largest[lane] };
                    index[lane] = if is_new { tap } else { index[lane] };
                }
            });
            *best = largest;
            *which = index.map(|tap| tap as u8);
        }
    }

    #[inline(always)]
    fn scatter(&self, dys: &[f32], taps: &[u8], to: &mut [f32]) {
        let columns = self.output().width;
        let outputs = dys.as_chunks::<LANES>().0.iter().zip(taps.as_chunks::<LANES>().0);
        for (k, (dy, which)) in outputs.enumerate() {
            let which = which.map(u32::from);
            self.each_tap(k / columns, k % columns, |tap, at| {
                let pixel = &mut to[at * LANES..][..LANES];
                for lane in 0..LANES {
                    pixel[lane] += if which[lane] == tap { dy[lane] } else { 0.0 };
                }
            });
        }
    }

    /// Calls `each` with the taps of an output that are inside, and their pixels.
    #[inline(always)]
    fn each_tap(&self, row: usize, column: usize, mut each: impl FnMut(u32, usize)) {
        let Blocks { height, width, .. } = self.input;
        for ky in 0..self.kernel {
            let Some(y) = (STRIDE * row + ky).checked_sub(self.padding).filter(|y| *y < height)
            else {
                continue;
            };
            for kx in 0..self.kernel {
                let x = (STRIDE * column + kx).checked_sub(self.padding).filter(|x| *x < width);
                if let Some(x) = x {
                    each((ky * self.kernel + kx) as u32, y * width + x);
                }
            }
        }
    }
}
