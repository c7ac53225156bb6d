//! Commands where they are about bodies.

mod simulate;
mod source;
mod train;

pub(crate) use simulate::run as simulate;
pub(crate) use source::{config, is_embedded};
pub(crate) use train::run as train;
