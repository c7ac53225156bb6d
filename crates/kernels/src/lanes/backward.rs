//! The gradients of the convolution.

use pulp::{Arch, Simd, WithSimd, bytemuck};
use rayon::prelude::*;

use super::layout::{Planes, corners, packed, taps, tiles};
use super::{TILE, lanes};
use crate::conv2d::Conv2d;
use crate::im2col::{Scratch, resized};

/// As [`Conv2d::backward_input`].
pub(crate) fn backward_input(conv: &Conv2d, weight: &[f32], gradient: &[f32], input: &mut [f32]) {
    let lanes = lanes();
    let (to, from) = (Planes::of_input(conv, lanes), Planes::of_output(conv, lanes));
    let weight = packed::<TILE>(conv, weight, true);
    let (taps, corners) = (taps(conv, &to), corners(conv, &to));
    let (image_in, image_out) = (input.len() / conv.batch, gradient.len() / conv.batch);
    input
        .par_chunks_mut(lanes * image_in)
        .zip(gradient.par_chunks(lanes * image_out))
        .for_each_init(Scratch::default, |scratch, (images, gradient)| {
            let outputs = resized(&mut scratch.pixels, from.len());
            from.spread(gradient, outputs);
            let planes = resized(&mut scratch.planes, to.len());
            planes.fill(0.0);
            Arch::new().dispatch(Input {
                area: to.area(),
                channels_out: conv.channels_out,
                taps: &taps,
                corners: &corners,
                weight: &weight,
                gradient: outputs,
                input: planes,
            });
            to.gather(planes, images);
        });
}

struct Input<'a> {
    /// Pixels of an input plane.
    area: usize,
    channels_out: usize,
    taps: &'a [usize],
    corners: &'a [usize],
    weight: &'a [[f32; TILE]],
    /// `[channels_out, outputs, lanes]`.
    gradient: &'a [f32],
    /// `[channels_in, area, lanes]`, added to.
    input: &'a mut [f32],
}

impl WithSimd for Input<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let gradient: &[S::f32s] = bytemuck::cast_slice(self.gradient);
        let input: &mut [S::f32s] = bytemuck::cast_slice_mut(self.input);
        let outputs = self.corners.len();
        let planes = input.chunks_mut(TILE * self.area);
        let weights = self.weight.chunks_exact(self.channels_out * self.taps.len());
        for (planes, weights) in planes.zip(weights) {
            for (first, done) in tiles::<TILE>(outputs) {
                let at: [usize; TILE] =
                    core::array::from_fn(|pixel| (first + pixel).min(outputs - 1));
                for (tap, &offset) in self.taps.iter().enumerate() {
                    let mut sums = [[simd.splat_f32s(0.0); TILE]; TILE];
                    let weights = weights.chunks_exact(self.taps.len());
                    for (channel, weights) in gradient.chunks_exact(outputs).zip(weights) {
                        let dy = at.map(|pixel| channel[pixel]);
                        for (sums, weight) in sums.iter_mut().zip(weights[tap]) {
                            let weight = simd.splat_f32s(weight);
                            for (sum, dy) in sums.iter_mut().zip(dy) {
                                *sum = simd.mul_add_f32s(weight, dy, *sum);
                            }
                        }
                    }
                    let corners = &self.corners[first..outputs.min(first + TILE)];
                    for (plane, sums) in planes.chunks_exact_mut(self.area).zip(sums) {
                        for (corner, sum) in corners.iter().zip(sums).skip(done) {
                            let pixel = &mut plane[corner + offset];
                            *pixel = simd.add_f32s(*pixel, sum);
                        }
                    }
                }
            }
        }
    }
}

/// As [`Conv2d::backward_weight`].
pub(crate) fn backward_weight(conv: &Conv2d, input: &[f32], gradient: &[f32], sum: &mut [f32]) {
    let lanes = lanes();
    let (planes, outputs) = (Planes::of_input(conv, lanes), Planes::of_output(conv, lanes));
    let groups = conv.batch.div_ceil(lanes);
    let spread = |layout: &Planes, images: &[f32]| {
        let mut all = vec![0.0; groups * layout.len()];
        all.par_chunks_mut(layout.len())
            .zip(images.par_chunks(images.len() / conv.batch * lanes))
            .for_each(|(planes, images)| layout.spread(images, planes));
        all
    };
    let (input, gradient) = (spread(&planes, input), spread(&outputs, gradient));
    let (taps, corners) = (taps(conv, &planes), corners(conv, &planes));
    let rows = conv.channels_in * taps.len();
    // One piece of work for each tile of output channels and row of the kernel's taps: every weight
    // is summed by one of them, in one order.
    sum.par_chunks_mut(TILE * rows).enumerate().for_each(|(tile, sum)| {
        (0..conv.channels_in.div_ceil(TILE)).for_each(|inner| {
            Arch::new().dispatch(Weight {
                planes: &planes,
                outputs: &outputs,
                taps: &taps,
                corners: &corners,
                input: &input,
                gradient: &gradient,
                first_out: tile * TILE,
                first_in: inner * TILE,
                sum,
            });
        });
    });
}

struct Weight<'a> {
    planes: &'a Planes,
    outputs: &'a Planes,
    taps: &'a [usize],
    corners: &'a [usize],
    /// `[groups, channels_in, area, lanes]`.
    input: &'a [f32],
    /// `[groups, channels_out, outputs, lanes]`.
    gradient: &'a [f32],
    first_out: usize,
    first_in: usize,
    /// `[up to a tile of channels_out, channels_in, taps]`.
    sum: &'a mut [f32],
}

impl WithSimd for Weight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let input: &[S::f32s] = bytemuck::cast_slice(self.input);
        let gradient: &[S::f32s] = bytemuck::cast_slice(self.gradient);
        let (area, outputs) = (self.planes.area(), self.corners.len());
        let (channels_in, channels_out) = (self.planes.channels, self.outputs.channels);
        // Beyond the last channel the last one is taken again, and dropped at the end.
        let out: [usize; TILE] =
            core::array::from_fn(|row| (self.first_out + row).min(channels_out - 1) * outputs);
        let inner: [usize; TILE] =
            core::array::from_fn(|row| (self.first_in + row).min(channels_in - 1) * area);
        for (tap, &offset) in self.taps.iter().enumerate() {
            let mut sums = [[simd.splat_f32s(0.0); TILE]; TILE];
            let groups = input.chunks_exact(channels_in * area);
            for (input, gradient) in groups.zip(gradient.chunks_exact(channels_out * outputs)) {
                let dy = out.map(|start| &gradient[start..start + outputs]);
                let x = inner.map(|start| &input[start..start + area]);
                for (pixel, corner) in self.corners.iter().enumerate() {
                    let dy = dy.map(|channel| channel[pixel]);
                    let x = x.map(|plane| plane[corner + offset]);
                    for (sums, dy) in sums.iter_mut().zip(dy) {
                        for (sum, x) in sums.iter_mut().zip(x) {
                            *sum = simd.mul_add_f32s(dy, x, *sum);
                        }
                    }
                }
            }
            let rows = self.sum.chunks_exact_mut(channels_in * self.taps.len());
            for (row, sums) in rows.zip(sums) {
                let weights = row.chunks_exact_mut(self.taps.len()).skip(self.first_in);
                for (weights, sum) in weights.zip(sums) {
                    weights[tap] = simd.reduce_sum_f32s(sum);
                }
            }
        }
    }
}
