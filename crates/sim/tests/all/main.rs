//! Tests of the simulator by its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, reason = "tests")]

mod actors;
mod people;
mod set;
mod simulation;
mod support;
