//! The convolution itself.

use pulp::{Arch, Simd, WithSimd, bytemuck};
use rayon::prelude::*;

use super::layout::{Planes, corners, packed, taps, tiles};
use super::{TILE, lanes};
use crate::conv2d::Conv2d;
use crate::im2col::{Scratch, resized};

/// As [`Conv2d::forward`].
pub(crate) fn forward(
    conv: &Conv2d,
    input: &[f32],
    weight: &[f32],
    bias: Option<&[f32]>,
    output: &mut [f32],
) {
    let lanes = lanes();
    let (from, to) = (Planes::of_input(conv, lanes), Planes::of_output(conv, lanes));
    let weight = packed::<TILE>(conv, weight, false);
    let (taps, corners) = (taps(conv, &from), corners(conv, &from));
    let image = |planes: &Planes, images: &[f32]| images.len() / conv.batch * planes.lanes;
    let (image_in, image_out) = (image(&from, input), image(&to, output));
    output.par_chunks_mut(image_out).zip(input.par_chunks(image_in)).for_each_init(
        Scratch::default,
        |scratch, (output, images)| {
            let input = resized(&mut scratch.planes, from.len());
            from.spread(images, input);
            let pixels = resized(&mut scratch.pixels, to.len());
            Arch::new().dispatch(Forward {
                area: from.area(),
                channels_in: conv.channels_in,
                taps: &taps,
                corners: &corners,
                weight: &weight,
                bias,
                input,
                output: pixels,
            });
            to.gather(pixels, output);
        },
    );
}

struct Forward<'a> {
    /// Pixels of an input plane.
    area: usize,
    channels_in: usize,
    taps: &'a [usize],
    corners: &'a [usize],
    weight: &'a [[f32; TILE]],
    bias: Option<&'a [f32]>,
    /// `[channels_in, area, lanes]`.
    input: &'a [f32],
    /// `[channels_out, outputs, lanes]`.
    output: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let input: &[S::f32s] = bytemuck::cast_slice(self.input);
        let output: &mut [S::f32s] = bytemuck::cast_slice_mut(self.output);
        let outputs = self.corners.len();
        let channels = output.chunks_mut(TILE * outputs);
        let weights = self.weight.chunks_exact(self.channels_in * self.taps.len());
        for (block, (channels, weights)) in channels.zip(weights).enumerate() {
            let bias = |row: usize| self.bias.and_then(|bias| bias.get(block * TILE + row));
            let start: [S::f32s; TILE] =
                core::array::from_fn(|row| simd.splat_f32s(bias(row).copied().unwrap_or(0.0)));
            for (first, _) in tiles::<TILE>(outputs) {
                let at: [usize; TILE] =
                    core::array::from_fn(|pixel| self.corners[(first + pixel).min(outputs - 1)]);
                let mut sums = start.map(|bias| [bias; TILE]);
                let planes = input.chunks_exact(self.area);
                for (plane, weights) in planes.zip(weights.chunks_exact(self.taps.len())) {
                    for (&tap, weight) in self.taps.iter().zip(weights) {
                        let x = at.map(|corner| plane[corner + tap]);
                        for (sums, weight) in sums.iter_mut().zip(weight) {
                            let weight = simd.splat_f32s(*weight);
                            for (sum, x) in sums.iter_mut().zip(x) {
                                *sum = simd.mul_add_f32s(weight, x, *sum);
                            }
                        }
                    }
                }
                for (channel, sums) in channels.chunks_exact_mut(outputs).zip(sums) {
                    for (pixel, sum) in channel[first..].iter_mut().zip(sums) {
                        *pixel = sum;
                    }
                }
            }
        }
    }
}
