//! Rendered scenes: lights, backdrop, shading and the response of the frame buffer.

mod backdrop;
mod lighting;
mod renderer;
mod response;
mod shader;

pub use backdrop::{Backdrop, BackdropPlacement};
pub use lighting::{DirectionalLight, Lighting};
pub use renderer::{Renderer, Scene};
pub use response::{FrameResponse, luminance};
