//! The operations of a plan.

use evpose_kernels::Level;
use evpose_kernels::blocked::{
    Chain, Conv, ConvShape, Depthwise, DepthwiseShape, Image, Link, MaxPool, PackedConv,
    PackedDepthwise, PlaneConv, Scratch, Source, Storage, ThreadPool, TileSize, Winograd, add,
    add_held, affine, flatten, gather, max_pool_packed, mean_pool, sigmoid, upsample,
    upsample_packed,
};
use evpose_nn::graph::{Activation, ConvLayer, LinearLayer, Node, Operation};

use crate::InferError;
use crate::held::{Buffer, Kept};
use crate::shapes::Shape;

/// Channels from which kernels take longer to transform to `F(4, 3)` than that saves, with few
/// tiles.
const MANY: usize = 512;
/// Tiles of `F(4, 3)` from which it is worth it for any channels.
const ENOUGH: usize = 12;
/// Tiles of an image below which one scheme is not worth its transforms.
const TILES: usize = 6;
/// Channels of an image that are taken in planes: in blocks it would be four times as large, or
/// more.
const PLANES: usize = 4;
/// Channels below which a convolution has too few products to save.
const CHANNELS: usize = 16;

/// An operation with its weights laid out.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    Conv(Conv, Activation),
    /// Of the image that the network is shown, in planes.
    PlaneConv(PlaneConv, Activation),
    Winograd(Winograd, Activation),
    Depthwise(Depthwise, Activation),
    MaxPool(MaxPool),
    MeanPool,
    Flatten,
    Sum(Activation),
    /// Channels of the output are those of the input from here on.
    Channels(usize),
    Interleave,
    Upsample,
    Sigmoid,
    /// Factor and offset.
    Affine([f32; 2]),
    /// Several of these together.
    Chain(Chain),
    PackedConv(PackedConv, Storage, Activation),
    PackedDepthwise(PackedDepthwise, Storage, Activation),
    PackedMaxPool(MaxPool),
    PackedUpsample,
    /// Of one image too, which is then kept otherwise.
    PackedSum(Activation),
}

/// What a step works with.
pub(crate) struct Place<'a> {
    pub(crate) thread_pool: &'a ThreadPool,
    pub(crate) level: Level,
    pub(crate) inputs: &'a [&'a Buffer],
    pub(crate) output: &'a mut Buffer,
    pub(crate) scratch: &'a mut Scratch,
}

impl Step {
    /// The operation of a node that is done as it stands.
    ///
    /// # Errors
    /// If there is no kernel for it.
    pub(crate) fn of(node: &Node, level: Level) -> Result<Self, InferError> {
        let missing = |what: &str| {
            Err(InferError::Unsupported { layer: node.name.clone(), what: what.to_owned() })
        };
        match &node.operation {
            Operation::MaxPool { window, stride, padding } => {
                let is_square = [window, stride, padding].iter().all(|side| side[0] == side[1]);
                if !is_square {
                    return missing("max-pool whose windows are not square");
                }
                let [window, stride, padding] = [window[0], stride[0], padding[0]];
                Ok(Self::MaxPool(MaxPool { window, stride, padding }))
            }
            Operation::MeanPool { .. } => Ok(Self::MeanPool),
            Operation::Flatten => Ok(Self::Flatten),
            Operation::Linear(linear) => Ok(Self::linear(linear, level)),
            Operation::Relu => Ok(Self::Sum(Activation::Relu)),
            Operation::Channels(range) => Ok(Self::Channels(range.start)),
            Operation::Interleave => Ok(Self::Interleave),
            Operation::Upsample => Ok(Self::Upsample),
            Operation::Sigmoid => Ok(Self::Sigmoid),
            Operation::Affine { factor, offset } => Ok(Self::Affine([*factor, *offset])),
            other => missing(&format!("operation {other:?}")),
        }
    }

    /// A fully connected layer is a convolution of a single pixel.
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

