//! The operations of a plan.

use evpose_kernels::Level;
use evpose_kernels::blocked::{
    Chain, ChainInput, Conv, ConvShape, Depthwise, DepthwiseShape, Image, Link, LowPrecisionConv,
    LowPrecisionDepthwise, LowPrecisionType, MaxPool, NchwConv, Scratch, ThreadPool, TileSize,
    Winograd, adaptive_avg_pool, add, add_mixed_precision, affine, flatten, gather_channels,
    max_pool_low_precision, sigmoid, upsample, upsample_low_precision,
};
use evpose_nn::graph::{Activation, ConvLayer, LinearLayer, Node, Operation};

use crate::InferError;
use crate::buffer::{Buffer, StorageType};
use crate::shapes::Shape;

/// Input channels from which transforming the weights to F(4, 3) takes longer than it saves, if
/// there are few tiles.
const TRANSFORM_BOUND_CHANNELS: usize = 512;
/// Tiles of F(4, 3) from which it is faster for any number of channels.
const ENOUGH_TILES: usize = 12;
/// Smallest number of tiles for which Winograd is faster than direct convolution.
const MIN_TILES: usize = 6;
/// Largest number of channels of an input in nchw: in nChw16c it would be at least four times as
/// large.
const MAX_NCHW_CHANNELS: usize = 4;
/// Smallest number of channels for Winograd: convolutions of fewer have too few multiplications to
/// save.
const MIN_CHANNELS: usize = 16;

/// An operator of a plan with its packed weights.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    Conv(Conv, Activation),
    /// Of the input of the network, in nchw.
    NchwConv(NchwConv, Activation),
    Winograd(Winograd, Activation),
    Depthwise(Depthwise, Activation),
    MaxPool(MaxPool),
    AvgPool,
    Flatten,
    Add(Activation),
    /// Slice of channels from this one on.
    Channels(usize),
    Interleave,
    Upsample,
    Sigmoid,
    /// Scale and shift.
    Affine([f32; 2]),
    /// Several fused steps.
    Chain(Chain),
    LowPrecisionConv(LowPrecisionConv, LowPrecisionType, Activation),
    LowPrecisionDepthwise(LowPrecisionDepthwise, LowPrecisionType, Activation),
    LowPrecisionMaxPool(MaxPool),
    LowPrecisionUpsample,
    /// Of two inputs of any storage types; of one input, a conversion.
    LowPrecisionAdd(Activation),
}

/// Buffers and threads that a step runs with.
pub(crate) struct StepContext<'a> {
    pub(crate) thread_pool: &'a ThreadPool,
    pub(crate) level: Level,
    pub(crate) inputs: &'a [&'a Buffer],
    pub(crate) output: &'a mut Buffer,
    pub(crate) scratch: &'a mut Scratch,
}

impl Step {
    /// Step of a node without fusion.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] if there is no kernel for it.
    pub(crate) fn of(node: &Node, level: Level) -> Result<Self, InferError> {
        let unsupported = |operation: &str| {
            Err(InferError::Unsupported {
                layer: node.name.clone(),
                operation: operation.to_owned(),
            })
        };
        match &node.operation {
            Operation::MaxPool { window, stride, padding } => {
                let is_square = [window, stride, padding].iter().all(|side| side[0] == side[1]);
                if !is_square {
                    return unsupported("max-pool whose windows are not square");
                }
                let [window, stride, padding] = [window[0], stride[0], padding[0]];
                Ok(Self::MaxPool(MaxPool { window, stride, padding }))
            }
            Operation::MeanPool { .. } => Ok(Self::AvgPool),
            Operation::Flatten => Ok(Self::Flatten),
            Operation::Linear(linear) => Ok(Self::linear(linear, level)),
            Operation::Relu => Ok(Self::Add(Activation::Relu)),
            Operation::Channels(range) => Ok(Self::Channels(range.start)),
            Operation::Interleave => Ok(Self::Interleave),
            Operation::Upsample => Ok(Self::Upsample),
            Operation::Sigmoid => Ok(Self::Sigmoid),
            Operation::Affine { factor, offset } => Ok(Self::Affine([*factor, *offset])),
            other => unsupported(&format!("operation {other:?}")),
        }
    }

    /// A fully connected layer, as a 1x1 convolution of a single pixel.
    fn linear(linear: &LinearLayer, level: Level) -> Self {
        let [inputs, outputs] = linear.shape;
        let shape = ConvShape { channels_in: inputs, channels_out: outputs, kernel: 1, stride: 1 };
        let mut weight = vec![0.0; inputs * outputs];
        for (input, row) in linear.weight.chunks(outputs).enumerate() {
            for (output, value) in row.iter().enumerate() {
                weight[output * inputs + input] = *value;
            }
        }
        Self::Conv(Conv::new(shape, &weight, &linear.bias, level), Activation::Identity)
    }

