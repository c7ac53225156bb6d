//! What networks are trained on.

mod hand;

pub use hand::{HandLoss, HandLossConfig, HandLossParts};
