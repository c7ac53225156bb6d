//! Windows of a recording as dense planes: stacks in NumPy's files.
//!
//! | file | content |
//! |---|---|
//! | `.npy` | `f32`, `[windows, channels, rows, columns]`, in C order |
//! | `.npz` | this array as `frames`, and `t_us`: the end of each window as `i64` |
//!
//! [`TensorWriter`] takes window by window, so that memory does not grow with their count;
//! [`TensorStack`] reads such a file whole.

mod reader;
mod writer;

pub use reader::TensorStack;
pub use writer::{TensorWriter, write_window};

/// The array of all windows in an archive.
const FRAMES: &str = "frames";
/// The array of times in an archive.
const TIMES: &str = "t_us";
/// The type of the values.
const VALUE_TYPE: &str = "'<f4'";

/// The shape of a stack: windows, channels, rows, columns.
pub type StackShape = [u64; 4];

#[cfg(test)]
mod tests;
