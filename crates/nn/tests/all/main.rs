//! Tests of the networks by their public interface: one program, so that it is linked once. What changes the kernels or the
//! registry of its process is a program of its own.

#![allow(clippy::unwrap_used, reason = "tests")]

mod baselines;
#[cfg(feature = "ndarray")]
mod devices;
#[path = "../golden/mod.rs"]
mod golden;
mod move_enet;
mod pytorch;
mod training;
