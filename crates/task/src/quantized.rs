//! Calibration of int8 inference: the value ranges of all layers, in a file beside the checkpoint.

use std::path::{Path, PathBuf};

use evpose_core::atomic_write;
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, InferError, Precision};
use evpose_nn::graph::{Graph, Operation};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::{BEST, TaskError};

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
    /// columns]`, and calls `progress` after each. A network with ranges compiles in int8.
    ///
    /// # Errors
    /// If the network cannot be compiled, an input cannot be read, or there is no range of a layer:
    /// [`TaskError::NoRange`].
    pub fn calibrate<E: From<TaskError>>(
        graph: &Graph,
        shape: [usize; 3],
        inputs: impl IntoIterator<Item = Result<Vec<f32>, E>>,
        progress: &mut dyn FnMut(),
    ) -> Result<Self, E> {
        // Chained layers keep their values to themselves.
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
        if let Some(layer) = ranges.first_not_finite() {
            return Err(TaskError::NoRange { layer: layer.to_owned(), windows }.into());
        }
        let int8 = EngineOptions::default().with_precision(Precision::Int8);
        // It is compiled on trial: a layer without a range must fail before a file is written.
        Engine::compile_with(graph, shape, int8, Some(&ranges)).map_err(|error| match error {
            InferError::NotCalibrated { layer } => TaskError::NoRange { layer, windows },
            error => TaskError::from(error),
        })?;
        Ok(Self { weights: digest(graph), windows, ranges })
    }

    /// The value ranges.
    pub fn ranges(&self) -> &CalibrationRanges {
        &self.ranges
    }

    /// The file of a checkpoint: in the run directory, also of its best network by the name of the
    /// file, or beside the weight file.
    pub fn path(checkpoint: &Path) -> PathBuf {
        if checkpoint.is_dir() {
            checkpoint.join(NAME)
        } else if checkpoint.file_name().is_some_and(|name| name == BEST) {
            checkpoint.with_file_name(NAME)
        } else {
            checkpoint.with_extension(NAME)
        }
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

    /// The ranges that inference in a precision needs: of int8 those beside the checkpoint, of others none.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn needed(
        precision: Precision,
        checkpoint: Option<&Path>,
        graph: impl FnOnce() -> Graph,
    ) -> Result<Option<CalibrationRanges>, TaskError> {
        if precision != Precision::Int8 {
            return Ok(None);
        }
        let path = Self::path(checkpoint.unwrap_or(Path::new("")));
        Ok(Some(Self::read(&path, &graph())?.ranges))
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
        // Ranges of other weights would clip values without any error.
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
    format!("{:x}", hash.finalize())
}

#[cfg(test)]
mod tests {
    use burn::tensor::Device;
    use evpose_nn::MoveEnetConfig;

    use super::*;

    const SHAPE: [usize; 3] = [3, 32, 32];

    fn graph() -> Graph {
        let config = MoveEnetConfig { width: 0.25, expansion: 2, ..MoveEnetConfig::default() };
        config.init(1, &Device::flex()).unwrap().graph()
    }

    fn calibrate(graph: &Graph, inputs: usize) -> Result<QuantizationRanges, TaskError> {
        let image: Vec<f32> = (0..3 * 32 * 32).map(|i| (i % 7) as f32 / 7.0).collect();
        let inputs = (0..inputs).map(|_| Ok(image.clone()));
        QuantizationRanges::calibrate(graph, SHAPE, inputs, &mut || ())
    }

    #[test]
    fn ranges_come_back_and_compile() {
        let (directory, graph) = (tempfile::tempdir().unwrap(), graph());
        let path = QuantizationRanges::path(directory.path());
        let ranges = calibrate(&graph, 1).unwrap();
        ranges.write(&path).unwrap();
        let read = QuantizationRanges::read(&path, &graph).unwrap();
        assert_eq!(read, ranges);
        let int8 = EngineOptions::default().with_precision(Precision::Int8);
        Engine::compile_with(&graph, SHAPE, int8, Some(read.ranges())).unwrap();
    }

    #[test]
    fn ranges_that_int8_could_not_use_are_refused_before_they_are_written() {
        let mut graph = graph();
        let error = calibrate(&graph, 0).unwrap_err();
        assert!(matches!(error, TaskError::NoRange { windows: 0, .. }), "{error}");
        for node in &mut graph.nodes {
            if let Operation::Conv(conv) = &mut node.operation {
                conv.bias.fill(f32::INFINITY);
            }
        }
        let error = calibrate(&graph, 1).unwrap_err();
        assert!(matches!(error, TaskError::NoRange { windows: 1, .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains("--precision f32") && !message.contains("quantize"), "{message}");
    }

    #[test]
    fn a_run_and_its_best_network_share_their_ranges() {
        let directory = tempfile::tempdir().unwrap();
        let of = |name: &str| QuantizationRanges::path(&directory.path().join(name));
        assert_eq!(of("best.bpk"), QuantizationRanges::path(directory.path()));
        assert_eq!(of("hand.bpk"), directory.path().join("hand.int8.json"));
    }
}
