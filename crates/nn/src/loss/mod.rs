//! The losses of the two networks.

mod body;
mod hand;

pub use body::{BodyLoss, BodyLossConfig, BodyLossParts, BodyTargets};
pub use hand::{HandLoss, HandLossConfig, HandLossParts};