    /// A convolution and what follows it, of an image that is kept so.
    ///
    /// # Errors
    /// If there is no kernel for it.
    pub(crate) fn conv(
        name: &str,
        conv: &ConvLayer,
        output: Shape,
        has_residual: bool,
        activation: Activation,
        level: Level,
        kept: Kept,
    ) -> Result<Self, InferError> {
        let missing = |what: String| Err(InferError::Unsupported { layer: name.to_owned(), what });
        let [channels_out, of_group, kernel, kernel_x] = conv.shape;
        let [stride, stride_x] = conv.stride;
        if kernel != kernel_x || stride != stride_x || conv.dilation != [1, 1] {
            return missing(
                "convolution that is not square, or with gaps between its taps".to_owned(),
            );
        }
        if kernel % 2 == 0 || !matches!(stride, 1 | 2) || conv.padding != [kernel / 2; 4] {
            return missing(format!(
                "convolution of {kernel}x{kernel}, stride {stride} and padding {:?}",
                conv.padding
            ));
        }
        if conv.groups == 1 {
            let shape = ConvShape { channels_in: of_group, channels_out, kernel, stride };
            if let Some(storage) = kept {
                let conv = PackedConv::new(shape, &conv.weight, &conv.bias, storage, level);
                return Ok(Self::PackedConv(conv, storage, activation));
            }
            return Ok(match tiles_of(shape, output) {
                None => Self::Conv(Conv::new(shape, &conv.weight, &conv.bias, level), activation),
                Some(size) => {
                    let channels = [of_group, channels_out];
                    let conv = Winograd::new(channels, &conv.weight, &conv.bias, size, level);
                    Self::Winograd(conv, activation)
                }
            });
        }
        if conv.groups != channels_out || of_group != 1 || !matches!(kernel, 3 | 5) || has_residual
        {
            return missing(format!("convolution of {kernel}x{kernel} in {} groups", conv.groups));
        }
        let shape = DepthwiseShape { channels: channels_out, kernel, stride };
        if let Some(storage) = kept {
            let conv = PackedDepthwise::new(shape, &conv.weight, &conv.bias, storage, level);
            return Ok(Self::PackedDepthwise(conv, storage, activation));
        }
        let conv = Depthwise::new(shape, &conv.weight, &conv.bias, level);
        Ok(Self::Depthwise(conv, activation))
    }

    /// A convolution of the image that the network is shown, if that can be done in planes. Whether
    /// it is kept in 32 bits tells whether others could be.
    pub(crate) fn of_planes(
        conv: &ConvLayer,
        activation: Activation,
        level: Level,
        is_whole: bool,
    ) -> Option<Self> {
        let [channels_out, channels_in, kernel, kernel_x] = conv.shape;
        let shape = ConvShape { channels_in, channels_out, kernel, stride: conv.stride[0] };
        let is_plain = kernel == kernel_x
            && conv.stride[0] == conv.stride[1]
            && conv.groups == 1
            && conv.dilation == [1, 1]
            && conv.padding == [kernel / 2; 4];
        if is_plain && PlaneConv::can(shape) {
            let conv = PlaneConv::new(shape, &conv.weight, &conv.bias, level);
            return Some(Self::PlaneConv(conv, activation));
        }
        (is_plain && is_whole && channels_in <= PLANES && matches!(shape.stride, 1 | 2))
            .then(|| Self::Conv(Conv::new(shape, &conv.weight, &conv.bias, level), activation))
    }

