//! Convolution in training, by the algorithm that suits its shape.

use super::blocks::Blocks;
use super::norm::{Input, channel_sums};
use super::weights::Weights;
use super::{direct, few, winograd, winograd_weight};
use crate::simd::Level;

/// Pixels of a batch for which weights are worth their transforms, which are four times as large.
const WORTH_TRANSFORMS: usize = 1500;

/// A square convolution that keeps the image size, up to its stride.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conv {
    /// Shape of the input.
    pub input: Blocks,
    /// Channels of the output.
    pub channels_out: usize,
    /// Rows and columns of the kernel; odd.
    pub kernel: usize,
    /// Pixels between outputs: 1 or 2.
    pub stride: usize,
    /// The instructions to compute with.
    pub level: Level,
}

impl Conv {
    /// Shape of the output.
    pub fn output(&self) -> Blocks {
        Blocks {
            channels: self.channels_out,
            height: self.input.height.div_ceil(self.stride),
            width: self.input.width.div_ceil(self.stride),
            ..self.input
        }
    }

    /// The convolution of `input`.
    ///
    /// # Shapes
    /// - `weight`: `[channels_out, channels_in, kernel, kernel]`; `bias`: `[channels_out]`
    pub fn forward(&self, input: Input<'_>, weight: &[f32], bias: Option<&[f32]>) -> Vec<f32> {
        self.check(input.values.len(), weight.len(), self.output().numbers());
        assert!(bias.is_none_or(|bias| bias.len() == self.channels_out), "bias");
        if self.is_winograd() {
            return winograd::convolved(
                self.input,
                input,
                self.weights(weight, false),
                bias,
                self.level,
            );
        }
        direct::forward(self, input, self.weights(weight, false), bias)
    }

    /// The gradient by the input as the convolution takes it, from the gradient by the output.
    pub fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        self.check(self.input.numbers(), weight.len(), gradient.len());
        let weights = self.weights(weight, true);
        if self.is_winograd() {
            return winograd::convolved(self.output(), gradient.into(), weights, None, self.level);
        }
        if few::suits(self) {
            return few::backward_input(self, weight, gradient);
        }
        direct::backward_input(self, weights, gradient)
    }

    /// The gradient by the weight, from the gradient by the output.
    pub fn backward_weight(&self, input: Input<'_>, gradient: &[f32]) -> Vec<f32> {
        self.check(input.values.len(), self.weight(), gradient.len());
        if self.is_winograd() {
            return winograd_weight::gradient(self, input, gradient);
        }
        direct::backward_weight(self, input, gradient)
    }

    /// The gradient by the bias, from the gradient by the output.
    pub fn backward_bias(&self, gradient: &[f32]) -> Vec<f32> {
        channel_sums(&self.output(), gradient)
    }

    /// Blocks of channels of the output that are made together.
    pub(super) fn together(&self) -> usize {
        together(self.level)
    }

    fn is_winograd(&self) -> bool {
        let pixels = self.input.batch * self.input.height * self.input.width;
        self.kernel == 3 && self.stride == 1 && pixels >= WORTH_TRANSFORMS
    }

    /// Numbers of the weight.
    fn weight(&self) -> usize {
        self.channels_out * self.input.channels * self.kernel.pow(2)
    }

    pub(super) fn weights<'a>(&self, values: &'a [f32], is_turned: bool) -> Weights<'a> {
        let shape = [self.channels_out, self.input.channels, self.kernel.pow(2)];
        Weights { values, shape, is_turned }
    }

    fn check(&self, input: usize, weight: usize, output: usize) {
        assert!(
            matches!(self.stride, 1 | 2) && self.kernel % 2 == 1,
            "a square kernel, stride 1 or 2"
        );
        assert_eq!(input, self.input.numbers(), "numbers of the input");
        assert_eq!(weight, self.weight(), "numbers of the weight");
        assert_eq!(output, self.output().numbers(), "numbers of the output");
    }
}

/// Blocks of channels whose sums registers hold.
pub(super) fn together(level: Level) -> usize {
    if level.holds_two() { 2 } else { 1 }
}
