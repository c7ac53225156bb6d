//! Networks, losses and weight files.
//!
//! * [`DeviceKind`]: what the arithmetic runs on, chosen by name at run time.
//! * [`HandRegressorConfig`], [`HandRegressor`]: the EventHands network, events to 12 hand parameters.
//! * [`BACKBONES`], [`backbone_by_name`]: the image networks inside it; [`backbone`]: how to write one.
//! * [`MoveEnetConfig`], [`MoveEnet`]: the MoveEnet network, events to the maps of a body's joints.
//! * [`Network`]: any of them by name.
//! * [`Graph`](graph::Graph): such a network written down, for engines that compile it.
//! * [`HandLoss`], [`BodyLoss`]: what they are trained on.
//! * [`set_training_kernels`]: the arithmetic of training on the CPU, ours or Burn's.
//! * [`weights`]: our checkpoints and PyTorch's.
//!
//! Two rules hold everywhere. Initial weights depend on a seed and on each parameter's name, never
//! on threads or on the order of construction. And the weights of a network are addressed by path
//! ([`parameters`]), so that a file with one parameter too few or too many is an error.

pub mod backbone;
mod channels;
mod conv_norm;
mod device;
mod error;
pub mod graph;
mod hand_regressor;
mod initializer;
mod linear;
mod loss;
mod move_enet;
mod net_ops;
mod network;
mod ops;
pub mod parameters;
pub mod weights;

pub use backbone::{BACKBONES, BackboneEntry, backbone_by_name};
pub use device::DeviceKind;
pub use error::NnError;
pub use hand_regressor::{HandRegressor, HandRegressorConfig};
pub use loss::{
    BodyLoss, BodyLossConfig, BodyLossParts, BodyTargets, HandLoss, HandLossConfig, HandLossParts,
};
pub use move_enet::{MoveEnet, MoveEnetConfig};
pub use network::{MOVE_ENET, Network};
pub use ops::set_training_kernels;
