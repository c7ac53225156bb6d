//! Inference on numbers of fewer bits: images and weights in 16 bits, or in 8.
//!
//! * [`Packed`]: such an image, `[channels / 16][height][width][16]` as [`Image`](super::Image).
//! * [`PackedConv`]: convolution, whose sums are whole until all is added.
//!
//! Fewer bytes come from memory, and processors with AVX512-VNNI or AVX512-BF16 multiply two or four
//! numbers where they multiply one `f32`.

mod conv;
mod image;

pub use conv::PackedConv;
pub use image::{Packed, Scale, Storage};

#[cfg(test)]
mod tests;