    /// A convolution with its epilogue, for an input of type `storage`.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] if there is no kernel for it.
    pub(crate) fn conv(
        name: &str,
        conv: &ConvLayer,
        output: Shape,
        has_residual: bool,
        activation: Activation,
        level: Level,
        storage: StorageType,
    ) -> Result<Self, InferError> {
        let unsupported =
            |operation: String| Err(InferError::Unsupported { layer: name.to_owned(), operation });
        let [channels_out, channels_per_group, kernel, kernel_x] = conv.shape;
        let [stride, stride_x] = conv.stride;
        if kernel != kernel_x || stride != stride_x || conv.dilation != [1, 1] {
            return unsupported(
                "convolution that is not square, or with gaps between its taps".to_owned(),
            );
        }
        if kernel % 2 == 0 || !matches!(stride, 1 | 2) || conv.padding != [kernel / 2; 4] {
            return unsupported(format!(
                "convolution of {kernel}x{kernel}, stride {stride} and padding {:?}",
                conv.padding
            ));
        }
        if conv.groups == 1 {
            let shape = ConvShape { channels_in: channels_per_group, channels_out, kernel, stride };
            if let StorageType::LowPrecision(element_type) = storage {
                let conv =
                    LowPrecisionConv::new(shape, &conv.weight, &conv.bias, element_type, level);
                return Ok(Self::LowPrecisionConv(conv, element_type, activation));
            }
            return Ok(match winograd_tile(shape, output) {
                None => Self::Conv(Conv::new(shape, &conv.weight, &conv.bias, level), activation),
                Some(size) => {
                    let channels = [channels_per_group, channels_out];
                    let conv = Winograd::new(channels, &conv.weight, &conv.bias, size, level);
                    Self::Winograd(conv, activation)
                }
            });
        }
        if conv.groups != channels_out
            || channels_per_group != 1
            || !matches!(kernel, 3 | 5)
            || has_residual
        {
            return unsupported(format!(
                "convolution of {kernel}x{kernel} in {} groups",
                conv.groups
            ));
        }
        let shape = DepthwiseShape { channels: channels_out, kernel, stride };
        if let StorageType::LowPrecision(element_type) = storage {
            let conv =
                LowPrecisionDepthwise::new(shape, &conv.weight, &conv.bias, element_type, level);
            return Ok(Self::LowPrecisionDepthwise(conv, element_type, activation));
        }
        let conv = Depthwise::new(shape, &conv.weight, &conv.bias, level);
        Ok(Self::Depthwise(conv, activation))
    }

    /// A convolution of the network's input in nchw, if there is a kernel for it. At a precision
    /// other than f32 only [`NchwConv`] writes the output.
    pub(crate) fn nchw_conv(
        conv: &ConvLayer,
        activation: Activation,
        level: Level,
        is_f32: bool,
    ) -> Option<Self> {
        let [channels_out, channels_in, kernel, kernel_x] = conv.shape;
        let shape = ConvShape { channels_in, channels_out, kernel, stride: conv.stride[0] };
        let is_plain = kernel == kernel_x
            && conv.stride[0] == conv.stride[1]
            && conv.groups == 1
            && conv.dilation == [1, 1]
            && conv.padding == [kernel / 2; 4];
        if is_plain && NchwConv::supports(shape) {
            let conv = NchwConv::new(shape, &conv.weight, &conv.bias, level);
            return Some(Self::NchwConv(conv, activation));
        }
        (is_plain && is_f32 && channels_in <= MAX_NCHW_CHANNELS && matches!(shape.stride, 1 | 2))
            .then(|| Self::Conv(Conv::new(shape, &conv.weight, &conv.bias, level), activation))
    }

