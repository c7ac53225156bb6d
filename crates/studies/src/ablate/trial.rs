//! One row under one seed: trained, evaluated on held-out sequences, timed.

use std::path::Path;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::stats::interval::Interval;
use evpose_nn::parameters::trained_count;
use evpose_nn::{DeviceKind, HandRegressorConfig};
use evpose_pose::metric::HandEvaluation;
use evpose_task::Experiment as _;
use evpose_task::hand::{ConstantPose, HandCheckpoint, HandConfig};
use evpose_train::{
    HandDataset, Method, TrainOptions, evaluate, evaluated_pose_count, read_history, train_hand,
    validation_losses,
};
use serde::{Deserialize, Serialize};

use super::directories::StudyDirectory;
use super::progress;
use evpose_cli::json::{read_result, write_result};
use evpose_cli::latency::{self, Runner};
use evpose_cli::machine::Machine;
use evpose_cli::progress::bar;
use evpose_cli::run_info::COMMIT;
use evpose_core::stats::quantile::nearest_rank;

/// Timed inferences.
const TIMED: usize = 100;
/// Stride of the stored thresholds of a curve: every tenth of a thousand is a whole millimetre or
/// percent.
pub(super) const CURVE_STRIDE: usize = 10;

/// Results of a trial.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Trial {
    row: String,
    seed: u64,
    /// Milliseconds between evaluated poses.
    stride_ms: u32,
    pub(super) made: Provenance,
    /// Parameters of the network as trained.
    pub(super) parameters: usize,
    /// Parameters of the network at the published width.
    pub(super) parameters_as_published: usize,
    /// None where the training was resumed after its last step.
    pub(super) training_s: Option<f64>,
    /// Lowest validation loss of the training.
    pub(super) validation_loss: Option<f64>,
    /// Throughput of the network alone, at batch size 1.
    pub(super) poses_per_s: f64,
    pub(super) filtered: Scores,
    pub(super) unfiltered: Scores,
    /// Scores of the mean training pose, which does not depend on events.
    pub(super) mean_pose: Scores,
}

/// Program and machine of a trial, since a study may be continued elsewhere.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Provenance {
    pub(super) commit: String,
    pub(super) machine: String,
    /// Program and machine of a trial.
    pub(super) device: String,
}

impl Provenance {
    fn here(device: DeviceKind) -> Self {
        Self {
            commit: COMMIT.to_owned(),
            machine: Machine::this().to_string(),
            device: device.to_string(),
        }
    }

    /// Whether timings of both are comparable.
    pub(super) fn is_as_fast(&self, other: &Self) -> bool {
        self.machine == other.machine && self.device == other.device
    }
}

/// Scores of a method on all held-out sequences.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Scores {
    pub(super) figures: Metrics,
    /// Shares correct below 0, 1, … 99 percent of the palm.
    pub(super) pck_2d: Vec<f64>,
    /// Shares correct below 0, 1, … 99 mm.
    pub(super) pck_3d: Vec<f64>,
}

/// Means over all evaluated poses.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Metrics {
    pub(super) auc_2d: f64,
    pub(super) auc_3d: f64,
    /// Mean error of the points relative to the wrist.
    pub(super) mpjpe_mm: f64,
    pub(super) translation_mm: f64,
    pub(super) rotation_deg: f64,
    pub(super) articulation: f64,
}

/// Duration of a training, stored in case the evaluation is interrupted.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Trained {
    seconds: Option<f64>,
}

