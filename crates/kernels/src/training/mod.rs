//! Training on batches of images in blocks of sixteen channels, `[batch][channels / 16][height][width][16]`.
//!
//! * [`Blocks`]: the shape of such a batch, and the way to rows of planes and back.
//! * [`Conv`]: convolution, its gradients by input, weight and bias.
//! * [`Norm`]: batch normalisation. Who takes its result computes it again from its input, so that only
//!   one of both is kept: see [`Input`].
//! * [`MaxPool`]: 3x3 max-pooling of stride 2, of a normalised input.
//!
//! Every output is computed by one thread in an order that depends on shapes alone, so that results are
//! the same bits on any number of threads. Channels that fill the last block up are zero.

#![allow(unsafe_code, reason = "kernels take pointers; contracts are written at each function")]
#![allow(
    clippy::needless_range_loop,
    reason = "lanes of several arrays at once; columns become rows"
)]

mod blocks;
mod conv;
mod direct;
mod few;
mod gather;
mod norm;
mod outer;
mod padded;
mod pool;
mod weights;
mod winograd;
mod winograd_weight;

pub use blocks::Blocks;
pub use conv::Conv;
pub use norm::{Gradients, Input, Norm, through};
pub use pool::MaxPool;

#[cfg(test)]
mod tests;