    /// Name of the algorithm.
    pub(crate) fn algorithm(&self) -> &'static str {
        match self {
            Self::Conv(..) => "direct",
            Self::NchwConv(..) => "direct nchw",
            Self::Chain(_) => "fused",
            Self::Winograd(conv, _) => match conv.size() {
                TileSize::Two => "winograd 2",
                TileSize::Four => "winograd 4",
            },
            Self::LowPrecisionConv(_, LowPrecisionType::Bf16, _) => "direct bf16",
            Self::LowPrecisionConv(_, LowPrecisionType::Uint8(_), _) => "direct int8",
            Self::Depthwise(..) => "depthwise",
            Self::LowPrecisionDepthwise(_, LowPrecisionType::Bf16, _) => "depthwise bf16",
            Self::LowPrecisionDepthwise(_, LowPrecisionType::Uint8(_), _) => "depthwise int8",
            Self::MaxPool(_) | Self::LowPrecisionMaxPool(_) => "max-pool",
            Self::AvgPool => "mean",
            Self::Flatten => "flatten",
            Self::Add(_) | Self::LowPrecisionAdd(_) => "sum",
            Self::Channels(_) | Self::Interleave => "channels",
            Self::Upsample | Self::LowPrecisionUpsample => "upsample",
            Self::Sigmoid => "sigmoid",
            Self::Affine(_) => "affine",
        }
    }

    /// Whether it is a convolution.
    pub(crate) fn is_conv(&self) -> bool {
        matches!(
            self,
            Self::Conv(..)
                | Self::NchwConv(..)
                | Self::Winograd(..)
                | Self::Depthwise(..)
                | Self::LowPrecisionConv(..)
                | Self::LowPrecisionDepthwise(..)
        )
    }

    /// Whether it can write low precision.
    pub(crate) fn writes_low_precision(&self) -> bool {
        matches!(
            self,
            Self::NchwConv(..)
                | Self::LowPrecisionConv(..)
                | Self::LowPrecisionDepthwise(..)
                | Self::LowPrecisionAdd(_)
        )
    }

    /// Whether it can be a layer of a chain.
    pub(crate) fn is_link(&self) -> bool {
        matches!(self, Self::NchwConv(..) | Self::Conv(..) | Self::Depthwise(..) | Self::MaxPool(_))
    }

    /// The step as a layer of a chain, if it can be one.
    pub(crate) fn link(&self) -> Option<Link> {
        match self {
            Self::NchwConv(conv, activation) => Some(Link::Nchw(conv.clone(), *activation)),
            Self::Conv(conv, activation) => Some(Link::Conv(conv.clone(), *activation)),
            Self::Depthwise(conv, activation) => Some(Link::Depthwise(conv.clone(), *activation)),
            Self::MaxPool(pool) => Some(Link::MaxPool(*pool)),
            _ => None,
        }
    }

    /// Zero border that it needs around its input.
    pub(crate) fn border(&self) -> usize {
        match self {
            Self::Conv(conv, _) => conv.shape().padding(),
            Self::NchwConv(conv, _) => conv.shape().padding(),
            Self::Chain(chain) => chain.border(),
            Self::Winograd(..) => 1,
            Self::Depthwise(conv, _) => conv.shape().kernel / 2,
            Self::LowPrecisionConv(conv, ..) => conv.shape().padding(),
            Self::LowPrecisionDepthwise(conv, ..) => conv.shape().kernel / 2,
            _ => 0,
        }
    }

    /// Runs the step.
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
            Self::Conv(conv, activation) if matches!(inputs[0], Buffer::Nchw(_)) => {
                conv.run_nchw(thread_pool, inputs[0].nchw(), *activation, output.f32_mut());
            }
            Self::NchwConv(conv, activation) => {
                conv.run(thread_pool, inputs[0].nchw(), *activation, output.view_mut());
            }
            Self::LowPrecisionDepthwise(conv, _, activation) => {
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
            Self::Depthwise(conv, activation) => conv.run(thread_pool, input, *activation, output),
            Self::MaxPool(pool) => pool.run(thread_pool, level, input, output),
            Self::AvgPool => adaptive_avg_pool(thread_pool, level, input, output),
            Self::Flatten => flatten(input, output),
            Self::Add(activation) => add(thread_pool, level, input, other, *activation, output),
            Self::Channels(start) => gather_channels(output, |channel| (input, start + channel)),
            Self::Interleave => {
                let both = [input, inputs[1]];
                gather_channels(output, |channel| (both[channel % 2], channel / 2));
            }
            Self::Upsample => upsample(thread_pool, level, input, output),
            Self::Sigmoid => sigmoid(thread_pool, level, input, output),
            Self::Affine(affine_params) => {
                affine(thread_pool, level, input, *affine_params, output);
            }
            Self::Chain(_)
            | Self::NchwConv(..)
            | Self::LowPrecisionConv(..)
            | Self::LowPrecisionDepthwise(..)
            | Self::LowPrecisionMaxPool(_)
            | Self::LowPrecisionUpsample
            | Self::LowPrecisionAdd(_) => unreachable!("steps on other storage types"),
        }
    }
}

/// Tile size of the fastest Winograd algorithm for a convolution; none if direct convolution is
/// faster.
fn winograd_tile(shape: ConvShape, [_, height, width]: Shape) -> Option<TileSize> {
    let is_small = shape.channels_in.min(shape.channels_out) < MIN_CHANNELS;
    if shape.kernel != 3 || shape.stride != 1 || is_small {
        return None;
    }
    let tiles = |side: usize| height.div_ceil(side) * width.div_ceil(side);
    if tiles(4) >= MIN_TILES
        && (tiles(4) >= ENOUGH_TILES || shape.channels_in < TRANSFORM_BOUND_CHANNELS)
    {
        Some(TileSize::Four)
    } else {
        (tiles(2) >= MIN_TILES).then_some(TileSize::Two)
    }
}
