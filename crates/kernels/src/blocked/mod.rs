//! Inference, one image at a time: images in blocks of sixteen channels, which are a register of
//! AVX-512.
//!
//! * [`Image`]: such an image, with a border of zeros.
//! * [`Conv`]: convolution with bias, residual and activation in one pass.
//! * [`Winograd`]: the same of 3x3 kernels with fewer products.
//! * [`Depthwise`]: convolution of every channel by itself.
//! * [`PackedConv`], [`PackedDepthwise`]: convolution of images of fewer bits, [`Packed`].
//! * [`add_held`], [`max_pool_packed`], [`upsample_packed`]: what else is done to them.
//! * [`Chain`]: layers done together, some rows at a time.
//! * [`PlaneConv`]: convolution of a few channels that are not in blocks, [`Planes`].
//! * [`MaxPool`], [`mean_pool`]: maxima and means of windows.
//! * [`add`], [`gather`], [`flatten`]: sums, and values put elsewhere.
//! * [`upsample`]: twice as many rows and columns.
//! * [`affine`], [`sigmoid`]: functions of every value by itself.
//! * [`ThreadPool`]: threads that share the work.
//! * [`peak_gflop_per_s`]: what the processor can do at best.
//!
//! Every operation is compiled for every [`Level`](crate::Level) and gives the same up to rounding.

#![allow(unsafe_code, reason = "kernels take pointers; contracts are written at each function")]

mod chain;
mod conv;
mod depthwise;
mod elementwise;
mod image;
mod packed;
mod packing;
mod peak;
mod planes;
mod pool;
mod scheme;
mod thread_pool;
mod tile;
mod upsample;
mod values;
mod winograd;

pub(crate) use image::Line;
pub(crate) use packing::{blocks_of, groups};
pub(crate) use scheme::{Four, MOST, Scheme};

pub use chain::{Chain, Link, Source};
pub use conv::{Conv, ConvShape};
pub use depthwise::{Depthwise, DepthwiseShape};
pub use elementwise::{add, flatten, gather};
pub use image::Image;
pub use packed::{
    Held, HeldMut, Packed, PackedConv, PackedDepthwise, Scale, Storage, add_held, max_pool_packed,
    read_planes, upsample_packed, write_planes,
};
pub use peak::peak_gflop_per_s;
pub use planes::{PlaneConv, Planes};
pub use pool::{MaxPool, mean_pool};
pub use thread_pool::{Part, ThreadPool};
pub use tile::Activation;
pub use upsample::upsample;
pub use values::{affine, sigmoid};
pub use winograd::{Scratch, TileSize, Winograd};

#[cfg(test)]
mod tests;
