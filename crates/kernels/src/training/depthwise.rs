//! Depthwise convolution: every channel has a kernel of its own.
//!
//! Each block of an image is a piece of work: its input, normalised, is copied into a padded plane,
//! over which the sixteen lanes of a vector run with the weights of their channels.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::norm::NormalizedInput;
use super::padded::{Padded, Pitches, pad_block};
use super::per_channel::{ChannelProducts, ChannelSums};
use super::phases::Phase;
use crate::blocked::{Line, pad_to_blocks};
use crate::simd::{LANES, Level};

/// A depthwise convolution of stride 1 or 2, padded with zeros by half its kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depthwise {
    /// Shape of the input.
    pub input: Blocks,
    /// Rows and columns of a kernel; odd.
    pub kernel: usize,
    /// Pixels between outputs: 1 or 2.
    pub stride: usize,
    /// The instructions to compute with.
    pub level: Level,
}

impl Depthwise {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        self.input.strided(self.stride)
    }

    /// The convolution of `input`.
    ///
    /// # Shapes
    /// - `weight`: `[channels, 1, kernel, kernel]`; `bias`: `[channels]`
    ///
    /// # Panics
    /// If a slice has another length, here and in the gradients.
    pub fn forward(
        &self,
        input: NormalizedInput<'_>,
        weight: &[f32],
        bias: Option<&[f32]>,
    ) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        self.check(input.values.len(), weight.len(), out.value_count());
        assert!(bias.is_none_or(|bias| bias.len() == shape.channels), "bias");
        let pitches = Pitches::new(&shape, self.kernel / 2);
        let offsets = self.offsets(pitches);
        // All taps: gradients of stride 2 take a part of them.
        let all: Vec<usize> = (0..offsets.len()).collect();
        let weights = self.weight_lines(weight, &all);
        let bias = bias.map(pad_to_blocks);
        let mut output = vec![0.0; out.value_count()];
        let sources = input.values.par_chunks(shape.block().max(1));
        let work = output.par_chunks_mut(out.block().max(1)).zip(sources).enumerate();
        work.for_each_init(Padded::default, |padded, (k, (to, values))| {
            let block = k % shape.blocks();
            let plane = padded.room(pitches.block_lines());
            pad_block(&shape, values, input.block_norm(block), pitches, plane);
            let sums = ChannelSums {
                offsets: &offsets,
                weights: &weights[block * offsets.len()..],
                bias: bias.as_ref().map_or(Line::ZERO, |bias| bias[block]),
                size: [out.width, out.height],
                from_pitch: [self.stride * LANES, self.stride * pitches.row],
                to_pitch: [LANES, out.width * LANES],
                from: plane.as_ptr().cast(),
                to: to.as_mut_ptr(),
            };
            // SAFETY: the border is half a kernel wide, so that taps of every output are inside of
            // the padded plane; `to` holds the pixels of this block.
            unsafe { self.level.run(&sums) };
        });
        output
    }

    /// The gradient by the normalised input, from the gradient by the output.
    pub fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        let (shape, out) = (self.input, self.output());
        self.check(shape.value_count(), weight.len(), gradient.len());
        let pitches = Pitches::new(&out, self.kernel / 2);
        // Of stride 2, pixels of even and of odd rows and columns sum taps of their own.
        let phases: Vec<_> = Phase::all(&shape, self.kernel, self.stride, pitches)
            .into_iter()
            .map(|phase| (self.weight_lines(weight, &phase.taps), phase))
            .collect();
        let mut input = vec![0.0; shape.value_count()];
        let sources = gradient.par_chunks(out.block().max(1));
        let work = input.par_chunks_mut(shape.block().max(1)).zip(sources).enumerate();
        work.for_each_init(Padded::default, |padded, (k, (to, values))| {
            let plane = padded.room(pitches.block_lines());
            pad_block(&out, values, None, pitches, plane);
            for (weights, phase) in &phases {
                let [y, x] = phase.first;
                let sums = ChannelSums {
                    offsets: &phase.offsets,
                    weights: &weights[k % shape.blocks() * phase.taps.len()..],
                    bias: Line::ZERO,
                    size: [phase.size[1], phase.size[0]],
                    from_pitch: [LANES, pitches.row],
                    to_pitch: [self.stride * LANES, self.stride * shape.width * LANES],
                    from: plane.as_ptr().cast(),
                    to: to[(y * shape.width + x) * LANES..].as_mut_ptr(),
                };
                // SAFETY: no tap is further than the border from a pixel of the gradient; pixels of
                // the phase are inside of this block.
                unsafe { self.level.run(&sums) };
            }
        });
        input
    }

    /// The gradient by the weight, from the gradient by the output.
    pub fn backward_weight(&self, input: NormalizedInput<'_>, gradient: &[f32]) -> Vec<f32> {
        let (shape, out, taps) = (self.input, self.output(), self.kernel.pow(2));
        self.check(input.values.len(), shape.channels * taps, gradient.len());
        let pitches = Pitches::new(&shape, self.kernel / 2);
        let offsets = self.offsets(pitches);
        let mut sums = vec![Line::ZERO; shape.batch * shape.blocks() * taps];
        let sources = input.values.par_chunks(shape.block().max(1));
        let sources = sources.zip(gradient.par_chunks(out.block().max(1)));
        let work = sums.par_chunks_mut(taps).zip(sources).enumerate();
        work.for_each_init(Padded::default, |padded, (k, (sums, (values, gradient)))| {
            let plane = padded.room(pitches.block_lines());
            pad_block(&shape, values, input.block_norm(k % shape.blocks()), pitches, plane);
            let products = ChannelProducts {
                offsets: &offsets,
                size: [out.width, out.height],
                from_pitch: [self.stride * LANES, self.stride * pitches.row],
                from: plane.as_ptr().cast(),
                gradient: gradient.as_ptr(),
                sums: sums.as_mut_ptr().cast(),
            };
            // SAFETY: taps of every output are inside of the padded plane; there is a sum for each
            // tap.
            unsafe { self.level.run(&products) };
        });
        // Images are summed in their order, so that no bit depends on the number of threads.
        let total = |k: usize| -> f64 {
            let (channel, tap) = (k / taps, k % taps);
            let first = channel / LANES * taps + tap;
            let of_image = shape.blocks() * taps;
            let lines = sums.iter().skip(first).step_by(of_image);
            lines.map(|line| f64::from(line.0[channel % LANES])).sum()
        };
        (0..shape.channels * taps).into_par_iter().map(|k| total(k) as f32).collect()
    }

    /// Positions of all taps in a padded plane, relative to the first.
    fn offsets(&self, pitches: Pitches) -> Vec<usize> {
        let taps = 0..self.kernel.pow(2);
        taps.map(|tap| tap / self.kernel * pitches.row + tap % self.kernel * LANES).collect()
    }

    /// The weights of some taps, `[block][tap][16]`.
    fn weight_lines(&self, weight: &[f32], taps: &[usize]) -> Vec<Line> {
        let of_channel = self.kernel.pow(2);
        let mut lines = vec![Line::ZERO; self.input.blocks() * taps.len()];
        for (channel, values) in weight.chunks_exact(of_channel).enumerate() {
            let (block, lane) = (channel / LANES, channel % LANES);
            for (k, tap) in taps.iter().enumerate() {
                lines[block * taps.len() + k].0[lane] = values[*tap];
            }
        }
        lines
    }

    fn check(&self, input: usize, weight: usize, output: usize) {
        assert!(
            matches!(self.stride, 1 | 2) && self.kernel % 2 == 1,
            "an odd kernel, stride 1 or 2"
        );
        assert_eq!(input, self.input.value_count(), "values of the input");
        assert_eq!(weight, self.input.channels * self.kernel.pow(2), "values of the weight");
        assert_eq!(output, self.output().value_count(), "values of the output");
    }
}
