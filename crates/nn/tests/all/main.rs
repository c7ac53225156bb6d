//! Tests of the networks by their public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, reason = "tests")]

mod baselines;
#[cfg(feature = "ndarray")]
mod devices;
mod external;
#[path = "../golden/mod.rs"]
mod golden;
mod kernels;
mod move_enet;
mod pytorch;
mod training;
