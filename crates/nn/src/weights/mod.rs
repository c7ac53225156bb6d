//! Weight files: our own checkpoints, which describe their network, and PyTorch's.
//!
//! * [`save`], [`load`]: a `.bpk` file of a [`StoredNetwork`] with a card inside: [`ModelCard`] of
//!   hands, [`BodyCard`], [`BaselineCard`]; [`task_of`]: which of them a file is.
//! * [`with_digest`], [`read_checked`]: the SHA-256 that such a file ends with.
//! * [`average`]: the mean of two networks.
//! * [`load_pytorch`], [`load_move_enet`]: `.pth` and Lightning `.ckpt` files of the published
//!   networks.
//! * [`load_dhp19_cnn`], [`load_lift_mono`]: those of the networks that MoveEnet is compared with.
//!
//! Loading is strict: a parameter missing, left over or of another shape is an error that names it.

mod average;
mod checkpoint;
mod digest;
mod keras;
mod mapped;
mod model_card;
mod pytorch;
mod strict;

pub use average::average;
pub use checkpoint::{StoredNetwork, load, save, task_of};
pub use digest::{read_checked, with_digest};
pub use keras::load_dhp19_cnn;
pub use model_card::{BaselineCard, BodyCard, InputConfig, ModelCard};
pub use pytorch::{load_lift_mono, load_move_enet, load_pytorch};

pub use crate::error::Mismatch;
