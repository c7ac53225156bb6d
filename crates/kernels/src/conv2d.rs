//! Convolution of images as matrix products over their patches.
//!
//! # Model
//! The patches of an image are the columns of a matrix `X` of `channels_in * ky * kx` rows; with
//! the weight as a matrix `W`, the output is `W X`, the gradient by the patches `Wᵀ dY`, and the
//! gradient by the weight `dY Xᵀ`. Small images are taken several at a time, so that no product
//! has only a few columns.

use rayon::prelude::*;

use crate::im2col::{Columns, Scratch, col2im, im2col, resized};
use crate::lanes;
use crate::matmul::{Matrix, matmul};

/// Columns below which images are taken together.
const COLUMNS: usize = 256;
/// Partial sums of a weight gradient: enough for the threads of a desktop, few enough to hold.
const PARTIALS: usize = 16;

/// Shape of a convolution: no groups, no dilation, the same stride and padding along both axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conv2d {
    /// Images.
    pub batch: usize,
    /// Channels of the input.
    pub channels_in: usize,
    /// Rows of the input.
    pub height: usize,
    /// Columns of the input.
    pub width: usize,
    /// Channels of the output.
    pub channels_out: usize,
    /// Rows and columns of the kernel.
    pub kernel: [usize; 2],
    /// Pixels between outputs; at least 1.
    pub stride: usize,
    /// Zeros around the input.
    pub padding: usize,
}

impl Conv2d {
    /// Rows and columns of the output.
    pub fn output(&self) -> [usize; 2] {
        let size = |pixels: usize, kernel: usize| {
            (pixels + 2 * self.padding).checked_sub(kernel).map_or(0, |room| room / self.stride + 1)
        };
        [size(self.height, self.kernel[0]), size(self.width, self.kernel[1])]
    }

    fn pixels_out(&self) -> usize {
        self.output().iter().product()
    }

    fn image_in(&self) -> usize {
        self.channels_in * self.height * self.width
    }

    fn image_out(&self) -> usize {
        self.channels_out * self.pixels_out()
    }

    /// Rows of the patch matrix.
    fn taps(&self) -> usize {
        self.channels_in * self.kernel[0] * self.kernel[1]
    }

    /// Images per matrix product.
    fn group(&self) -> usize {
        COLUMNS.div_ceil(self.pixels_out().max(1)).min(self.batch.max(1))
    }

    fn check(&self, input: usize, weight: usize, output: usize) {
        assert_eq!(input, self.batch * self.image_in(), "length of the input");
        assert_eq!(weight, self.channels_out * self.taps(), "length of the weight");
        assert_eq!(output, self.batch * self.image_out(), "length of the output");
    }

    /// Whether the patches of an image are the image itself.
    pub(crate) fn is_pointwise(&self) -> bool {
        self.kernel == [1, 1] && self.stride == 1 && self.padding == 0
    }

    /// The convolution of `input` with `weight`, plus `bias`.
    ///
    /// # Shapes
    /// - `input`: `[batch, channels_in, height, width]`
    /// - `weight`: `[channels_out, channels_in, ky, kx]`
    /// - `bias`: `[channels_out]`
    /// - output: `[batch, channels_out, oy, ox]`, sizes by [`output`](Self::output)
    pub fn forward(&self, input: &[f32], weight: &[f32], bias: Option<&[f32]>) -> Vec<f32> {
        let mut output = vec![0.0; self.batch * self.image_out()];
        self.check(input.len(), weight.len(), output.len());
        if output.is_empty() {
            return output;
        }
        if lanes::suits(self) {
            lanes::forward(self, input, weight, bias, &mut output);
            return output;
        }
        let group = self.group();
        let weight = Matrix::new(weight, self.channels_out, self.taps());
        output
            .par_chunks_mut(group * self.image_out())
            .zip(input.par_chunks(group * self.image_in()))
            .for_each_init(Scratch::default, |scratch, (output, images)| {
                let count = output.len() / self.image_out();
                let patches =
                    self.patches(images, count, &mut scratch.patches, &mut scratch.planes);
                if count == 1 {
                    matmul(output, weight, patches, false);
                } else {
                    let pixels = resized(&mut scratch.pixels, output.len());
                    matmul(pixels, weight, patches, false);
                    self.split(pixels, output);
                }
                if let Some(bias) = bias {
                    let channels = output.chunks_exact_mut(self.pixels_out());
                    for (channel, bias) in channels.zip(bias.iter().cycle()) {
                        channel.iter_mut().for_each(|y| *y += bias);
                    }
                }
            });
        output
    }

