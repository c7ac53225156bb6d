//! Bilinear upsampling by two, as PyTorch's `interpolate` does it without aligned corners.
//!
//! # Model
//! Pixels are squares about their centres: along each axis an output takes 3/4 of the pixel that it
//! lies in and 1/4 of the neighbour on its side; beyond the border the outermost pixel repeats.

use evpose_cpu::vectorize;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::norm::{NormalizedInput, ScaleShiftStrips};
use crate::simd::LANES;

/// Weights of the pixel that an output lies in, and of the neighbour on its side.
const NEAR: f32 = 0.75;
const FAR: f32 = 0.25;

type Pixel = [f32; LANES];

/// A bilinear upsampling by two of images of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Upsample {
    /// Shape of the input.
    pub input: Blocks,
}

impl Upsample {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        Blocks { height: 2 * self.input.height, width: 2 * self.input.width, ..self.input }
    }

    /// Twice as many rows and columns.
    pub fn forward(&self, input: NormalizedInput<'_>) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        assert_eq!(input.values.len(), shape.value_count(), "values of this shape");
        let mut output = vec![0.0; out.value_count()];
        let sources = input.values.par_chunks(shape.block().max(1));
        let blocks = output.par_chunks_mut(out.block().max(1)).zip(sources).enumerate();
        blocks.for_each_init(Vec::new, |row, (k, (to, from))| {
            let norm = input.scale_shift(k % shape.blocks()).strips();
            row.resize(shape.width, [0.0; LANES]);
            vectorize(
                #[inline(always)]
                || upsample_block(&norm, from.as_chunks().0, to.as_chunks_mut().0, row),
            );
        });
        output
    }

    /// The gradient by the normalised input, from the gradient by the output.
    pub fn backward(&self, gradient: &[f32]) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        assert_eq!(gradient.len(), out.value_count(), "values of the output");
        let mut input = vec![0.0; shape.value_count()];
        let sources = gradient.par_chunks(out.block().max(1));
        let blocks = input.par_chunks_mut(shape.block().max(1)).zip(sources);
        blocks.for_each_init(Vec::new, |row, (to, from)| {
            row.resize(out.width, [0.0; LANES]);
            vectorize(
                #[inline(always)]
                || downsample_block(from.as_chunks().0, to.as_chunks_mut().0, row),
            );
        });
        input
    }
}

/// The input pixels that an output of an axis of `side` pixels mixes: near and far.
#[inline(always)]
fn sources(output: usize, side: usize) -> [usize; 2] {
    let near = output / 2;
    [near, if output.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(side - 1) }]
}

/// The outputs that take an input pixel, two as far and two as near. At the border an output takes
/// the outermost pixel twice, which the clamped index counts.
#[inline(always)]
fn readers(input: usize, side: usize) -> [(usize, f32); 4] {
    let first = 2 * input;
    [
        (first.saturating_sub(1), FAR),
        (first, NEAR),
        (first + 1, NEAR),
        ((first + 2).min(2 * side - 1), FAR),
    ]
}

#[inline(always)]
fn upsample_block(norm: &ScaleShiftStrips, from: &[Pixel], to: &mut [Pixel], row: &mut [Pixel]) {
    let width = row.len();
    let height = from.len() / width;
    for (y, to) in to.chunks_exact_mut(2 * width).enumerate() {
        let [near, far] = sources(y, height).map(|y| &from[y * width..][..width]);
        let rows = [near, far].map(<[Pixel]>::as_flattened);
        // Rows are mixed first, so that columns are those of one row.
        norm.mix(rows, [NEAR, FAR], row.as_flattened_mut());
        for (x, to) in to.iter_mut().enumerate() {
            let [near, far] = sources(x, width).map(|x| &row[x]);
            for lane in 0..LANES {
                to[lane] = NEAR * near[lane] + FAR * far[lane];
            }
        }
    }
}

#[inline(always)]
fn downsample_block(from: &[Pixel], to: &mut [Pixel], row: &mut [Pixel]) {
    let width = row.len() / 2;
    let height = to.len() / width;
    for (y, to) in to.chunks_exact_mut(width).enumerate() {
        // The transpose of `upsample_block`: first along columns, then along rows.
        row.fill([0.0; LANES]);
        for (y, weight) in readers(y, height) {
            for (sum, dy) in row.iter_mut().zip(&from[y * 2 * width..][..2 * width]) {
                for lane in 0..LANES {
                    sum[lane] += weight * dy[lane];
                }
            }
        }
        for (x, to) in to.iter_mut().enumerate() {
            for (x, weight) in readers(x, width) {
                for lane in 0..LANES {
                    to[lane] += weight * row[x][lane];
                }
            }
        }
    }
}
