//! The operations that training spends its time on, for the CPU, on plain slices.
//!
//! * [`conv2d`]: convolution, its gradients by input and by weight.
//! * [`depthwise`]: the same with a kernel for each channel.
//! * [`batch_norm`]: normalisation by the statistics of the batch, with or without a ReLU behind.
//! * [`max_pool`]: 3x3 max-pooling of stride 2.
//! * [`training`]: all of that for batches in blocks of channels, as deep networks without depthwise layers
//!   take it.
//! * [`matmul`](matmul()): the matrix product below them.
//!
//! Images are `f32`, row-major `[batch, channels, height, width]`. Work is cut into pieces that
//! depend on the shapes alone and partial sums are added in a fixed order, so that results are
//! equal to the bit whatever the number of threads. Shapes are the caller's responsibility: a
//! slice of the wrong length panics.

pub mod batch_norm;
pub mod blocked;
pub mod conv2d;
pub mod depthwise;
mod im2col;
mod lanes;
mod matmul;
pub mod max_pool;
mod memory;
mod simd;
pub mod training;

pub use matmul::{Matrix, matmul};
pub use memory::keep_freed_memory;
pub use simd::Level;
