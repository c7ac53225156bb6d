//! What stands before the camera: lights, background, and the response of the picture they make.

mod backdrop;
mod lighting;
mod renderer;
mod response;
mod shader;

pub use backdrop::{Backdrop, BackdropPlacement};
pub use lighting::{DirectionalLight, Lighting};
pub use renderer::{Renderer, Scene};
pub use response::{FrameResponse, luminance};
