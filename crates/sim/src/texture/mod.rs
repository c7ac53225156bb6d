//! Textures of surfaces and backgrounds: procedural, or read from files.

pub mod background;
mod canvas;
mod clothes;
mod covering;
mod html;
mod image_pool;
mod mipmap;
mod noise;
mod sample;
mod skin;
mod skins;

pub use clothes::paint_clothes;
pub use html::HtmlSkins;
pub use image_pool::ImagePool;
pub(crate) use mipmap::metres_per_texture;
pub use sample::Texture;
pub use skin::{SkinCoefficients, paint_skin};
pub use skins::Skins;
