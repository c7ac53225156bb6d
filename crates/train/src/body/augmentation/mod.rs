//! Images and labels as they are seen in training: each time a little differently.
//!
//! * [`BodyAugmentation`]: what varies.
//! * [`BodyView`]: how one sample is seen once.
//! * [`Interpolation`], [`resized`]: how images are sampled.

mod config;
mod geometry;
mod label;
mod light;
mod resample;
mod view;

pub use config::BodyAugmentation;
pub use resample::{Interpolation, resized};
pub use view::BodyView;
