//! The operators of a plan.
//!
//! * `build`: from the operations of a graph to operators with packed weights, and the choice of
//!   algorithms.
//! * `run`: execution on the buffers of a plan.

mod algorithm;
mod build;
mod run;

use evpose_kernels::blocked::{
    Chain, Conv, Depthwise, Link, LowPrecisionConv, LowPrecisionType, MaxPool, NchwConv,
    QuantizedDepthwise, TileSize, Winograd,
};
use evpose_nn::graph::Activation;

pub(crate) use run::StepContext;

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
    /// The channels of several inputs, one after the other.
    Concat,
    Upsample,
    Sigmoid,
    /// Scale and shift.
    Affine([f32; 2]),
    /// Several fused steps.
    Chain(Chain),
    LowPrecisionConv(LowPrecisionConv, LowPrecisionType, Activation),
    QuantizedDepthwise(QuantizedDepthwise, Activation),
    LowPrecisionMaxPool(MaxPool),
    LowPrecisionUpsample,
    /// Of two inputs of any storage types; of one input, a conversion.
    LowPrecisionAdd(Activation),
}

impl Step {
    /// Name of the algorithm.
    pub(crate) fn algorithm(&self) -> &'static str {
        match self {
            Self::Conv(..) => "direct",
            Self::NchwConv(..) => "direct nchw",
            Self::Chain(_) => "fused",
            Self::Winograd(conv, _) => match conv.size() {
                TileSize::Two => "winograd 2",
                TileSize::Four => "winograd 4",
                TileSize::TwoByFour => "winograd 2x4",
            },
            Self::LowPrecisionConv(conv, element_type, _) => {
                match (element_type, conv.uses_amx()) {
                    (LowPrecisionType::Bf16, false) => "direct bf16",
                    (LowPrecisionType::Uint8(_), false) => "direct int8",
                    (LowPrecisionType::Bf16, true) => "amx bf16",
                    (LowPrecisionType::Uint8(_), true) => "amx int8",
                }
            }
            Self::Depthwise(..) => "depthwise",
            Self::QuantizedDepthwise(..) => "depthwise int8",
            Self::MaxPool(_) | Self::LowPrecisionMaxPool(_) => "max-pool",
            Self::AvgPool => "mean",
            Self::Flatten => "flatten",
            Self::Add(_) | Self::LowPrecisionAdd(_) => "sum",
            Self::Channels(_) | Self::Interleave | Self::Concat => "channels",
            Self::Upsample | Self::LowPrecisionUpsample => "upsample",
            Self::Sigmoid => "sigmoid",
            Self::Affine(_) => "affine",
        }
    }

    /// Whether it multiplies on tiles of AMX.
    pub(crate) fn uses_amx(&self) -> bool {
        matches!(self, Self::LowPrecisionConv(conv, ..) if conv.uses_amx())
    }

    pub(crate) fn is_conv(&self) -> bool {
        matches!(
            self,
            Self::Conv(..)
                | Self::NchwConv(..)
                | Self::Winograd(..)
                | Self::Depthwise(..)
                | Self::LowPrecisionConv(..)
                | Self::QuantizedDepthwise(..)
        )
    }

    pub(crate) fn writes_low_precision(&self) -> bool {
        matches!(
            self,
            Self::NchwConv(..)
                | Self::Depthwise(..)
                | Self::LowPrecisionConv(..)
                | Self::QuantizedDepthwise(..)
                | Self::LowPrecisionAdd(_)
        )
    }

    /// Whether it can be a layer of a chain.
    pub(crate) fn is_link(&self) -> bool {
        match self {
            Self::Conv(conv, _) => conv.shape().square_side().is_some(),
            Self::NchwConv(..) | Self::Depthwise(..) | Self::MaxPool(_) => true,
            _ => false,
        }
    }

    /// The step as a layer of a chain, if it can be one.
    pub(crate) fn link(&self) -> Option<Link> {
        match self {
            Self::NchwConv(conv, activation) => Some(Link::Nchw(conv.clone(), *activation)),
            Self::Conv(conv, activation) if self.is_link() => {
                Some(Link::Conv(conv.clone(), *activation))
            }
            Self::Depthwise(conv, activation) => Some(Link::Depthwise(conv.clone(), *activation)),
            Self::MaxPool(pool) => Some(Link::MaxPool(*pool)),
            _ => None,
        }
    }

    /// Zero border that it needs around its input.
    pub(crate) fn border(&self) -> usize {
        match self {
            Self::Conv(conv, _) => conv.shape().border(),
            Self::NchwConv(conv, _) => conv.shape().border(),
            Self::Chain(chain) => chain.border(),
            // Winograd is chosen for 3x3 kernels alone.
            Self::Winograd(..) => 1,
            Self::Depthwise(conv, _) => conv.shape().kernel / 2,
            Self::LowPrecisionConv(conv, ..) => conv.shape().border(),
            Self::QuantizedDepthwise(conv, ..) => conv.shape().kernel / 2,
            _ => 0,
        }
    }
}
