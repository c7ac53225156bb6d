//! Inference, one image at a time: images in blocks of sixteen channels, which are a register of AVX-512.
//!
//! * [`Image`]: such an image, with a border of zeros.
//! * [`Conv`]: convolution with bias, residual and activation in one pass.
//! * [`Team`]: threads that share the work.
//!
//! Every operation is compiled for every [`Level`](crate::Level) and gives the same up to rounding.

#![allow(unsafe_code, reason = "kernels take pointers; contracts are written at each function")]

mod conv;
mod image;
mod team;
mod tile;

pub use conv::{Conv, ConvShape};
pub use image::Image;
pub use team::{Part, Team};
pub use tile::Activation;

#[cfg(test)]
mod tests;
