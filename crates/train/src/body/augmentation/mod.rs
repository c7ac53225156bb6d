//! Images and labels as they are seen in training: each time a little differently.
//!
//! * [`BodyView`]: how one sample is seen once.

mod geometry;
mod label;
mod light;
mod rest;
mod view;

pub use view::BodyView;
pub(super) use view::draw;
