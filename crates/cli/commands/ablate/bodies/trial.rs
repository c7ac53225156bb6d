//! One network under one seed, trained; one row under one seed, judged.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_nn::DeviceKind;
use evpose_pose::metric::body::BodySummary;
use evpose_pose::metric::{BootstrapConfig, Interval};
use evpose_train::TrainOptions;
use evpose_train::body::{
    BodyCheckpoint, BodyConfig, BodyFrames, BodyPredictor, BodyPredictorOptions, judge_frames,
    train_body,
};
use serde::{Deserialize, Serialize};

use super::Stages;
use super::rows::{Network, Row, Test};
use crate::commands::ablate::places::{read, write};
use crate::commands::ablate::watch;
use crate::commands::body;
use crate::run_info::COMMIT;

/// What a row came to under a seed.
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

/// Runs what is not done yet of `row` under the seed of `stages`.
pub(super) fn run(out: &Path, row: &Row, stages: &Stages, device: DeviceKind) -> Result<Trial> {
    let seed = stages.finetune.seed;
    let path = out.join("rows").join(row.name).join(format!("seed-{seed}.json"));
    if let Some(trial) = read(&path)? {
        return Ok(trial);
    }
    let run = train(out, row.network, stages, device)?;
    let checkpoint = BodyCheckpoint::load(&run, &Device::flex())?;
    let data = recordings(out, row.judged_on, stages)?;
    let config = judged_as(row.network, row.judged_on, stages);
    let frames = body::frames(&config, &data)?;
    let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None)?;
    let mean = checkpoint.mean_pose.context("the training poses have no mean")?;
    let (network, mean_pose) = judge_frames(&predictor, &frames, &mean)?;
    // Intervals come from seeds, not from sequences.
    let bootstrap = BootstrapConfig { resamples: 0, seed: 0 };
    let summary = |evaluation: evpose_pose::metric::body::BodyEvaluation| {
        evaluation.summary(&[40, 80], &bootstrap)
    };
    let (network, mean_pose) = (summary(network)?, summary(mean_pose)?);
    let trained: Option<Trained> = read(&run.join(TRAINED))?;
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
        training_s: trained.and_then(|trained| trained.seconds),
    };
    std::fs::create_dir_all(path.parent().unwrap_or(out))
        .with_context(|| format!("creating {}", path.display()))?;
    write(&path, &trial)?;
    Ok(trial)
}

/// Images as the network of a row is shown them, of what it is judged on.
fn judged_as(network: Network, test: Test, stages: &Stages) -> BodyConfig {
    let trained = match network {
        // Judged on what the full method is judged on.
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
    interval.map(|interval| interval.estimate).context("no pose could be judged")
}

fn pck(summary: &BodySummary, place: usize) -> Result<f64> {
    estimate(summary.raw.pck.get(place).copied().flatten())
}

/// How long a training took, beside it.
const TRAINED: &str = "trained.json";

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Trained {
    seconds: Option<f64>,
}

/// The run of a network, trained where it is not yet.
fn train(out: &Path, network: Network, stages: &Stages, device: DeviceKind) -> Result<PathBuf> {
    let seed = stages.finetune.seed;
    let run = out.join("networks").join(network.name()).join(format!("seed-{seed}"));
    if run.join(TRAINED).exists() {
        return Ok(run);
    }
    let mut config = network.config(stages);
    if let Some(first) = network.starts_from() {
        config.start_from = Some(train(out, first, stages, device)?);
    }
    let data = out.join("data").join(format!("seed-{seed}")).join("train");
    if config.data.source.is_recorded() {
        body::prepare(&stages.finetune, &data)?;
    }
    let frames: BodyFrames = body::frames(&config, &data)?;
    let (progress, told) = watch::training(network.name(), 1);
    let options = TrainOptions { device, resume: true, plain: true, told: Some(told) };
    let summary = train_body(&config, frames, &run, &options)
        .with_context(|| format!("training {}", run.display()))?;
    progress.finish_and_clear();
    let all = config.training.steps as f64 * config.training.batch_size as f64;
    let seconds = (summary.samples > 0).then(|| all / summary.samples_per_second);
    write(&run.join(TRAINED), &Trained { seconds })?;
    Ok(run)
}

/// The recordings that networks are judged on, simulated where they are missing.
fn recordings(out: &Path, test: Test, stages: &Stages) -> Result<PathBuf> {
    let data = out.join("data").join(format!("seed-{}", stages.finetune.seed)).join(test.name());
    body::prepare(&test.config(stages), &data)?;
    Ok(data)
}
