//! Max-pooling over 3x3 pixels with stride 2 and one pixel of padding, as ResNets use it.

use pulp::Arch;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::norm::{BlockLine, Input};
use crate::simd::LANES;

const KERNEL: usize = 3;
const STRIDE: usize = 2;

/// A max-pooling of images of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaxPool {
    /// Shape of the input.
    pub input: Blocks,
}

impl MaxPool {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        let [height, width] =
            [self.input.height, self.input.width].map(|side| side.div_ceil(STRIDE));
        Blocks { height, width, ..self.input }
    }

    /// The largest value around every second pixel, and which of the nine it was: the first of several.
    /// NaN counts as larger than any number.
    pub fn forward(&self, input: Input<'_>) -> (Vec<f32>, Vec<u8>) {
        let (shape, out) = (self.input, self.output());
        assert_eq!(input.values.len(), shape.numbers(), "numbers of this shape");
        let (mut values, mut taps) = (vec![0.0; out.numbers()], vec![0; out.numbers()]);
        let size = out.block().max(1);
        let outputs = values.par_chunks_mut(size).zip(taps.par_chunks_mut(size));
        let pairs = outputs.zip(input.values.par_chunks(shape.block().max(1))).enumerate();
        pairs.for_each(|(k, ((values, taps), from))| {
            let line = input.line(k % shape.blocks());
            Arch::new().dispatch(
                #[inline(always)]
                || self.largest(line, from, values, taps),
            );
        });
        (values, taps)
    }

    /// The gradient by the input as it is taken, from that by the output and the second result of
    /// [`forward`](Self::forward).
    pub fn backward(&self, gradient: &[f32], taps: &[u8]) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        assert_eq!([gradient.len(), taps.len()], [out.numbers(); 2], "numbers of the output");
        let mut input = vec![0.0; shape.numbers()];
        let size = out.block().max(1);
        let sources = gradient.par_chunks(size).zip(taps.par_chunks(size));
        input.par_chunks_mut(shape.block().max(1)).zip(sources).for_each(|(to, (dys, taps))| {
            Arch::new().dispatch(
                #[inline(always)]
                || self.scatter(dys, taps, to),
            );
        });
        input
    }

    #[inline(always)]
    fn largest(&self, line: BlockLine, from: &[f32], values: &mut [f32], taps: &mut [u8]) {
        let columns = self.output().width;
        let outputs = values.as_chunks_mut::<LANES>().0.iter_mut();
        for (k, (best, which)) in outputs.zip(taps.as_chunks_mut::<LANES>().0).enumerate() {
            let mut largest = [f32::NEG_INFINITY; LANES];
            let mut index = [u32::MAX; LANES];
            self.each_tap(k / columns, k % columns, |tap, at| {
                let pixel = &from[at * LANES..][..LANES];
                for lane in 0..LANES {
                    let value = line.value(lane, pixel[lane]);
                    // Not less: NaN goes on, and so does the first of minus infinity.
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
        for ky in 0..KERNEL {
            let Some(y) = (STRIDE * row + ky).checked_sub(1).filter(|y| *y < height) else {
                continue;
            };
            for kx in 0..KERNEL {
                let x = (STRIDE * column + kx).checked_sub(1).filter(|x| *x < width);
                if let Some(x) = x {
                    each((ky * KERNEL + kx) as u32, y * width + x);
                }
            }
        }
    }
}
