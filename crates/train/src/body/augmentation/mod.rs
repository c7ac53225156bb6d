//! Images and labels as they are seen in training: each time a little differently.
//!
//! * [`BodyAugmentation`]: what varies.
//! * [`BodyView`]: how one sample is seen once.
//! * [`Interpolation`], [`resize_grey`]: how images are sampled.

mod config;
mod geometry;
mod label;
mod light;
mod resample;
mod view;

pub use config::BodyAugmentation;
pub use resample::{Interpolation, resize_grey};
pub use view::BodyView;
