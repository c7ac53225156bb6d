//! The unit of the processor that multiplies.

use crate::blocked::conv_shape::ConvShape;
#[cfg(target_arch = "x86_64")]
use crate::simd::LANES;
use crate::simd::tiles::TileElement;
use crate::simd::{Level, ReducedDispatch};

/// The unit that a convolution's products are computed by. Weights are packed for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::blocked::low_precision) enum Arithmetic {
    /// Dot products of vector registers.
    Vectors,
    /// Products of tiles, on AMX.
    #[cfg(target_arch = "x86_64")]
    Amx,
    /// The same on an emulation of AMX.
    #[cfg(test)]
    EmulatedAmx,
}

impl Arithmetic {
    /// AMX where the processor has it for elements of type `S`, and a block of input channels is
    /// full: of fewer channels, tiles would mostly multiply zeros.
    pub(super) fn for_shape<S: TileElement>(shape: ConvShape, level: Level) -> Self {
        #[cfg(target_arch = "x86_64")]
        if shape.channels_in >= LANES && S::has_amx(level) {
            return Self::Amx;
        }
        Self::Vectors
    }

    /// Input channels of a dot product of elements of type `S`.
    pub(super) fn depth<S: ReducedDispatch + TileElement>(self, level: Level) -> usize {
        if self == Self::Vectors { S::dot_depth(level) } else { S::DEPTH }
    }
}
