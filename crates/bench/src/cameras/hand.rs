//! Hands before any sensor.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_cli::progress::bar;
use evpose_cli::{configs, recorded};
use evpose_core::SensorSize;
use evpose_task::hand::{HandCheckpoint, HandConfig, canonical_view};
use evpose_train::{HandDataset, Method, evaluate, evaluated_pose_count};

use super::{BenchCamerasArgs, Scenes, covering_fov_deg};

/// Config of the scenes.
const SCENES: &str = "quick";

/// Scenes of hands.
pub(super) struct HandScenes {
    checkpoint: HandCheckpoint,
    scenes: HandConfig,
}

impl HandScenes {
    pub(super) fn new(checkpoint: HandCheckpoint, args: &BenchCamerasArgs) -> Result<Self> {
        let mut scenes = configs::load::<HandConfig>(SCENES, &[])?;
        scenes.seed = args.seed;
        scenes.simulation.sequences = args.sequences;
        scenes.simulation.seconds = args.seconds;
        scenes.simulation.image_scale = 1.0;
        Ok(Self { checkpoint, scenes })
    }
}

impl Scenes for HandScenes {
    fn metric(&self) -> &'static str {
        "AUC 2D"
    }

    fn native(&self) -> SensorSize {
        canonical_view(&self.checkpoint.config).sensor
    }

    fn score(&self, sensor: SensorSize) -> Result<f64> {
        let mut scenes = self.scenes.clone();
        let simulation = &mut scenes.simulation;
        simulation.sensor_size = sensor;
        // Every sensor sees at least what one of 4 to 3 does: none loses a part of the scene.
        let fov_deg = f64::from(simulation.camera.vertical_fov_deg);
        simulation.camera.vertical_fov_deg = covering_fov_deg(sensor, fov_deg) as f32;
        let directory = tempfile::tempdir().context("a directory for the recordings")?;
        recorded::record(&scenes, directory.path(), "simulating")?;
        let config = &self.checkpoint.config;
        let data = HandDataset::open(directory.path(), config)?;
        let mut network = self.checkpoint.predictor(Device::flex())?;
        let mut methods = [Method { name: "trained", predictor: &mut network, filtered: None }];
        let progress = bar("evaluating", evaluated_pose_count(config, &data, 1), "poses");
        let results = evaluate(config, &data, &mut methods, 1, &mut |done| progress.inc(done))?;
        progress.finish_and_clear();
        let summary = results[0].evaluation.summary(&config.evaluation.bootstrap);
        Ok(summary.auc_2d.context("no pose was evaluated")?.estimate)
    }
}
