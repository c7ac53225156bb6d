//! Parametric body models: the procedural arm and hand, skinning, motion.

mod model;
mod normals;
mod pose;
mod posed;
mod procedural;
pub mod skeleton;
mod skinning;
pub mod texture_layout;

pub use model::{BodyModel, HandBasis, ShapedBody, SkinWeights};
pub use pose::{BodyPose, GENERATOR_NUMBERS};
pub use posed::PosedBody;
