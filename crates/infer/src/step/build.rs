//! Operators from the operations of a graph, with the fastest algorithm for their shape.

use evpose_kernels::Level;
use evpose_kernels::blocked::{
    Conv, ConvShape, Depthwise, DepthwiseShape, LowPrecisionConv, LowPrecisionType, MaxPool,
    NchwConv, QuantizedDepthwise, Winograd,
};
use evpose_nn::graph::{Activation, ConvLayer, LinearLayer, Node, Operation};

use super::Step;
use super::algorithm::winograd_tile;
use crate::InferError;
use crate::buffer::StorageType;
use crate::shapes::Shape;

/// Largest number of channels of an input in nchw: in nChw16c it would be at least four times as
/// large.
const MAX_NCHW_CHANNELS: usize = 4;
impl Step {
    /// Step of a node without fusion.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] if there is no kernel for it.
    pub(crate) fn from_node(node: &Node, level: Level) -> Result<Self, InferError> {
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
            Operation::Concat => Ok(Self::Concat),
            Operation::Upsample => Ok(Self::Upsample),
            Operation::Sigmoid => Ok(Self::Sigmoid),
            Operation::Affine { factor, offset } => Ok(Self::Affine([*factor, *offset])),
            other => unsupported(&format!("operation {other:?}")),
        }
    }

    /// A fully connected layer, as a 1x1 convolution of a single pixel.
    fn linear(linear: &LinearLayer, level: Level) -> Self {
        let [inputs, outputs] = linear.shape;
        let shape = ConvShape::square(inputs, outputs, 1, 1);
        // The layer stores a row for each input, the kernels read one for each output.
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
        let [top, left, bottom, right] = conv.padding;
        if conv.dilation != [1, 1] {
            return unsupported("convolution with gaps between its taps".to_owned());
        }
        if stride != stride_x || !matches!(stride, 1 | 2) {
            return unsupported(format!("convolution of stride {:?}", conv.stride));
        }
        if [top, left] != [bottom, right] {
            return unsupported(format!("convolution of padding {:?}", conv.padding));
        }
        if conv.groups == 1 {
            let shape = ConvShape {
                channels_in: channels_per_group,
                channels_out,
                kernel: [kernel, kernel_x],
                stride,
                padding: [top, left],
            };
            // Without Winograd, whose transforms need more bits.
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
        // Depthwise kernels exist for these sides alone, and do not add a residual.
        if conv.groups != channels_out
            || channels_per_group != 1
            || !matches!(kernel, 3 | 5)
            || kernel != kernel_x
            || conv.padding != [kernel / 2; 4]
            || has_residual
        {
            return unsupported(format!(
                "convolution of {kernel}x{kernel} in {} groups",
                conv.groups
            ));
        }
        let shape = DepthwiseShape { channels: channels_out, kernel, stride };
        if let StorageType::LowPrecision(LowPrecisionType::Uint8(params)) = storage {
            let conv = QuantizedDepthwise::new(shape, &conv.weight, &conv.bias, params, level);
            return Ok(Self::QuantizedDepthwise(conv, activation));
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
        let shape = ConvShape::square(channels_in, channels_out, kernel, conv.stride[0]);
        // Kernels that read nchw pad by half a kernel and know neither groups nor dilation.
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
}
