//! Kernels, as CubeCL compiles them for any GPU. Channels are the last of four dimensions: neighbouring
//! threads read and write neighbours.
#![allow(clippy::needless_pass_by_value, reason = "kernels have no other way to take values")]
#![allow(clippy::too_many_arguments, reason = "as above")]
#![allow(missing_docs, reason = "the macro writes modules and functions without")]

pub(super) mod adam;
pub(super) mod columns;
pub(super) mod depthwise;
pub(super) mod norm;

use cubecl::prelude::*;

/// `sums[k]` is the sum of `partial[.., k]` over its first dimension.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn sum_pieces<E: Float>(
    partial: &Tensor<E>,
    sums: &mut Tensor<E>,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= sums.len() {
        terminate!();
    }
    let width = sums.len();
    let mut sum = E::from_int(0);
    for piece in 0..partial.shape(0) {
        sum += partial[piece * width + ABSOLUTE_POS];
    }
    sums[ABSOLUTE_POS] = sum;
}
