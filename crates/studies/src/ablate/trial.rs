//! One row under one seed: trained, evaluated on held-out sequences, timed.

use std::path::{Path, PathBuf};

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
    HandDataset, Method, evaluate, evaluated_pose_count, read_history, train_hand,
    validation_losses,
};
use serde::{Deserialize, Serialize};

use crate::study::{Measure, Measured, Training, measure, training_s};
use evpose_cli::latency::{self, Runner};
use evpose_cli::machine::Machine;
use evpose_cli::progress::{bar, training_bar};
use evpose_cli::run_info::{COMMIT, CONFIG};
use evpose_core::stats::quantile::nearest_rank;

const TIMED: usize = 100;
/// Stride of the stored thresholds of a curve: every tenth of a thousand is a whole millimetre or
/// percent.
pub(super) const CURVE_STRIDE: usize = 10;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Trial {
    row: String,
    seed: u64,
    /// Milliseconds between evaluated poses.
    pub(super) stride_ms: u32,
    pub(super) made: Provenance,
    /// Parameters of the network as trained.
    pub(super) parameters: usize,
    /// Parameters of the network at the published width.
    pub(super) parameters_as_published: usize,
    /// None where the training was resumed after its last step.
    pub(super) training_s: Option<f64>,
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

/// A trial as a row sees it: rows that differ in evaluation alone share the trials of one network.
#[derive(Debug, Serialize)]
pub(super) struct RowTrial {
    #[serde(flatten)]
    pub(super) figures: Metrics,
    #[serde(skip)]
    pub(super) pck_2d: Vec<f64>,
    #[serde(skip)]
    pub(super) pck_3d: Vec<f64>,
    /// None of a pose that no network predicted.
    #[serde(skip)]
    pub(super) trial: Option<Trial>,
}

impl RowTrial {
    pub(super) fn new(scores: &Scores, trial: Option<&Trial>) -> Self {
        let Scores { figures, pck_2d, pck_3d } = scores.clone();
        Self { figures, pck_2d, pck_3d, trial: trial.cloned() }
    }
}

impl Measured for RowTrial {
    const MEASURES: &'static [Measure<Self>] = &[
        measure(("auc_2d", "AUC 2D", 3, false), |row| Some(row.figures.auc_2d)),
        measure(("auc_3d", "AUC 3D", 3, false), |row| Some(row.figures.auc_3d)),
        measure(("mpjpe_mm", "MPJPE mm", 1, true), |row| Some(row.figures.mpjpe_mm)),
        measure(("translation_mm", "wrist mm", 1, true), |row| Some(row.figures.translation_mm)),
        measure(("rotation_deg", "wrist deg", 1, true), |row| Some(row.figures.rotation_deg)),
        measure(("articulation", "articulation", 2, true), |row| Some(row.figures.articulation)),
        measure(("validation_loss", "validation loss", 2, true), |row| {
            row.trial.as_ref()?.validation_loss
        }),
        measure(("parameters", "parameters", 0, true), |row| {
            Some(row.trial.as_ref()?.parameters as f64)
        }),
        measure(("parameters_as_published", "at full width", 0, true), |row| {
            Some(row.trial.as_ref()?.parameters_as_published as f64)
        }),
        measure(("poses_per_s", "poses/s", 0, false), |row| Some(row.trial.as_ref()?.poses_per_s)),
        measure(("training_s", "training s", 0, true), |row| row.trial.as_ref()?.training_s),
    ];

    fn timed_on(&self) -> String {
        let made = self.trial.as_ref().map(|trial| &trial.made);
        made.map_or_else(String::new, |made| format!("{}, device {}", made.machine, made.device))
    }

    fn curves(&self) -> Vec<(&'static str, &[f64])> {
        vec![("pck_2d", &self.pck_2d[..]), ("pck_3d", &self.pck_3d[..])]
    }
}

