//! Networks for hands and bodies, their losses, and weight files.
//!
//! * [`HandRegressorConfig`], [`HandRegressor`]: the EventHands network, events to 12 hand
//!   parameters.
//! * [`JointNetConfig`], [`JointNet`]: events to heatmaps and depths of the joints of a hand;
//!   [`HandNetwork`]: either of both.
//! * [`BACKBONES`], [`backbone_by_name`]: the image networks inside it; [`backbone`]: how to write
//!   one.
//! * [`MoveEnetConfig`], [`MoveEnet`]: the MoveEnet network, event images to the maps of a body's
//!   joints.
//! * [`Network`]: either of them by name.
//! * [`BaselineNetwork`]: the networks that MoveEnet is compared with, [`Dhp19Cnn`] and
//!   [`LiftMono`].
//! * [`Graph`](graph::Graph): the graph of a network, for engines that compile it.
//! * [`HandLoss`], [`BodyLoss`], [`JointLoss`], [`heatmap_loss`], [`marginal_loss`]: their losses.
//! * [`DeviceKind`]: the devices that networks are computed on, chosen by name at run time;
//!   [`Availability`]: those of this machine.
//! * [`set_training_kernels`]: training on the CPU with our kernels or with Burn's.
//! * [`weights`]: our checkpoints and PyTorch's.
//!
//! Initial weights depend on a seed and on each parameter's path, never on threads or on the order
//! of construction. Weights are addressed by path ([`parameters`]), so that a file with one
//! parameter too few or too many is an error.
//!
//! ```
//! use burn::tensor::{Device, Tensor};
//! use evpose_nn::HandRegressorConfig;
//!
//! # fn main() -> Result<(), evpose_nn::NnError> {
//! let config = HandRegressorConfig {
//!     backbone: "mobilenet_v2".to_owned(),
//!     width: 0.25,
//!     ..HandRegressorConfig::default()
//! };
//! let network = config.init(1, &Device::flex())?;
//! let events = Tensor::<4>::zeros([2, 2, 45, 60], &Device::flex());
//! assert_eq!(network.forward(events).dims(), [2, 12]);
//! assert_eq!(network.graph().nodes[0].channels, 2);
//! # Ok(())
//! # }
//! ```

mod adam;
pub mod backbone;
mod baseline;
mod channels;
mod conv_norm;
mod device;
mod dhp19_cnn;
mod error;
pub mod graph;
mod hand_head;
mod hand_network;
mod hand_output;
mod hand_regressor;
mod initializer;
mod joint_net;
mod joint_order;
mod lift_mono;
mod linear;
mod loss;
mod move_enet;
mod net_ops;
mod network;
mod ops;
pub mod parameters;
mod timed;
pub mod weights;

pub use adam::Adam;
pub use backbone::{BACKBONES, BackboneEntry, backbone_by_name};
pub use baseline::{BaselineNetwork, BaselineNetworkConfig};
pub use device::{Adapter, Availability, DeviceKind, adapter_name};
pub use dhp19_cnn::{Dhp19Cnn, Dhp19CnnConfig};
pub use error::NnError;
pub use hand_head::HandHead;
pub use hand_network::HandNetwork;
pub use hand_output::RotationOutput;
pub use hand_regressor::{HandRegressor, HandRegressorConfig};
pub use joint_net::{JointMaps, JointNet, JointNetConfig};
pub use lift_mono::{LiftMono, LiftMonoConfig, MarginalMaps};
pub use loss::{
    BodyLoss, BodyLossConfig, BodyLossParts, BodyTargets, HandLoss, HandLossConfig, HandLossParts,
    HeatmapTargets, JointLoss, JointLossConfig, JointLossParts, JointTargets, MarginalLossParts,
    MarginalTargets, heatmap_loss, marginal_loss,
};
pub use move_enet::{MoveEnet, MoveEnetConfig};
pub use network::{JOINT_NET, MOVE_ENET, Network};
pub use ops::set_training_kernels;
pub use timed::NodeTime;