    /// What it is, in a word.
    pub(crate) fn algorithm(&self) -> &'static str {
        match self {
            Self::Conv(..) => "direct",
            Self::PlaneConv(..) => "planes",
            Self::Chain(_) => "together",
            Self::Winograd(conv, _) => match conv.size() {
                TileSize::Two => "winograd 2",
                TileSize::Four => "winograd 4",
            },
            Self::PackedConv(_, Storage::Bf16, _) => "direct bf16",
            Self::PackedConv(_, Storage::Byte(_), _) => "direct int8",
            Self::Depthwise(..) => "depthwise",
            Self::PackedDepthwise(_, Storage::Bf16, _) => "depthwise bf16",
            Self::PackedDepthwise(_, Storage::Byte(_), _) => "depthwise int8",
            Self::MaxPool(_) | Self::PackedMaxPool(_) => "max-pool",
            Self::MeanPool => "mean",
            Self::Flatten => "flatten",
            Self::Sum(_) | Self::PackedSum(_) => "sum",
            Self::Channels(_) | Self::Interleave => "channels",
            Self::Upsample | Self::PackedUpsample => "upsample",
            Self::Sigmoid => "sigmoid",
            Self::Affine(_) => "affine",
        }
    }

    /// Whether it is a convolution.
    pub(crate) fn is_conv(&self) -> bool {
        matches!(
            self,
            Self::Conv(..)
                | Self::PlaneConv(..)
                | Self::Winograd(..)
                | Self::Depthwise(..)
                | Self::PackedConv(..)
                | Self::PackedDepthwise(..)
        )
    }

    /// Whether it can keep its output in fewer bits.
    pub(crate) fn writes_packed(&self) -> bool {
        matches!(
            self,
            Self::PlaneConv(..)
                | Self::PackedConv(..)
                | Self::PackedDepthwise(..)
                | Self::PackedSum(_)
        )
    }

    /// Whether it can be a link of a chain.
    pub(crate) fn is_link(&self) -> bool {
        matches!(
            self,
            Self::PlaneConv(..) | Self::Conv(..) | Self::Depthwise(..) | Self::MaxPool(_)
        )
    }

    /// The same as a link of a chain, if it can be one.
    pub(crate) fn link(&self) -> Option<Link> {
        match self {
            Self::PlaneConv(conv, activation) => Some(Link::Planes(conv.clone(), *activation)),
            Self::Conv(conv, activation) => Some(Link::Conv(conv.clone(), *activation)),
            Self::Depthwise(conv, activation) => Some(Link::Depthwise(conv.clone(), *activation)),
            Self::MaxPool(pool) => Some(Link::MaxPool(*pool)),
            _ => None,
        }
    }

    /// Pixels of zeros that it needs around its input.
    pub(crate) fn border(&self) -> usize {
        match self {
            Self::Conv(conv, _) => conv.shape().padding(),
            Self::PlaneConv(conv, _) => conv.shape().padding(),
            Self::Chain(chain) => chain.border(),
            Self::Winograd(..) => 1,
            Self::Depthwise(conv, _) => conv.shape().kernel / 2,
            Self::PackedConv(conv, ..) => conv.shape().padding(),
            Self::PackedDepthwise(conv, ..) => conv.shape().kernel / 2,
            _ => 0,
        }
    }

    /// Does it.
    pub(crate) fn run(&self, place: Place<'_>) {
        let Place { thread_pool, level, inputs, output, scratch } = place;
        let other = inputs.get(1).copied();
        match self {
            Self::PackedConv(conv, _, activation) => {
                let residual = other.map(Buffer::held);
                conv.run(thread_pool, inputs[0].packed(), residual, *activation, output.held_mut());
            }
            Self::Chain(chain) => {
                let source = match inputs[0] {
                    Buffer::Planes(planes) => Source::Planes(planes),
                    image => Source::Image(image.whole()),
                };
                let residual = other.map(Buffer::whole);
                chain.run(thread_pool, source, residual, output.whole_mut(), scratch);
            }
            Self::Conv(conv, activation) if matches!(inputs[0], Buffer::Planes(_)) => {
                conv.run_planes(thread_pool, inputs[0].planes(), *activation, output.whole_mut());
            }
            Self::PlaneConv(conv, activation) => {
                conv.run(thread_pool, inputs[0].planes(), *activation, output.held_mut());
            }
            Self::PackedDepthwise(conv, _, activation) => {
                conv.run(thread_pool, inputs[0].packed(), *activation, output.held_mut());
            }
            Self::PackedMaxPool(pool) => {
                max_pool_packed(thread_pool, level, *pool, inputs[0].packed(), output.packed_mut());
            }
            Self::PackedUpsample => {
                upsample_packed(thread_pool, level, inputs[0].packed(), output.packed_mut());
            }
            Self::PackedSum(activation) => {
                let (one, other) = (inputs[0].held(), other.map(Buffer::held));
                add_held(thread_pool, level, one, other, *activation, output.held_mut());
            }
            _ => {
                let inputs: Vec<&Image> = inputs.iter().map(|input| input.whole()).collect();
                self.run_whole(thread_pool, level, &inputs, output.whole_mut(), scratch);
            }
        }
    }

    /// Does it, where images are kept in 32 bits.
    fn run_whole(
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
                conv.run(thread_pool, input, other, *activation, output)
            }
            Self::Winograd(conv, activation) => {
                conv.run(thread_pool, input, other, *activation, output, scratch);
            }
            Self::Depthwise(conv, activation) => conv.run(thread_pool, input, *activation, output),
            Self::MaxPool(pool) => pool.run(thread_pool, level, input, output),
            Self::MeanPool => mean_pool(thread_pool, level, input, output),
            Self::Flatten => flatten(input, output),
            Self::Sum(activation) => add(thread_pool, level, input, other, *activation, output),
            Self::Channels(start) => gather(output, |channel| (input, start + channel)),
            Self::Interleave => {
                let both = [input, inputs[1]];
                gather(output, |channel| (both[channel % 2], channel / 2));
            }
            Self::Upsample => upsample(thread_pool, level, input, output),
            Self::Sigmoid => sigmoid(thread_pool, level, input, output),
            Self::Affine(by) => affine(thread_pool, level, input, *by, output),
            Self::Chain(_)
            | Self::PlaneConv(..)
            | Self::PackedConv(..)
            | Self::PackedDepthwise(..)
            | Self::PackedMaxPool(_)
            | Self::PackedUpsample
            | Self::PackedSum(_) => unreachable!("steps on images that are kept otherwise"),
        }
    }
}

/// The tiles by which a convolution is the fastest; none for the direct way.
fn tiles_of(shape: ConvShape, [_, height, width]: Shape) -> Option<TileSize> {
    let is_small = shape.channels_in.min(shape.channels_out) < CHANNELS;
    if shape.kernel != 3 || shape.stride != 1 || is_small {
        return None;
    }
    let tiles = |side: usize| height.div_ceil(side) * width.div_ceil(side);
    if tiles(4) >= TILES && (tiles(4) >= ENOUGH || shape.channels_in < MANY) {
        Some(TileSize::Four)
    } else {
        (tiles(2) >= TILES).then_some(TileSize::Two)
    }
}
