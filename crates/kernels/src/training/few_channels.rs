//! The gradient by an input of few channels of a convolution of stride 2, such as the first of a
//! network.
//!
//! Pixels of even and odd rows and columns have taps of their own. With at most four channels,
//! those of all four kinds fit one block: they are computed together, as a convolution of stride 1,
//! and then put where they belong.

use rayon::prelude::*;

use super::gather::Gather;
use super::padded::{Padded, Pitches, pad};
use super::shape::Conv;
use super::weights::Weights;
use crate::simd::LANES;

/// Pixels of even and odd rows and columns.
const KINDS: usize = 4;

/// Whether the channels of all kinds are a block.
pub(super) fn suits(conv: &Conv) -> bool {
    conv.stride == 2 && KINDS * conv.input.channels <= LANES
}

pub(super) fn backward_input(conv: &Conv, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
    let (shape, out, kernel) = (conv.input, conv.output(), conv.kernel);
    let (channels, border) = (shape.channels, kernel / 2);
    // Gradients from `first` pixels before to as many behind as `side` says, down and across.
    let first = kernel.saturating_sub(1 + border) / 2;
    let side = first + border.div_ceil(2) + 1;
    let mut turned = vec![0.0; out.channels * KINDS * channels * side * side];
    for (row, weight) in turned
        .chunks_exact_mut(KINDS * channels * side * side)
        .zip(weight.chunks_exact(channels * kernel * kernel))
    {
        for (k, value) in weight.iter().enumerate() {
            let (channel, taps) = (k / (kernel * kernel), [k / kernel % kernel, k % kernel]);
            // The one kind of row, or column, that sees a tap, and from where.
            let seen = taps.map(|tap| {
                let kind = (border + tap) % 2;
                (kind, (kind + border + 2 * first - tap) / 2)
            });
            let [(py, y), (px, x)] = seen;
            // Four kinds of pixels, by whether row and column are even or odd.
            let to = (2 * py + px) * channels + channel;
            row[to * side * side + y * side + x] = *value;
        }
    }
    let pitches = Pitches::new(&out, border);
    let all: Vec<usize> = (0..side * side).collect();
    let offset = |tap: &usize| {
        let [y, x] = [tap / side, tap % side].map(|tap| border + tap - first);
        y * pitches.row + x * LANES
    };
    let taps: Vec<usize> = all.iter().map(offset).collect();
    let shape_of_turned = [out.channels, KINDS * channels, side * side];
    let weights = Weights { values: &turned, shape: shape_of_turned, is_transposed: true };
    let weights = weights.packed(&all, conv.blocks_at_once());
    let mut input = vec![0.0; shape.value_count()];
    if input.is_empty() {
        return input;
    }
    let images = input.par_chunks_mut(shape.image()).zip(gradient.par_chunks(out.image()));
    images.for_each_init(
        || (Padded::default(), vec![0.0; out.block()]),
        |(padded, kinds), (to, values)| {
            let padded = padded.room(pitches.lines(1));
            pad(&out, values.into(), pitches, padded);
            let work = Gather {
                taps: &taps,
                channels: out.channels,
                block_pitch: pitches.block,
                from_pitch: [LANES, pitches.row, pitches.image],
                weights: &weights,
                bias: None,
                channels_out: KINDS * channels,
                blocks_at_once: conv.blocks_at_once(),
                block_pitch_out: kinds.len(),
                size: [out.width, out.height, 1],
                to_pitch: [LANES, out.width * LANES, 0],
                from: padded.as_ptr().cast(),
                to: kinds.as_mut_ptr(),
            };
            // SAFETY: no tap is further from a pixel of the gradient than the border is wide; there
            // is room for a block of its size.
            unsafe { conv.level.run(&work) };
            for (k, kinds) in kinds.as_chunks::<LANES>().0.iter().enumerate() {
                let [y, x] = [k / out.width * 2, k % out.width * 2];
                for (kind, values) in kinds.chunks_exact(channels).take(KINDS).enumerate() {
                    let [y, x] = [y + kind / 2, x + kind % 2];
                    // Of odd sides, the last row or column of some kinds is outside.
                    if y < shape.height && x < shape.width {
                        let at = (y * shape.width + x) * LANES;
                        to[at..at + channels].copy_from_slice(values);
                    }
                }
            }
        },
    );
    input
}
