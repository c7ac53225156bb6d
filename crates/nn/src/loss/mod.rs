//! What networks are trained on.

mod body;
mod hand;

pub use body::{BodyLoss, BodyLossConfig, BodyLossParts, BodyTargets};
pub use hand::{HandLoss, HandLossConfig, HandLossParts};
