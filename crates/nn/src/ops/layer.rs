//! The convolutions that our kernels compute.

use burn::nn::PaddingConfig2d;
use burn::nn::conv::Conv2d;
use evpose_kernels::Level;
use evpose_kernels::training::{Blocks, Conv, Depthwise, NormalizedInput};

/// A convolution of all channels, or one of each channel by itself.
#[derive(Debug, Clone, Copy)]
pub(super) enum ConvLayer {
    Full(Conv),
    Depthwise(Depthwise),
}

impl ConvLayer {
    /// The shape of `layer` on images of shape `input`; none if our kernels do not compute it.
    pub(super) fn new(layer: &Conv2d, input: Blocks) -> Option<Self> {
        let [channels_out, of_group, kernel, across] = layer.weight.dims();
        let [stride, stride_x] = layer.stride;
        // Odd kernels with the padding that keeps the side, and strides of 1 and 2: all that our
        // networks use. Everything else goes Burn's way.
        let half = kernel / 2;
        let is_supported = kernel == across
            && kernel % 2 == 1
            && stride == stride_x
            && matches!(stride, 1 | 2)
            && layer.dilation == [1, 1]
            && layer.padding == PaddingConfig2d::Explicit(half, half, half, half);
        let level = Level::best();
        match layer.groups {
            1 if is_supported && of_group == input.channels => {
                Some(Self::Full(Conv { input, channels_out, kernel, stride, level }))
            }
            groups
                if is_supported
                    && of_group == 1
                    && [groups, channels_out] == [input.channels; 2] =>
            {
                Some(Self::Depthwise(Depthwise { input, kernel, stride, level }))
            }
            _ => None,
        }
    }

    pub(super) fn output(&self) -> Blocks {
        match self {
            Self::Full(conv) => conv.output(),
            Self::Depthwise(conv) => conv.output(),
        }
    }

    pub(super) fn forward(
        &self,
        input: NormalizedInput<'_>,
        weight: &[f32],
        bias: Option<&[f32]>,
    ) -> Vec<f32> {
        match self {
            Self::Full(conv) => conv.forward(input, weight, bias),
            Self::Depthwise(conv) => conv.forward(input, weight, bias),
        }
    }

    pub(super) fn backward_input(&self, weight: &[f32], gradient: &[f32]) -> Vec<f32> {
        match self {
            Self::Full(conv) => conv.backward_input(weight, gradient),
            Self::Depthwise(conv) => conv.backward_input(weight, gradient),
        }
    }

    pub(super) fn backward_weight(&self, input: NormalizedInput<'_>, gradient: &[f32]) -> Vec<f32> {
        match self {
            Self::Full(conv) => conv.backward_weight(input, gradient),
            Self::Depthwise(conv) => conv.backward_weight(input, gradient),
        }
    }
}
