//! Stands for the runtime in a program that is built without it.

use std::path::Path;

use crate::external::ExternalError;

/// A network that cannot be opened.
pub(crate) enum OnnxModel {}

impl OnnxModel {
    pub(crate) fn open(path: &Path, _: [usize; 2]) -> Result<Self, ExternalError> {
        Err(ExternalError::NotBuilt { path: path.to_owned() })
    }

    pub(crate) fn input_px(&self) -> [usize; 2] {
        match *self {}
    }

    pub(crate) fn output_shapes(&self) -> &[Vec<usize>] {
        match *self {}
    }

    pub(crate) fn other_outputs(&self, _: &'static str, _: &'static str) -> ExternalError {
        match *self {}
    }

    pub(crate) fn run(&self, _: &[f32]) -> Result<Vec<Vec<f32>>, ExternalError> {
        match *self {}
    }
}