/// Runs the unfinished steps of `row` under the seed of `config`.
pub(super) fn run(
    directory: &StudyDirectory<'_>,
    row: &str,
    config: &HandConfig,
    seeds: usize,
    stride_ms: u32,
    kind: DeviceKind,
) -> Result<Trial> {
    let device = &kind.resolve()?;
    let dir = directory.run(row, config.seed);
    let (trial_path, trained_path) = (dir.join("trial.json"), dir.join("trained.json"));
    // Training and evaluation are stored apart: another stride needs no training.
    let kept: Option<Trial> = read_result(&trial_path)?;
    let trained: Option<Trained> = read_result(&trained_path)?;
    if trained.is_some() && HandConfig::read(&dir.join("config.toml"))? != *config {
        bail!("{} is of another config: remove it, or choose another --out", dir.display());
    }
    if let Some(trial) = kept.filter(|trial| trained.is_some() && trial.stride_ms == stride_ms) {
        return Ok(trial);
    }
    let trained = match trained {
        Some(trained) => trained,
        None => {
            let (progress, callback) = progress::training_bar(row, seeds);
            let options = TrainOptions {
                device: kind,
                resume: true,
                plain: true,
                progress: Some(callback),
                pause_after: None,
            };
            let summary = train_hand(config, &directory.train(config.seed), &dir, &options)?;
            progress.finish_and_clear();
            let all = config.training.steps as f64 * config.training.batch_size as f64;
            // A resumed training was timed in part; its full duration follows from its speed.
            let seconds = (summary.samples > 0).then(|| all / summary.samples_per_second);
            let trained = Trained { seconds };
            write_result(&trained_path, &trained)?;
            trained
        }
    };

    let checkpoint = HandCheckpoint::load(&dir, device)?;
    let image = config.network_size();
    let input = [1, 2, usize::from(image.height), usize::from(image.width)];
    let mut runner = Runner::usual(&checkpoint.network, input, device)?;
    let times_ms = latency::sorted_ms(&mut runner, input, TIMED, config.seed);
    drop(runner);
    let parameters = trained_count(&checkpoint.network);
    let published = HandRegressorConfig { width: 1.0, ..config.network.clone() };
    let [filtered, unfiltered, mean_pose] =
        evaluate_trial(directory, config, &checkpoint, stride_ms, device)?;
    let trial = Trial {
        row: row.to_owned(),
        seed: config.seed,
        stride_ms,
        made: Provenance::here(kind),
        parameters,
        parameters_as_published: published.parameter_count()?,
        training_s: trained.seconds,
        validation_loss: lowest_validation_loss(&dir)?,
        poses_per_s: 1e3 / nearest_rank(&times_ms, 0.5),
        filtered,
        unfiltered,
        mean_pose,
    };
    write_result(&trial_path, &trial)?;
    Ok(trial)
}

/// The validation loss of the checkpoint that the training in `run` kept.
fn lowest_validation_loss(run: &Path) -> Result<Option<f64>> {
    let losses = validation_losses(&read_history(&run.join("metrics.jsonl"))?);
    Ok(losses.into_values().filter(|loss| loss.is_finite()).reduce(f64::min))
}

/// Scores of the network with and without the filter, and of the mean pose.
fn evaluate_trial(
    directory: &StudyDirectory<'_>,
    config: &HandConfig,
    checkpoint: &HandCheckpoint,
    stride_ms: u32,
    device: &Device,
) -> Result<[Scores; 3]> {
    let data = HandDataset::open(&directory.held_out(config.seed), config)?;
    let mut mean_pose =
        ConstantPose(checkpoint.mean_pose.context("the training poses have no mean")?);
    let mut network = checkpoint.predictor(device.clone())?;
    let mut methods = [
        // Filtered poses come from the same inferences.
        Method { name: "unfiltered", predictor: &mut network, filtered: Some("filtered") },
        Method { name: "mean_pose", predictor: &mut mean_pose, filtered: None },
    ];
    let progress = bar("evaluating", evaluated_pose_count(config, &data, stride_ms), "poses");
    let evaluated =
        evaluate(config, &data, &mut methods, stride_ms, &mut |done| progress.inc(done))?;
    progress.finish_and_clear();
    let of = |name: &str| {
        let method = evaluated.iter().find(|method| method.name == name);
        scores(&method.with_context(|| format!("{name} was not evaluated"))?.evaluation)
    };
    Ok([of("filtered")?, of("unfiltered")?, of("mean_pose")?])
}

fn scores(evaluation: &HandEvaluation) -> Result<Scores> {
    // Intervals come from seeds, not from sequences.
    let summary = evaluation.summary(&BootstrapConfig { resamples: 0, seed: 0 });
    let figure = |interval: Option<Interval>| {
        interval.map(|interval| interval.estimate).context(
            "no pose could be evaluated: lengthen config field `evaluation.seconds` beyond \
             `evaluation.first_ms`",
        )
    };
    // A point for each millimetre or percent is enough to draw.
    let thinned = |curve: Vec<f64>| curve.into_iter().step_by(CURVE_STRIDE).collect();
    let curves = evaluation.curves();
    Ok(Scores {
        figures: Metrics {
            auc_2d: figure(summary.auc_2d)?,
            auc_3d: figure(summary.auc_3d)?,
            mpjpe_mm: figure(summary.mpjpe_mm)?,
            translation_mm: figure(summary.translation_mm)?,
            rotation_deg: figure(summary.rotation_deg)?,
            articulation: figure(summary.articulation)?,
        },
        pck_2d: thinned(curves.pck_2d),
        pck_3d: thinned(curves.pck_3d),
    })
}
