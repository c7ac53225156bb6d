//! Inference at reduced precision: images and weights in bf16 or quantised to 8 bits.
//!
//! * [`LowPrecisionImage`]: an image in nChw16c as [`Image`](super::Image), of bf16 or uint8.
//! * [`TensorView`], [`TensorViewMut`]: references to an image of any element type.
//! * [`LowPrecisionConv`], [`QuantizedDepthwise`]: convolutions, accumulated in f32 or int32.
//! * [`max_pool_low_precision`], [`upsample_low_precision`]: resampling within one element type.
//! * [`add_mixed_precision`]: sums of, and conversions between, any element types.
//! * [`reorder_from_nchw`], [`reorder_to_nchw`]: layout conversions from and to nchw.
//!
//! Less memory is read, and processors with AVX512-VNNI or AVX512-BF16 multiply four or two values
//! where they multiply one `f32`. Those with AMX multiply tiles of 16 pixels by 16 output channels.

mod add;
mod conv;
mod depthwise;
mod image;
mod quantized_weights;
mod reorder;
mod resample;
mod view;

pub use add::add_mixed_precision;
pub use conv::LowPrecisionConv;
pub use depthwise::QuantizedDepthwise;
pub(super) use image::Bf16Dst;
pub use image::{LowPrecisionImage, LowPrecisionType, QuantizationParams};
pub use reorder::{reorder_from_nchw, reorder_to_nchw};
pub use resample::{max_pool_low_precision, upsample_low_precision};
pub(super) use view::DstView;
pub use view::{TensorView, TensorViewMut};

#[cfg(test)]
mod tests;
