//! Images that surfaces and backgrounds are painted with: made up from a seed, or read from files.

pub mod background;
mod canvas;
mod clothes;
mod html;
mod noise;
mod pool;
mod reduce;
mod sample;
mod skin;
mod skins;

pub use clothes::paint_clothes;
pub use html::HtmlSkins;
pub use pool::PicturePool;
pub(crate) use reduce::metres_per_texture;
pub use sample::Texture;
pub use skin::{SkinCoefficients, paint_skin};
pub use skins::Skins;
