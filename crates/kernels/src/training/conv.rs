//! Convolution in training, by the algorithm that suits its shape.

use super::blocks::Blocks;
use super::norm::{NormalizedInput, channel_sums};
use super::shape::Conv;
use super::{direct, direct_weight, few_channels, winograd, winograd_weight};

impl Conv {
    /// The convolution of `input`.
    ///
    /// # Shapes
    /// - `weight`: `[channels_out, channels_in, kernel, kernel]`; `bias`: `[channels_out]`
    ///
    /// # Panics
    /// If a slice has another length, here and in the gradients.
    pub fn forward(
        &self,
        input: NormalizedInput<'_>,
        weight: &[f32],
        bias: Option<&[f32]>,
    ) -> Vec<f32> {
        self.check(input.values.len(), weight.len(), self.output().value_count());
        assert!(bias.is_none_or(|bias| bias.len() == self.channels_out), "bias");
        let weights = self.weights(weight, false);
        if self.is_winograd() {
            return winograd::convolved(self.input, input, weights, bias, self.level);
        }
        direct::forward(self, input, weights, bias)
    }

    /// The gradient by the normalised input, from the gradient by the output.
    pub fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        self.check(self.input.value_count(), weight.len(), gradient.len());
        let weights = self.weights(weight, true);
        if self.is_winograd() {
            return winograd::convolved(self.output(), gradient.into(), weights, None, self.level);
        }
        if few_channels::suits(self) {
            return few_channels::backward_input(self, weight, gradient);
        }
        direct::backward_input(self, weights, gradient)
    }

    /// The gradient by the weight, from the gradient by the output.
    pub fn backward_weight(&self, input: NormalizedInput<'_>, gradient: &[f32]) -> Vec<f32> {
        self.check(input.values.len(), self.weight_count(), gradient.len());
        if self.is_winograd() {
            return winograd_weight::gradient(self, input, gradient);
        }
        direct_weight::gradient(self, input, gradient)
    }

    fn check(&self, input: usize, weight: usize, output: usize) {
        assert!(
            matches!(self.stride, 1 | 2) && self.kernel % 2 == 1,
            "a square kernel, stride 1 or 2"
        );
        assert_eq!(input, self.input.value_count(), "values of the input");
        assert_eq!(weight, self.weight_count(), "values of the weight");
        assert_eq!(output, self.output().value_count(), "values of the output");
    }
}

/// The gradient by the bias of a layer with this output, from the gradient by the output.
pub fn backward_bias(output: &Blocks, gradient: &[f32]) -> Vec<f32> {
    assert_eq!(gradient.len(), output.value_count(), "values of the output");
    channel_sums(output, gradient)
}
