//! The network that is shipped, on the motion of the demo.

use std::path::{Path, PathBuf};

use crate::progress::{bar, say};
use crate::recorded;
use crate::shipped::checkpoint_path;
use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_task::hand::{HandCheckpoint, HandConfig};
use evpose_train::{HandDataset, Method, MethodResults, evaluate, evaluated_pose_count};

const NAME: &str = "hand";
/// Names of its results.
const METHOD: &str = "shipped";
pub(super) const FILTERED: &str = "shipped_kalman";

pub(super) struct Shipped {
    pub(super) path: PathBuf,
    pub(super) checkpoint: HandCheckpoint,
}

impl Shipped {
    /// Reads it. None if the program stands alone.
    pub(super) fn load(device: &Device) -> Result<Option<Self>> {
        let path = checkpoint_path(Path::new(NAME))?;
        if !path.exists() {
            return Ok(None);
        }
        let checkpoint = HandCheckpoint::load(&path, device)?;
        Ok(Some(Self { path, checkpoint }))
    }

    /// The config of the scenes of `demo` before the camera that the network expects.
    pub(super) fn scenes(&self, demo: &HandConfig) -> HandConfig {
        let own = &self.checkpoint.config.simulation;
        let mut config = demo.clone();
        config.simulation.sensor_size = own.sensor_size;
        config.simulation.image_scale = own.image_scale;
        config
    }

    /// Evaluates it on the held-out motion of `demo`, recorded once more into `directory` with the
    /// resolution that it expects.
    pub(super) fn evaluate(
        &self,
        demo: &HandConfig,
        directory: &Path,
        device: &Device,
        stride_ms: u32,
    ) -> Result<Vec<MethodResults>> {
        // The same motion at another resolution, since this network expects its own.
        let scenes = self.scenes(demo);
        recorded::record(&scenes.held_out(), directory, "held-out, shipped")?;
        let config = &self.checkpoint.config;
        let data = HandDataset::open(directory, config)?;
        let mut predictor = self.checkpoint.predictor(device.clone())?;
        let mut methods =
            [Method { name: METHOD, predictor: &mut predictor, filtered: Some(FILTERED) }];
        let progress = bar("evaluating", evaluated_pose_count(config, &data, stride_ms), "poses");
        let results =
            evaluate(config, &data, &mut methods, stride_ms, &mut |done| progress.inc(done))?;
        progress.finish_and_clear();
        Ok(results)
    }

    /// Says which network it is.
    pub(super) fn introduce(&self) -> Result<()> {
        let megabytes = std::fs::metadata(&self.path)
            .with_context(|| format!("reading {}", self.path.display()))?
            .len() as f64
            / 1e6;
        say(format!("shipped: {} ({megabytes:.1} MB)", self.path.display()));
        Ok(())
    }
}
