//! Images that surfaces and backgrounds are painted with: made up from a seed, or read from files.

pub mod background;
mod canvas;
mod html;
mod noise;
mod pool;
mod sample;
mod skin;
mod skins;

pub use html::HtmlSkins;
pub use pool::PicturePool;
pub use sample::Texture;
pub use skin::{SkinCoefficients, paint_skin};
pub use skins::Skins;
