//! Execution of operators on the buffers of a plan.

use evpose_kernels::Level;
use evpose_kernels::blocked::{
    ChainInput, Image, Scratch, ThreadPool, adaptive_avg_pool, add, add_mixed_precision, affine,
    concat, flatten, gather_channels, max_pool_low_precision, sigmoid, upsample,
    upsample_low_precision,
};

use super::Step;
use crate::buffer::Buffer;

/// Buffers and threads that a step runs with.
pub(crate) struct StepContext<'a> {
    pub(crate) thread_pool: &'a ThreadPool,
    pub(crate) level: Level,
    pub(crate) inputs: &'a [&'a Buffer],
    pub(crate) output: &'a mut Buffer,
    pub(crate) scratch: &'a mut Scratch,
}

impl Step {
    pub(crate) fn run(&self, context: StepContext<'_>) {
        let StepContext { thread_pool, level, inputs, output, scratch } = context;
        let other = inputs.get(1).copied();
        match self {
            Self::LowPrecisionConv(conv, _, activation) => {
                let residual = other.map(Buffer::view);
                conv.run(
                    thread_pool,
                    inputs[0].low_precision(),
                    residual,
                    *activation,
                    output.view_mut(),
                );
            }
            Self::Chain(chain) => {
                let source = match inputs[0] {
                    Buffer::Nchw(image) => ChainInput::Nchw(image),
                    image => ChainInput::Image(image.f32()),
                };
                let residual = other.map(Buffer::f32);
                chain.run(thread_pool, source, residual, output.f32_mut(), scratch);
            }
            // The first layer: the image of the caller is not blocked.
            Self::Conv(conv, activation) if matches!(inputs[0], Buffer::Nchw(_)) => {
                conv.run_nchw(thread_pool, inputs[0].nchw(), *activation, output.f32_mut());
            }
            Self::NchwConv(conv, activation) => {
                conv.run(thread_pool, inputs[0].nchw(), *activation, output.view_mut());
            }
            Self::Depthwise(conv, activation) => {
                conv.run(thread_pool, inputs[0].f32(), *activation, output.view_mut());
            }
            Self::QuantizedDepthwise(conv, activation) => {
                conv.run(thread_pool, inputs[0].low_precision(), *activation, output.view_mut());
            }
            Self::LowPrecisionMaxPool(pool) => {
                max_pool_low_precision(
                    thread_pool,
                    level,
                    *pool,
                    inputs[0].low_precision(),
                    output.low_precision_mut(),
                );
            }
            Self::LowPrecisionUpsample => {
                upsample_low_precision(
                    thread_pool,
                    level,
                    inputs[0].low_precision(),
                    output.low_precision_mut(),
                );
            }
            Self::LowPrecisionAdd(activation) => {
                let (one, other) = (inputs[0].view(), other.map(Buffer::view));
                add_mixed_precision(thread_pool, level, one, other, *activation, output.view_mut());
            }
            _ => {
                let inputs: Vec<&Image> = inputs.iter().map(|input| input.f32()).collect();
                self.run_f32(thread_pool, level, &inputs, output.f32_mut(), scratch);
            }
        }
    }

    /// Runs a step whose inputs and output are f32 in nChw16c.
    fn run_f32(
        &self,
        thread_pool: &ThreadPool,
        level: Level,
        inputs: &[&Image],
        output: &mut Image,
        scratch: &mut Scratch,
    ) {
        let (input, other) = (inputs[0], inputs.get(1).copied());
        match self {
            Self::Conv(conv, activation) => {
                conv.run(thread_pool, input, other, *activation, output);
            }
            Self::Winograd(conv, activation) => {
                conv.run(thread_pool, input, other, *activation, output, scratch);
            }
            Self::MaxPool(pool) => pool.run(thread_pool, level, input, output),
            Self::AvgPool => adaptive_avg_pool(thread_pool, level, input, output),
            Self::Flatten => flatten(input, output),
            Self::Add(activation) => add(thread_pool, level, input, other, *activation, output),
            Self::Channels(start) => gather_channels(output, |channel| (input, start + channel)),
            Self::Interleave => {
                let both = [input, inputs[1]];
                gather_channels(output, |channel| (both[channel % 2], channel / 2));
            }
            Self::Concat => concat(inputs, output),
            Self::Upsample => upsample(thread_pool, level, input, output),
            Self::Sigmoid => sigmoid(thread_pool, level, input, output),
            Self::Affine(affine_params) => {
                affine(thread_pool, level, input, *affine_params, output);
            }
            Self::Chain(_)
            | Self::NchwConv(..)
            | Self::LowPrecisionConv(..)
            | Self::Depthwise(..)
            | Self::QuantizedDepthwise(..)
            | Self::LowPrecisionMaxPool(_)
            | Self::LowPrecisionUpsample
            | Self::LowPrecisionAdd(_) => unreachable!("steps on other storage types"),
        }
    }
}
