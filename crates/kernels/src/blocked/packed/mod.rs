//! Inference on numbers of fewer bits: images and weights in 16 bits, or in 8.
//!
//! * [`Packed`]: such an image, `[channels / 16][height][width][16]` as [`Image`](super::Image).
//! * [`Held`], [`HeldMut`]: an image, however it is kept.
//! * [`PackedConv`], [`PackedDepthwise`]: convolution, whose sums are whole until all is added.
//! * [`max_pool_packed`], [`upsample_packed`]: images of another size, kept alike.
//! * [`add_held`]: sums, and images kept otherwise.
//! * [`read_planes`], [`write_planes`]: an image of what the world brings, and back.
//!
//! Fewer bytes come from memory, and processors with AVX512-VNNI or AVX512-BF16 multiply two or four
//! numbers where they multiply one `f32`.

mod conv;
mod depthwise;
mod held;
mod image;
mod reading;
mod resample;
mod sum;
mod weights;

pub use conv::PackedConv;
pub use depthwise::PackedDepthwise;
pub(super) use held::To;
pub use held::{Held, HeldMut};
pub use image::{Packed, Scale, Storage};
pub use reading::{read_planes, write_planes};
pub use resample::{max_pool_packed, upsample_packed};
pub use sum::add_held;

#[cfg(test)]
mod tests;
