//! Tests of the engine by its public interface: one program, so that it is linked once. What occupies all threads is in `threads`.

#![allow(clippy::unwrap_used, reason = "tests")]

mod networks;
mod onnx;
mod precision;