    /// The gradient by the input, from the gradient by the output. Shapes as in
    /// [`forward`](Self::forward).
    pub fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        let mut input = vec![0.0; self.batch * self.image_in()];
        self.check(input.len(), weight.len(), gradient.len());
        if gradient.is_empty() || input.is_empty() {
            return input;
        }
        if lanes::suits(self) {
            lanes::backward_input(self, weight, gradient, &mut input);
            return input;
        }
        let group = self.group();
        let (taps, pixels_out) = (self.taps(), self.pixels_out());
        let weight = Matrix::new(weight, self.channels_out, taps).transposed();
        input
            .par_chunks_mut(group * self.image_in())
            .zip(gradient.par_chunks(group * self.image_out()))
            .for_each_init(Scratch::default, |scratch, (images, gradient)| {
                let count = gradient.len() / self.image_out();
                let gradient = self.joined(gradient, count, &mut scratch.pixels);
                if count == 1 && self.is_pointwise() {
                    matmul(images, weight, gradient, false);
                    return;
                }
                let width = count * pixels_out;
                let patches = resized(&mut scratch.patches, taps * width);
                matmul(patches, weight, gradient, false);
                for (index, image) in images.chunks_exact_mut(self.image_in()).enumerate() {
                    col2im(
                        self,
                        patches,
                        &mut scratch.planes,
                        image,
                        Columns { width, start: index * pixels_out },
                    );
                }
            });
        input
    }

    /// The gradient by the weight, from the gradient by the output. Shapes as in
    /// [`forward`](Self::forward).
    pub fn backward_weight(&self, input: &[f32], gradient: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0; self.channels_out * self.taps()];
        self.check(input.len(), sum.len(), gradient.len());
        if gradient.is_empty() || input.is_empty() {
            return sum;
        }
        if lanes::suits(self) {
            lanes::backward_weight(self, input, gradient, &mut sum);
            return sum;
        }
        let group = self.group();
        let part = self.batch.div_ceil(group).div_ceil(PARTIALS) * group;
        let partials: Vec<Vec<f32>> = input
            .par_chunks(part * self.image_in())
            .zip(gradient.par_chunks(part * self.image_out()))
            .map_init(Scratch::default, |scratch, (images, gradient)| {
                let mut partial = vec![0.0; self.channels_out * self.taps()];
                let images = images.chunks(group * self.image_in());
                for (images, gradient) in images.zip(gradient.chunks(group * self.image_out())) {
                    let count = gradient.len() / self.image_out();
                    let patches =
                        self.patches(images, count, &mut scratch.patches, &mut scratch.planes);
                    let gradient = self.joined(gradient, count, &mut scratch.pixels);
                    matmul(&mut partial, gradient, patches.transposed(), true);
                }
                partial
            })
            .collect();
        for partial in partials {
            sum.iter_mut().zip(partial).for_each(|(sum, partial)| *sum += partial);
        }
        sum
    }

    /// The gradient by the bias `[channels_out]`, from the gradient by the output.
    pub fn backward_bias(&self, gradient: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0_f64; self.channels_out];
        for (index, channel) in gradient.chunks_exact(self.pixels_out().max(1)).enumerate() {
            sum[index % self.channels_out] += f64::from(channel.iter().sum::<f32>());
        }
        sum.into_iter().map(|sum| sum as f32).collect()
    }

    /// The patches of `count` images beside each other: `[taps, count * pixels_out]`.
    fn patches<'a>(
        &self,
        images: &'a [f32],
        count: usize,
        scratch: &'a mut Vec<f32>,
        planes: &mut Vec<f32>,
    ) -> Matrix<'a> {
        let width = count * self.pixels_out();
        if count == 1 && self.is_pointwise() {
            return Matrix::new(images, self.taps(), width);
        }
        let matrix = resized(scratch, self.taps() * width);
        for (index, image) in images.chunks_exact(self.image_in()).enumerate() {
            im2col(
                self,
                image,
                planes,
                matrix,
                Columns { width, start: index * self.pixels_out() },
            );
        }
        Matrix::new(matrix, self.taps(), width)
    }

    /// The outputs of `count` images beside each other: `[channels_out, count * pixels_out]`.
    fn joined<'a>(&self, images: &'a [f32], count: usize, scratch: &'a mut Vec<f32>) -> Matrix<'a> {
        let (pixels, width) = (self.pixels_out(), count * self.pixels_out());
        if count == 1 {
            return Matrix::new(images, self.channels_out, width);
        }
        let joined = resized(scratch, images.len());
        for (index, channel) in images.chunks_exact(pixels).enumerate() {
            let at = index % self.channels_out * width + index / self.channels_out * pixels;
            joined[at..at + pixels].copy_from_slice(channel);
        }
        Matrix::new(joined, self.channels_out, width)
    }

    /// The inverse of [`joined`](Self::joined).
    fn split(&self, joined: &[f32], images: &mut [f32]) {
        let pixels = self.pixels_out();
        let width = joined.len() / self.channels_out;
        for (index, channel) in images.chunks_exact_mut(pixels).enumerate() {
            let at = index % self.channels_out * width + index / self.channels_out * pixels;
            channel.copy_from_slice(&joined[at..at + pixels]);
        }
    }
}
