//! A deterministic single-threaded rasteriser: the nearest face of each pixel and the barycentric
//! coordinates on it.
//!
//! Two passes. [`Raster::draw`] finds for every pixel the nearest triangle, several pixels of a row
//! at a time; shading then touches each covered pixel once, and looks up where on the face it is
//! ([`Fragment`]). Only the rectangle around the mesh is cleared and visited, so that a frame costs
//! as much as the hand is large. Many sequences are simulated at once, one core each, so a frame is
//! single-threaded.
//!
//! # Model
//! Coordinates are snapped to 1/256 pixel and edge functions are exact integers; pixel centres lie
//! at half-integers, and a centre on an edge belongs to the triangle that has it as a top or left
//! edge. A pixel on an edge shared by two triangles is therefore drawn exactly once. Depth is
//! compared as 1/d, which is linear in the image.

mod camera;
mod clip;
mod covered;
mod fragment;
mod mesh;
mod narrow;
mod project;
mod rows;
mod triangle;
mod varying;
mod visibility;
mod visible;
mod wide;

pub use camera::Camera;
pub(crate) use covered::CoveredPixels;
pub use fragment::{Fragment, PixelRect};
pub use mesh::{Mesh, is_closed};
pub(crate) use triangle::unpack_xy_lanes;
pub(crate) use varying::Varyings;
pub use visible::Raster;

#[cfg(test)]
mod tests;
