//! Scenes, tile rasteriser, randomisation and labelled recordings.

pub mod raster;
pub mod scene;
pub mod texture;

#[cfg(test)]
mod shapes;
