//! Convolution with one image in every lane of a vector.
//!
//! # Model
//! Images of a batch are taken as many at a time as a vector has lanes, and laid out pixel by pixel
//! with the images innermost. Every sum of the convolution is then a sum of vectors, whatever the
//! size of the image, and a tile of outputs stays in registers while the inputs go by. Nothing is
//! copied nine times, as for a matrix of patches: for layers of few channels that copying costs
//! several times the arithmetic.

mod backward;
mod forward;
mod layout;

pub(crate) use backward::{backward_input, backward_weight};
pub(crate) use forward::forward;

use pulp::{Arch, Simd, WithSimd};

use crate::conv2d::Conv2d;

/// Channels and pixels of a tile: their product is the number of registers that sums take.
const TILE: usize = 4;

/// Channels beyond which blocked matrix products win: there the weights of a tile no longer stay in
/// the nearest cache.
const CHANNELS: usize = 160;

/// Whether this is the way for a convolution on this processor. Where the patches of an image are the
/// image itself, a matrix product needs no other layout.
pub(crate) fn suits(conv: &Conv2d) -> bool {
    let lanes = lanes();
    !conv.is_pointwise()
        && lanes > 1
        && conv.batch >= lanes / 2
        && conv.channels_in.max(conv.channels_out) <= CHANNELS
}

/// Images side by side in a vector of this processor.
fn lanes() -> usize {
    struct Lanes;
    impl WithSimd for Lanes {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F32_LANES
        }
    }
    Arch::new().dispatch(Lanes)
}
