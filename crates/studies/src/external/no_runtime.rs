//! Stands for the runtime in a program that is built without it.

use std::path::Path;

use anyhow::{Error, Result, bail};

/// A network that cannot be opened.
pub(crate) enum OnnxModel {}

impl OnnxModel {
    pub(crate) fn open(path: &Path, _: [usize; 2]) -> Result<Self> {
        bail!(
            "{}: this program was built without the runtime of ONNX files: build it with \
             `cargo build --release --features onnx`",
            path.display()
        );
    }

    pub(crate) fn input_px(&self) -> [usize; 2] {
        match *self {}
    }

    pub(crate) fn output_shapes(&self) -> &[Vec<usize>] {
        match *self {}
    }

    pub(crate) fn other_outputs(&self, _: &'static str, _: &'static str) -> Error {
        match *self {}
    }

    pub(crate) fn run(&self, _: &[f32]) -> Result<Vec<Vec<f32>>> {
        match *self {}
    }
}
