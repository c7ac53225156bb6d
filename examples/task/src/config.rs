//! The config of an experiment; `blob.toml` says what its fields are.

use std::num::NonZeroU16;

use evpose_core::SensorSize;
use evpose_task::Experiment;
use evpose_train::training::TrainingSpan;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlobConfig {
    pub(crate) task: String,
    pub(crate) seed: u64,
    pub(crate) sequences: usize,
    pub(crate) seconds: f64,
    pub(crate) diameters_px: [f32; 2],
    pub(crate) camera: String,
    pub(crate) representation: String,
    pub(crate) window_ms: u16,
    pub(crate) every_ms: NonZeroU16,
    pub(crate) channels: [usize; 4],
    pub(crate) learning_rate: f64,
    pub(crate) sensor: SensorSize,
    pub(crate) training: TrainingSpan,
}

impl Experiment for BlobConfig {
    const TASK: &'static str = "blob";

    fn seed(&self) -> u64 {
        self.seed
    }
}

impl BlobConfig {
    /// Channels, rows and columns of the input.
    pub(crate) fn shape(&self) -> [usize; 3] {
        [self.channels[0], self.sensor.height.into(), self.sensor.width.into()]
    }
}
