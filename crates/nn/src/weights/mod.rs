//! Weight files: our own checkpoints, which describe their network, and PyTorch's.
//!
//! * [`save`], [`load`]: a `.bpk` file with a [`ModelCard`] inside; [`save_body`], [`load_body`]:
//!   the same of bodies; [`holds_body`]: whether a file is one of the latter.
//! * [`load_pytorch`], [`load_move_enet`]: `.pth` and Lightning `.ckpt` files of the published
//!   networks.
//! * [`save_safetensors`]: a MoveEnet under its names in PyTorch.
//!
//! Loading is strict: a parameter missing, left over or of another shape is an error that names it.

mod checkpoint;
mod model_card;
mod pytorch;
mod safetensors;
mod strict;

pub use checkpoint::{holds_body, load, load_body, save, save_body};
pub use model_card::{BodyCard, InputConfig, ModelCard};
pub use pytorch::{load_move_enet, load_pytorch};
pub use safetensors::save_safetensors;

pub use crate::error::Mismatch;