pub(super) struct TrialRun {
    pub(super) row: &'static str,
    pub(super) config: HandConfig,
    /// Directory of the training.
    pub(super) run: PathBuf,
    pub(super) train: PathBuf,
    /// Sequences of the test set.
    pub(super) held_out: PathBuf,
    pub(super) stride_ms: u32,
    pub(super) device: DeviceKind,
}

impl TrialRun {
    /// Whether its network is finished.
    pub(super) fn is_trained(&self) -> Result<bool> {
        let is_trained = Training::is_finished(&self.run);
        // It is not trained anew: that would overwrite hours of somebody's training.
        if is_trained && HandConfig::read(&self.run.join(CONFIG))? != self.config {
            bail!(
                "{} is of another config: remove it, or choose another --out",
                self.run.display()
            );
        }
        Ok(is_trained)
    }

    /// Runs its unfinished steps.
    pub(super) fn finish(&self) -> Result<Trial> {
        let Self { row, config, run, .. } = self;
        let device = &self.device.resolve()?;
        if !self.is_trained()? {
            let (progress, callback) = training_bar(row);
            let samples = config.training.steps * config.training.batch_size as u64;
            Training { run, device: self.device, samples }
                .once(callback, |options| Ok(train_hand(config, &self.train, run, options)?))?;
            progress.finish_and_clear();
        }
        let checkpoint = HandCheckpoint::load(run, device)?;
        let image = config.network_size();
        let input = [1, 2, usize::from(image.height), usize::from(image.width)];
        let mut runner = Runner::usual(&checkpoint.network, input, device)?;
        let times_ms = latency::sorted_ms(&mut runner, input, TIMED, config.seed);
        // It holds a compiled copy of the weights, which the evaluation does not need.
        drop(runner);
        // Published counts are of full width, at which few are trained here.
        let published = HandRegressorConfig { width: 1.0, ..config.network.clone() };
        let [filtered, unfiltered, mean_pose] = self.evaluate(&checkpoint, device)?;
        Ok(Trial {
            row: (*row).to_owned(),
            seed: config.seed,
            stride_ms: self.stride_ms,
            made: Provenance::here(self.device),
            parameters: trained_count(&checkpoint.network),
            parameters_as_published: published.parameter_count()?,
            training_s: training_s(run)?,
            validation_loss: lowest_validation_loss(run)?,
            poses_per_s: 1e3 / nearest_rank(&times_ms, 0.5),
            filtered,
            unfiltered,
            mean_pose,
        })
    }

    /// Scores of the network with and without the filter, and of the mean pose.
    fn evaluate(&self, checkpoint: &HandCheckpoint, device: &Device) -> Result<[Scores; 3]> {
        let Self { config, stride_ms, .. } = self;
        let data = HandDataset::open(&self.held_out, config)?;
        let mean_pose = checkpoint.mean_pose.context("the training poses have no mean")?;
        let mut mean_pose = ConstantPose(mean_pose);
        let mut network = checkpoint.predictor(device.clone())?;
        let mut methods = [
            // Filtered poses come from the same inferences.
            Method { name: "unfiltered", predictor: &mut network, filtered: Some("filtered") },
            Method { name: "mean_pose", predictor: &mut mean_pose, filtered: None },
        ];
        let progress = bar("evaluating", evaluated_pose_count(config, &data, *stride_ms), "poses");
        let evaluated =
            evaluate(config, &data, &mut methods, *stride_ms, &mut |done| progress.inc(done))?;
        progress.finish_and_clear();
        let of = |name: &str| {
            let method = evaluated.iter().find(|method| method.name == name);
            scores(&method.with_context(|| format!("{name} was not evaluated"))?.evaluation)
        };
        Ok([of("filtered")?, of("unfiltered")?, of("mean_pose")?])
    }
}

fn lowest_validation_loss(run: &Path) -> Result<Option<f64>> {
    let losses = validation_losses(&read_history(&run.join("metrics.jsonl"))?);
    Ok(losses.into_values().filter(|loss| loss.is_finite()).reduce(f64::min))
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
