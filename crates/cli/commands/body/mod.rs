//! Commands where they are about bodies.

mod eval;
mod infer;

mod simulate;

mod train;

pub(crate) use eval::run as eval;
pub(crate) use infer::run as infer;
pub(crate) use simulate::run as simulate;
pub(crate) use train::run as train;
