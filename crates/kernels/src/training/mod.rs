//! Training on batches of images in the layout nChw16c,
//! `[batch][channels / 16][height][width][16]`.
//!
//! * [`Blocks`]: the shape of such a batch, and the way to rows of planes and back.
//! * [`Conv`]: convolution, its gradients by input, weight and bias.
//! * [`Depthwise`]: the same with a kernel for each channel.
//! * [`Norm`]: batch normalisation. Its consumers compute it again from its input while they read,
//!   so that only the input is stored: see [`NormalizedInput`].
//! * [`MaxPool`], [`Upsample`]: max-pooling of stride 2 and bilinear upsampling by two.
//!
//! Every output is computed by one thread in an order that depends on shapes alone, so that results
//! are the same bits on any number of threads. Channels that pad the last block are zero.

#![allow(unsafe_code, reason = "kernels take pointers; the contract stands at each function")]
#![allow(
    clippy::needless_range_loop,
    reason = "lanes of several arrays at once; columns become rows"
)]

mod blocks;
mod conv;
mod depthwise;
mod direct;
mod direct_weight;
mod few_channels;
mod gather;
mod norm;
mod outer;
mod padded;
mod per_channel;
mod phases;
mod pool;
mod shape;
mod upsample;
mod weights;
mod winograd;
mod winograd_weight;

pub use crate::activation::Activation;
pub use blocks::Blocks;
pub use conv::backward_bias;
pub use depthwise::Depthwise;
pub use norm::{Gradients, Norm, NormalizedInput, Statistics, activation_backward};
pub use pool::MaxPool;
pub use shape::Conv;
pub use upsample::Upsample;

#[cfg(test)]
mod tests;
