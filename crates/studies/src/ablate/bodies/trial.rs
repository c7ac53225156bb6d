//! One row under one seed: its network, evaluated on its test set.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::stats::interval::Interval;
use evpose_pose::metric::body::BodySummary;
use evpose_task::body::{BodyCheckpoint, BodyConfig, BodyPredictor, BodyPredictorOptions};
use evpose_train::body::evaluate_frames;
use serde::{Deserialize, Serialize};

use super::networks;
use super::rows::{Row, Test};
use super::{Network, Stages};
use evpose_cli::json::{read_result, write_result};
use evpose_cli::recorded;
use evpose_cli::run_info::COMMIT;

/// Results of a row under a seed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Trial {
    row: String,
    seed: u64,
    commit: String,
    /// Shares of correct joints at 0.4 and 0.8 of the torso.
    pub(super) pck_40: f64,
    pub(super) pck_80: f64,
    /// At 1 %, 2 %, …, 100 %.
    pub(super) curve: Vec<f64>,
    pub(super) auc: f64,
    pub(super) mpjpe_px: f64,
    /// Of the mean training pose, at 0.4.
    pub(super) mean_pose_40: f64,
    /// Of its own training, without those it starts from.
    pub(super) training_s: Option<f64>,
}

/// Evaluates the trained network of `row` under the seed of `stages` on `device`, unless results are
/// stored.
pub(super) fn run(out: &Path, row: &Row, stages: &Stages, device: &Device) -> Result<Trial> {
    let seed = stages.finetune.seed;
    let path = out.join("rows").join(row.name).join(format!("seed-{seed}.json"));
    // A finished trial is read, not run: studies take days.
    if let Some(trial) = read_result(&path)? {
        return Ok(trial);
    }
    let run = networks::directory(out, row.network.name(), seed);
    let checkpoint = BodyCheckpoint::load(&run, device)?;
    let data = recordings(out, row.evaluated_on, stages)?;
    let config = evaluation_config(row.network, row.evaluated_on, stages);
    let frames = recorded::frames(&config, &data)?;
    let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None)?;
    let mean = checkpoint.mean_pose.context("the training poses have no mean")?;
    let (network, mean_pose) = evaluate_frames(&predictor, &frames, &mean, &|_, _| {})?;
    // Intervals come from seeds, not from sequences.
    let bootstrap = BootstrapConfig { resamples: 0, seed: 0 };
    let summary = |evaluation: evpose_pose::metric::body::BodyEvaluation| {
        evaluation.summary(&[40, 80], &bootstrap)
    };
    let (network, mean_pose) = (summary(network)?, summary(mean_pose)?);
    let trial = Trial {
        row: row.name.to_owned(),
        seed,
        commit: COMMIT.to_owned(),
        pck_40: pck(&network, 0)?,
        pck_80: pck(&network, 1)?,
        auc: estimate(network.raw.auc)?,
        mpjpe_px: estimate(network.raw.mpjpe_px)?,
        curve: network.raw.curve,
        mean_pose_40: pck(&mean_pose, 0)?,
        training_s: networks::training_s(&run)?,
    };
    std::fs::create_dir_all(path.parent().unwrap_or(out))
        .with_context(|| format!("creating {}", path.display()))?;
    write_result(&path, &trial)?;
    Ok(trial)
}

/// Input images of a row's network, on its test set.
fn evaluation_config(network: Network, test: Test, stages: &Stages) -> BodyConfig {
    let trained = match network {
        // MethodResults on the test images of the full method.
        Network::Pretrained => Network::Scratch,
        Network::GreyPretrained => Network::Grey,
        other => other,
    };
    let mut config = trained.config(stages);
    let held_out = test.config(stages);
    (config.seed, config.simulation) = (held_out.seed, held_out.simulation);
    config
}

fn estimate(interval: Option<Interval>) -> Result<f64> {
    interval.map(|interval| interval.estimate).context("no pose could be evaluated")
}

fn pck(summary: &BodySummary, place: usize) -> Result<f64> {
    estimate(summary.raw.pck.get(place).copied().flatten())
}

/// Recordings of a test set, simulated where they are missing.
fn recordings(out: &Path, test: Test, stages: &Stages) -> Result<PathBuf> {
    let data = out.join("data").join(format!("seed-{}", stages.finetune.seed)).join(test.name());
    recorded::prepare(&test.config(stages), &data)?;
    Ok(data)
}
