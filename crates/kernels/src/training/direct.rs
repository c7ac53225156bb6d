//! Direct convolution over padded copies of images.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::gather::Gather;
use super::norm::NormalizedInput;
use super::padded::{Padded, Pitches, pad};
use super::phases::Phase;
use super::shape::Conv;
use super::weights::Weights;
use crate::blocked::pad_to_blocks;
use crate::simd::LANES;

/// Pixels for which weights are fetched once, if there are as many images.
const PIXELS: usize = 512;

/// Images that a thread takes at a time; no sum depends on it.
fn at_once(shape: &Blocks) -> usize {
    let pixels = (shape.height * shape.width).max(1);
    let share = shape.batch.div_ceil(rayon::current_num_threads());
    PIXELS.div_ceil(pixels).clamp(1, share.max(1))
}

pub(super) fn forward(
    conv: &Conv,
    input: NormalizedInput<'_>,
    weights: Weights<'_>,
    bias: Option<&[f32]>,
) -> Vec<f32> {
    let (shape, out) = (conv.input, conv.output());
    let pitches = Pitches::new(&shape, conv.kernel / 2);
    // All taps in one list of offsets: the kernel of outputs knows no rows.
    let all: Vec<usize> = (0..conv.kernel.pow(2)).collect();
    let offset = |tap: &usize| tap / conv.kernel * pitches.row + tap % conv.kernel * LANES;
    let taps: Vec<usize> = all.iter().map(offset).collect();
    let weights = weights.packed(&all, conv.blocks_at_once());
    let bias = bias.map(pad_to_blocks);
    let mut output = vec![0.0; out.value_count()];
    if output.is_empty() {
        return output;
    }
    let images = at_once(&out);
    let sources = input.values.par_chunks(images * shape.image());
    output.par_chunks_mut(images * out.image()).zip(sources).for_each_init(
        Padded::default,
        |padded, (to, values)| {
            let images = values.len() / shape.image();
            let padded = padded.room(pitches.lines(images));
            let copies = padded.chunks_exact_mut(pitches.lines(1));
            for (copy, values) in copies.zip(values.chunks_exact(shape.image())) {
                pad(&shape, NormalizedInput { values, ..input }, pitches, copy);
            }
            let work = Gather {
                taps: &taps,
                channels: shape.channels,
                block_pitch: pitches.block,
                from_pitch: [conv.stride * LANES, conv.stride * pitches.row, pitches.image],
                weights: &weights,
                bias: bias.as_deref(),
                channels_out: out.channels,
                blocks_at_once: conv.blocks_at_once(),
                block_pitch_out: out.block(),
                size: [out.width, out.height, images],
                to_pitch: [LANES, out.width * LANES, out.image()],
                from: padded.as_ptr().cast(),
                to: to.as_mut_ptr(),
            };
            // SAFETY: taps of every output are inside of the padded image, since its border is half
            // a kernel wide, and outputs are those of these images.
            unsafe { conv.level.run(&work) };
        },
    );
    output
}

/// Of stride 2, pixels of even and of odd rows and columns have gradients of their own taps.
pub(super) fn backward_input(conv: &Conv, weights: Weights<'_>, gradient: &[f32]) -> Vec<f32> {
    let (shape, out, stride) = (conv.input, conv.output(), conv.stride);
    let pitches = Pitches::new(&out, conv.kernel / 2);
    let phases: Vec<_> = Phase::all(&shape, conv.kernel, stride, pitches)
        .into_iter()
        .map(|phase| (weights.packed(&phase.taps, conv.blocks_at_once()), phase))
        .collect();
    let mut input = vec![0.0; shape.value_count()];
    if input.is_empty() {
        return input;
    }
    let images = at_once(&out);
    let sources = gradient.par_chunks(images * out.image());
    input.par_chunks_mut(images * shape.image()).zip(sources).for_each_init(
        Padded::default,
        |padded, (to, values)| {
            let images = values.len() / out.image();
            let padded = padded.room(pitches.lines(images));
            let copies = padded.chunks_exact_mut(pitches.lines(1));
            // The gradient has no norm: it is padded as it is.
            for (copy, values) in copies.zip(values.chunks_exact(out.image())) {
                pad(&out, values.into(), pitches, copy);
            }
            // Each phase writes its own pixels: no two add to the same.
            for (weights, phase) in &phases {
                let [y, x] = phase.first;
                let work = Gather {
                    taps: &phase.offsets,
                    channels: out.channels,
                    block_pitch: pitches.block,
                    from_pitch: [LANES, pitches.row, pitches.image],
                    weights,
                    bias: None,
                    channels_out: shape.channels,
                    blocks_at_once: conv.blocks_at_once(),
                    block_pitch_out: shape.block(),
                    size: [phase.size[1], phase.size[0], images],
                    to_pitch: [stride * LANES, stride * shape.width * LANES, shape.image()],
                    from: padded.as_ptr().cast(),
                    to: to[(y * shape.width + x) * LANES..].as_mut_ptr(),
                };
                // SAFETY: no tap is further than half a kernel from a pixel of the gradient, which
                // is as wide as the border; pixels of the phase are inside of these images.
                unsafe { conv.level.run(&work) };
            }
        },
    );
    input
}
