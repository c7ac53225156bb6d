//! Hands before any sensor.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_cli::progress::bar;
use evpose_cli::{configs, recorded};
use evpose_core::SensorSize;
use evpose_task::hand::{HandCheckpoint, HandConfig, canonical_view};
use evpose_train::{HandDataset, Method, evaluate, evaluated_pose_count};

use super::{BenchCamerasArgs, Scenes, covering_fov_deg};

const SCENES: &str = "quick";

pub(super) fn scenes(checkpoint: HandCheckpoint, args: &BenchCamerasArgs) -> Result<Scenes> {
    let mut scenes = configs::load::<HandConfig>(SCENES, &[])?;
    scenes.seed = args.seed;
    scenes.simulation.sequences = args.sequences;
    scenes.simulation.seconds = args.seconds;
    // A scale would shrink every sensor, and their sizes are what is compared.
    scenes.simulation.image_scale = 1.0;
    let native = canonical_view(&checkpoint.config).sensor;
    let score = move |sensor| score(&checkpoint, scenes.clone(), sensor);
    Ok(Scenes { metric: "AUC 2D", native, score: Box::new(score) })
}

fn score(checkpoint: &HandCheckpoint, mut scenes: HandConfig, sensor: SensorSize) -> Result<f64> {
    let simulation = &mut scenes.simulation;
    simulation.sensor_size = sensor;
    // Every sensor sees at least what one of 4 to 3 does: none loses a part of the scene.
    let fov_deg = f64::from(simulation.camera.vertical_fov_deg);
    simulation.camera.vertical_fov_deg = covering_fov_deg(sensor, fov_deg) as f32;
    let directory = tempfile::tempdir().context("a directory for the recordings")?;
    recorded::record(&scenes, directory.path(), "simulating")?;
    let config = &checkpoint.config;
    let data = HandDataset::open(directory.path(), config)?;
    let mut network = checkpoint.predictor(Device::flex())?;
    let mut methods = [Method { name: "trained", predictor: &mut network, filtered: None }];
    let progress = bar("evaluating", evaluated_pose_count(config, &data, 1), "poses");
    let results = evaluate(config, &data, &mut methods, 1, &mut |done| progress.inc(done))?;
    progress.finish_and_clear();
    let summary = results[0].evaluation.summary(&config.evaluation.bootstrap);
    Ok(summary.auc_2d.context("no pose was evaluated")?.estimate)
}
