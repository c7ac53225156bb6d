//! Tests of the gap workflow by its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, reason = "tests")]

mod camera;
mod catalogue;
mod davis;
mod formulas;
mod names;
