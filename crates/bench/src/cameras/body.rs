//! People before any sensor.

use anyhow::{Context, Result};
use evpose_cli::configs;
use evpose_cli::progress::bar;
use evpose_cli::recorded;
use evpose_cli::run_info;
use evpose_core::{Micros, SensorSize};
use evpose_sim::Shard;
use evpose_task::body::{BodyCheckpoint, BodyConfig, BodyPredictor, BodyPredictorOptions};
use evpose_train::body::{BodyRecordings, evaluate_body};

use super::{BenchCamerasArgs, Scenes, covering_fov_deg};

const SCENES: &str = "finetune";
/// Threshold of PCK in percent of the torso.
const PERCENT: usize = 40;
/// The sensor of most training recordings.
const NATIVE: SensorSize = SensorSize { width: 346, height: 260 };

pub(super) fn scenes(checkpoint: BodyCheckpoint, args: &BenchCamerasArgs) -> Result<Scenes> {
    let mut scenes = configs::load::<BodyConfig>(SCENES, &[])?.held_out();
    scenes.seed = args.seed;
    scenes.simulation.sequences = args.sequences;
    scenes.simulation.seconds = args.seconds;
    let score = move |sensor| score(&checkpoint, scenes.clone(), sensor);
    Ok(Scenes { metric: "PCK@0.4", native: NATIVE, score: Box::new(score) })
}

fn score(checkpoint: &BodyCheckpoint, mut scenes: BodyConfig, sensor: SensorSize) -> Result<f64> {
    let simulation = &mut scenes.simulation;
    simulation.sensor_size = sensor;
    // Every sensor sees at least what one of 4 to 3 does: none loses a part of the scene.
    simulation.vertical_fov_deg = simulation
        .vertical_fov_deg
        .map(|degrees| covering_fov_deg(sensor, f64::from(degrees)) as f32);
    let directory = tempfile::tempdir().context("a directory for the recordings")?;
    // The recording ends with a check against this file.
    run_info::write_shared(directory.path(), &scenes)?;
    recorded::record_people_of(&scenes, directory.path(), Shard::WHOLE)?;
    let recordings = BodyRecordings::open(directory.path())?;
    let predictor = BodyPredictor::new(checkpoint, BodyPredictorOptions::default(), None)?;
    let every = Micros(1_000 * i64::from(checkpoint.config.evaluation.every_ms));
    // The evaluation takes one, but its scores are not used here.
    let mean = checkpoint.mean_pose.unwrap_or_default();
    let progress = bar("evaluating", recordings.files.len() as u64, "recordings");
    let advance = |done| progress.inc(done);
    let results = evaluate_body(checkpoint, &predictor, &recordings, every, None, &mean, &advance)?;
    progress.finish_and_clear();
    let bootstrap = &checkpoint.config.evaluation.bootstrap;
    let summary = results.network().summary(&[PERCENT], bootstrap)?;
    let pck = summary.raw.pck.first().copied().flatten();
    Ok(pck.context("no joint was evaluated")?.estimate)
}
