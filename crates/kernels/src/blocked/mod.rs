//! Inference kernels for one image at a time, in the blocked layout nChw16c.
//!
//! The layout is oneDNN's: channels are grouped in blocks of 16, which are one AVX-512 register and
//! one cache line. Kernels fuse bias, residual sum and activation into the pass that computes a
//! layer.
//!
//! * [`Image`]: an f32 image in nChw16c with a zero border; [`NchwImage`]: the same in plain nchw.
//! * [`Conv`]: direct convolution; [`Winograd`]: 3x3 convolution with fewer multiplications;
//!   [`Depthwise`]: depthwise convolution; [`NchwConv`]: convolution of a few channels in nchw.
//! * [`Chain`]: consecutive layers fused, computed a band of rows at a time.
//! * [`MaxPool`], [`adaptive_avg_pool`], [`upsample`]: pooling and bilinear upsampling.
//! * [`add`], [`affine`], [`sigmoid`]: elementwise operators; [`gather_channels`], [`flatten`]:
//!   data movement.
//! * [`LowPrecisionImage`], [`LowPrecisionConv`], [`QuantizedDepthwise`]: images and
//!   convolutions in bf16 and quantised uint8; [`add_mixed_precision`], [`max_pool_low_precision`],
//!   [`upsample_low_precision`]: the other operators on them.
//! * [`reorder_from_nchw`], [`reorder_to_nchw`]: layout conversions.
//! * [`ThreadPool`]: threads for parallel regions of tens of microseconds.
//! * [`peak_gflop_per_s`]: the processor's peak, against which kernels are measured.
//!
//! Every operator is compiled once per [`Level`](crate::Level). Levels differ in rounding only.

#![allow(unsafe_code, reason = "kernels take pointers; contracts are written at each function")]

mod blocks;
mod chain;
mod conv;
mod conv_shape;
mod depthwise;
mod elementwise;
mod image;
mod lines;
mod low_precision;
mod nchw;
mod nchw_conv;
mod pack;
mod peak;
mod pool;
mod tile;
mod unary;
mod upsample;
mod views;
mod winograd;

pub(crate) use blocks::{block_groups, pad_to_blocks};
pub(crate) use image::Line;
pub(crate) use winograd::{F4x3, MAX_INPUTS, WinogradTransform};

pub use chain::{Chain, ChainInput, Link};
pub use conv::Conv;
pub use conv_shape::ConvShape;
pub use depthwise::{Depthwise, DepthwiseShape};
pub use elementwise::{add, concat, flatten, gather_channels};
pub use evpose_cpu::{Part, ThreadPool};
pub use image::Image;
pub use low_precision::{
    LowPrecisionConv, LowPrecisionImage, LowPrecisionType, QuantizationParams, QuantizedDepthwise,
    TensorView, TensorViewMut, add_mixed_precision, max_pool_low_precision, reorder_from_nchw,
    reorder_to_nchw, upsample_low_precision,
};
pub use nchw::NchwImage;
pub use nchw_conv::NchwConv;
pub use peak::peak_gflop_per_s;
pub use pool::{MaxPool, adaptive_avg_pool};
pub use tile::Activation;
pub use unary::{affine, sigmoid};
pub use upsample::upsample;
pub use winograd::{Scratch, TileSize, Winograd};

#[cfg(test)]
pub(crate) mod tests;
