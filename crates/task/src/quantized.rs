//! Calibration of int8 inference: the value ranges of all layers, in a file beside the checkpoint.

use std::path::{Path, PathBuf};

use evpose_core::atomic_write;
use evpose_infer::{CalibrationRanges, Engine, EngineOptions};
use evpose_nn::graph::{Graph, Operation};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::TaskError;

/// Name of the file in a run directory.
const NAME: &str = "int8.json";

/// The calibrated value ranges of the layers of a network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantizationRanges {
    /// SHA-256 of the weights that were calibrated.
    weights: String,
    /// Number of inputs observed.
    windows: u64,
    ranges: CalibrationRanges,
}

impl QuantizationRanges {
    /// Observes the values of all layers of `graph` on inputs of the shape `[channels, rows,
    /// columns]`, and calls `progress` after each.
    ///
    /// # Errors
    /// If the network cannot be compiled, or an input cannot be read.
    pub fn calibrate<E: From<TaskError>>(
        graph: &Graph,
        shape: [usize; 3],
        inputs: impl IntoIterator<Item = Result<Vec<f32>, E>>,
        progress: &mut dyn FnMut(),
    ) -> Result<Self, E> {
        let options =
            EngineOptions::default().layer_by_layer().with_threads(rayon::current_num_threads());
        let mut engine = Engine::compile(graph, shape, options).map_err(TaskError::from)?;
        let mut ranges = CalibrationRanges::new(graph);
        let mut windows = 0;
        for input in inputs {
            engine.observe(&input?, &mut ranges);
            windows += 1;
            progress();
        }
        Ok(Self { weights: digest(graph), windows, ranges })
    }

    /// The value ranges.
    pub fn ranges(&self) -> &CalibrationRanges {
        &self.ranges
    }

    /// The file of a checkpoint: in the run directory, or beside the weight file.
    pub fn path(checkpoint: &Path) -> PathBuf {
        if checkpoint.is_dir() { checkpoint.join(NAME) } else { checkpoint.with_extension(NAME) }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), TaskError> {
        let text = serde_json::to_string_pretty(self).map_err(|error| TaskError::Config {
            path: path.to_path_buf(),
            message: error.to_string(),
        })?;
        atomic_write(path, (text + "\n").as_bytes())
            .map_err(|source| TaskError::Io { path: path.to_path_buf(), source })
    }

    /// Reads the file of a network.
    ///
    /// # Errors
    /// If there is none, it is damaged, or it is of other weights.
    pub fn read(path: &Path, graph: &Graph) -> Result<Self, TaskError> {
        let config = |message: String| TaskError::Config { path: path.to_path_buf(), message };
        let advice = "`evpose quantize` makes it, with a data set";
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(config(format!("8 bits need this file; {advice}")));
            }
            Err(source) => return Err(TaskError::Io { path: path.to_path_buf(), source }),
        };
        let read: Self = serde_json::from_str(&text)
            .map_err(|error| config(format!("damaged: {error}; {advice} again")))?;
        if read.weights != digest(graph) {
            return Err(config(format!("made for other weights than these; {advice} again")));
        }
        Ok(read)
    }
}

/// SHA-256 of all weights of a network.
fn digest(graph: &Graph) -> String {
    let mut hash = Sha256::new();
    for node in &graph.nodes {
        let parts = match &node.operation {
            Operation::Conv(layer) => [&layer.weight, &layer.bias],
            Operation::Linear(layer) => [&layer.weight, &layer.bias],
            _ => continue,
        };
        for value in parts.into_iter().flatten() {
            hash.update(value.to_le_bytes());
        }
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
