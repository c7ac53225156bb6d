//! Commands where they are about bodies.

mod checkpoint;
mod eval;
mod infer;
mod pictures;
mod simulate;
mod source;
mod train;

pub(crate) use checkpoint::checkpoint;
pub(crate) use eval::run as eval;
pub(crate) use infer::run as infer;
pub(crate) use simulate::run as simulate;
pub(crate) use source::config;
pub(crate) use train::{frames, prepare, run as train};
