//! Convolution of every channel with a kernel of its own.
//!
//! # Model
//! A padded plane is cut by the stride into *phases*: every `stride`-th pixel of every `stride`-th row,
//! so that each tap of the kernel reads one phase without gaps. Rows of a phase lie behind each
//! other, and so do rows of outputs, as far apart: then a tap is one long run shifted by a fixed
//! distance, however narrow the image. What a run computes between two rows of outputs is left out
//! in the forward pass, and zero in the gradients.

mod phases;
mod sums;

use pulp::Arch;
use rayon::prelude::*;

use phases::Grid;
use sums::{BLOCK, Products, Run, Weighted};

/// Partial sums of a weight gradient: enough for the threads of a desktop, few enough to hold.
const PARTIALS: usize = 16;

/// Shape of a depthwise convolution: a square kernel, the same stride and padding along both axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depthwise {
    /// Images.
    pub batch: usize,
    /// Channels of input and output.
    pub channels: usize,
    /// Rows of the input.
    pub height: usize,
    /// Columns of the input.
    pub width: usize,
    /// Rows and columns of a kernel.
    pub kernel: usize,
    /// Pixels between outputs; at least 1.
    pub stride: usize,
    /// Zeros around the input.
    pub padding: usize,
}

/// Memory for one plane.
#[derive(Default)]
struct Scratch {
    phases: Vec<f32>,
    run: Vec<f32>,
}

impl Depthwise {
    /// Rows and columns of the output.
    pub fn output(&self) -> [usize; 2] {
        let size = |pixels: usize| {
            let padded = pixels + 2 * self.padding;
            padded.checked_sub(self.kernel).map_or(0, |room| room / self.stride + 1)
        };
        [size(self.height), size(self.width)]
    }

    fn plane_in(&self) -> usize {
        self.height * self.width
    }

    fn plane_out(&self) -> usize {
        self.output().iter().product()
    }

    fn taps(&self) -> usize {
        self.kernel * self.kernel
    }

    /// Whether there is anything to compute.
    fn check(&self, input: usize, weight: usize, output: usize) -> bool {
        assert_eq!(input, self.batch * self.channels * self.plane_in(), "length of the input");
        assert_eq!(weight, self.channels * self.taps(), "length of the weight");
        assert_eq!(output, self.batch * self.channels * self.plane_out(), "length of the output");
        input > 0 && output > 0 && weight > 0
    }

    /// The convolution of `input` with `weight`, plus `bias`.
    ///
    /// # Shapes
    /// - `input`: `[batch, channels, height, width]`
    /// - `weight`: `[channels, 1, kernel, kernel]`
    /// - `bias`: `[channels]`
    /// - output: `[batch, channels, oy, ox]`, sizes by [`output`](Self::output)
    pub fn forward(&self, input: &[f32], weight: &[f32], bias: Option<&[f32]>) -> Vec<f32> {
        let mut output = vec![0.0; self.batch * self.channels * self.plane_out()];
        if !self.check(input.len(), weight.len(), output.len()) {
            return output;
        }
        let (grid, arch) = (Grid::new(self), Arch::new());
        let images = output.par_chunks_mut(self.channels * self.plane_out());
        let images = images.zip(input.par_chunks(self.channels * self.plane_in()));
        images.for_each_init(Scratch::default, |scratch, (output, image)| {
            let planes = image.chunks_exact(self.plane_in());
            let planes = planes.zip(output.chunks_exact_mut(self.plane_out()));
            for (channel, (plane, output)) in planes.enumerate() {
                grid.lay(plane, &mut scratch.phases);
                let weight = &weight[channel * self.taps()..][..self.taps()];
                let runs = grid.taps.iter().zip(weight);
                let runs = runs.map(|(&tap, &weight)| Run { start: tap.at, weight });
                let bias = bias.map_or(0.0, |bias| bias[channel]);
                grid.resize(&mut scratch.run);
                let (out, from) = (&mut scratch.run[..], &scratch.phases[..]);
                arch.dispatch(Weighted { out, bias, from, runs });
                grid.take_output(&scratch.run, output);
            }
        });
        output
    }

    /// The gradient by the input, from the gradient by the output. Shapes as in
    /// [`forward`](Self::forward).
    pub fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        let mut input = vec![0.0; self.batch * self.channels * self.plane_in()];
        if !self.check(input.len(), weight.len(), gradient.len()) {
            return input;
        }
        let (grid, arch) = (Grid::new(self), Arch::new());
        let images = input.par_chunks_mut(self.channels * self.plane_in());
        let images = images.zip(gradient.par_chunks(self.channels * self.plane_out()));
        images.for_each_init(Scratch::default, |scratch, (input, image)| {
            let planes = image.chunks_exact(self.plane_out());
            let planes = planes.zip(input.chunks_exact_mut(self.plane_in()));
            for (channel, (gradient, input)) in planes.enumerate() {
                // Zeros before the first row of outputs: taps reach back to there.
                grid.lay_gradient(gradient, &mut scratch.run);
                let weight = &weight[channel * self.taps()..][..self.taps()];
                grid.resize_phases(&mut scratch.phases);
                for phase in 0..grid.phases() {
                    let taps = grid.taps.iter().zip(weight).filter(|(tap, _)| tap.phase == phase);
                    let runs =
                        taps.map(|(tap, &weight)| Run { start: grid.before - tap.shift, weight });
                    let out = grid.phase(&mut scratch.phases, phase);
                    arch.dispatch(Weighted { out, bias: 0.0, from: &scratch.run, runs });
                }
                grid.take_input(&scratch.phases, input);
            }
        });
        input
    }

    /// The gradient by the weight, from the gradient by the output. Shapes as in
    /// [`forward`](Self::forward).
    pub fn backward_weight(&self, input: &[f32], gradient: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0; self.channels * self.taps()];
        if !self.check(input.len(), sum.len(), gradient.len()) {
            return sum;
        }
        let (grid, arch) = (Grid::new(self), Arch::new());
        let (image_in, image_out) =
            (self.channels * self.plane_in(), self.channels * self.plane_out());
        let part = self.batch.div_ceil(PARTIALS);
        let images = input.par_chunks(part * image_in).zip(gradient.par_chunks(part * image_out));
        let partials = images.map_init(Scratch::default, |scratch, (images, gradient)| {
            let mut partial = vec![0.0; sum.len()];
            let planes = images.chunks_exact(self.plane_in());
            let planes = planes.zip(gradient.chunks_exact(self.plane_out()));
            for (index, (plane, gradient)) in planes.enumerate() {
                let of_channel = index % self.channels * self.taps();
                let sums = &mut partial[of_channel..][..self.taps()];
                grid.lay(plane, &mut scratch.phases);
                grid.lay_gradient(gradient, &mut scratch.run);
                let gradient = &scratch.run[grid.before..][..grid.blocks() * BLOCK];
                arch.dispatch(Products { sums, gradient, from: &scratch.phases, taps: &grid.taps });
            }
            partial
        });
        let partials: Vec<Vec<f32>> = partials.collect();
        for partial in partials {
            sum.iter_mut().zip(partial).for_each(|(sum, partial)| *sum += partial);
        }
        sum
    }

    /// The gradient by the bias `[channels]`, from the gradient by the output.
    pub fn backward_bias(&self, gradient: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0_f64; self.channels];
        for (index, channel) in gradient.chunks_exact(self.plane_out().max(1)).enumerate() {
            sum[index % self.channels] += f64::from(channel.iter().sum::<f32>());
        }
        sum.into_iter().map(|sum| sum as f32).collect()
    }
}
