//! The losses of the networks.

mod body;
mod hand;
mod heatmap;
mod joints;
mod marginal;

pub use body::{BodyLoss, BodyLossConfig, BodyLossParts, BodyTargets};
pub use hand::{HandLoss, HandLossConfig, HandLossParts};
pub use heatmap::{HeatmapTargets, heatmap_loss};
pub use joints::{JointLoss, JointLossConfig, JointLossParts, JointTargets};
pub use marginal::{MarginalLossParts, MarginalTargets, marginal_loss};
