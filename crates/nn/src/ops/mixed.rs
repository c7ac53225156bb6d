//! Convolutions in the number format of their input, for mixed precision: parameters stay in 32 bits.

use burn::backend::ops::ConvOptions;
use burn::nn::PaddingConfig2d;
use burn::nn::conv::Conv2d;
use burn::tensor::{DType, Tensor, module};

/// Strides, paddings, dilations and groups of a convolution with explicit or no padding, as all of ours are.
pub(super) fn options(layer: &Conv2d) -> ConvOptions<2> {
    let padding = match layer.padding {
        PaddingConfig2d::Explicit(top, left, bottom, right) => [(top, bottom), (left, right)],
        _ => [(0, 0); 2],
    };
    ConvOptions::new_with_padding(layer.stride, padding, layer.dilation, layer.groups)
}

/// Whether the values are in 16 bits.
pub(crate) fn is_half<const D: usize>(tensor: &Tensor<D>) -> bool {
    matches!(tensor.dtype(), DType::F16 | DType::BF16)
}

/// The same values in 32 bits, if they are in 16.
pub(crate) fn widened<const D: usize>(tensor: Tensor<D>) -> Tensor<D> {
    if is_half(&tensor) { tensor.cast(DType::F32) } else { tensor }
}

/// `layer.forward(input)`, weight and bias rounded to the format of `input`.
pub(super) fn conv2d(layer: &Conv2d, input: Tensor<4>) -> Tensor<4> {
    let format = input.dtype();
    let bias = layer.bias.as_ref().map(|bias| bias.val().cast(format));
    module::conv2d(input, layer.weight.val().cast(format), bias, options(layer))
}
