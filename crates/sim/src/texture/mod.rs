//! Images that surfaces and backgrounds are painted with: sampled, made up from a seed, or read
//! from a folder.

mod noise;
mod sample;

pub use sample::Texture;
