//! Fully connected layers that are still without weights.

use burn::module::Initializer;
use burn::nn::{Linear, LinearConfig};
use burn::tensor::Device;

/// A fully connected layer, weight `[inputs, outputs]` and bias `[outputs]`. Both are zero until
/// [`crate::parameters::fill`] gives them values.
pub fn linear(inputs: usize, outputs: usize, device: &Device) -> Linear {
    LinearConfig::new(inputs, outputs).with_initializer(Initializer::Zeros).init(device)
}
