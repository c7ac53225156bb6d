//! Experiments of hands, step by step.

use std::path::Path;

use crate::progress::bar;
use crate::recorded::{claim, record_shard_of};
use anyhow::Result;
use evpose_core::stats::bootstrap::{BootstrapConfig, Totals};
use evpose_nn::HandHead;
use evpose_pose::metric::SequenceScores;
use evpose_sensor::SensorConfig;
use evpose_sim::config::SensorChoice;
use evpose_sim::{SequenceSet, Shard};
use evpose_task::Experiment;
use evpose_task::hand::HandConfig;
use evpose_train::training::TrainingSpan;
use evpose_train::{
    HAND_VALUES, HandDataset, JOINT_VALUES, LoggedValue, Method, TrainOptions, evaluate,
    evaluated_pose_count, train_hand,
};

use super::HandNetwork;
use crate::tasks::experiment::{PoseExperiment, is_trained};
use crate::tasks::scores::{EvaluationScores, Metric, RecordingScores};
use evpose_infer::Precision;

/// Milliseconds between evaluated poses, unless the user says otherwise.
const STRIDE_MS: u32 = 5;

const METRICS: [Metric; 5] = [
    Metric { key: "auc_2d", heading: "AUC 2D", digits: 3, is_error: false },
    Metric { key: "auc_3d", heading: "AUC 3D", digits: 3, is_error: false },
    Metric { key: "mpjpe_mm", heading: "MPJPE mm", digits: 1, is_error: true },
    Metric { key: "translation_mm", heading: "translation mm", digits: 1, is_error: true },
    Metric { key: "rotation_deg", heading: "rotation deg", digits: 1, is_error: true },
];

/// In the order of [`METRICS`].
fn totals(scores: &SequenceScores) -> [Totals; METRICS.len()] {
    [
        scores.pck_2d.area(),
        scores.pck_3d.area(),
        scores.points_mm,
        scores.translation_mm,
        scores.rotation_deg,
    ]
}

impl PoseExperiment for HandConfig {
    fn seed(&self) -> u64 {
        self.seed
    }

    fn with_seed(&self, seed: u64) -> Box<dyn PoseExperiment> {
        Box::new(Self { seed, ..self.clone() })
    }

    fn with_sensor(&self, sensor: &SensorConfig) -> Box<dyn PoseExperiment> {
        let mut config = self.clone();
        config.simulation.sensor = SensorChoice::Chain(sensor.clone());
        Box::new(config)
    }

    fn held_out(&self) -> Box<dyn PoseExperiment> {
        Box::new(Self::held_out(self))
    }

    fn to_toml(&self) -> Result<String> {
        Ok(Experiment::to_toml(self)?)
    }

    fn description(&self) -> String {
        let (network, training) = (&self.network, &self.training);
        format!(
            "hands: {} of width {}, {} steps of {} windows",
            network.backbone, network.width, training.steps, training.batch_size
        )
    }

    fn length(&self) -> TrainingSpan {
        TrainingSpan::from(&self.training)
    }

    fn logged_values(&self) -> &'static [LoggedValue] {
        match self.network.head {
            HandHead::Regressor => &HAND_VALUES,
            HandHead::Joints => &JOINT_VALUES,
        }
    }

    fn trains_on_recordings(&self) -> bool {
        true
    }

    fn bootstrap(&self) -> BootstrapConfig {
        self.evaluation.bootstrap
    }

    fn simulate(&self, directory: &Path, label: &str) -> Result<String> {
        let set = SequenceSet::of_hands(directory, &self.simulation)?;
        claim(&set, self, Shard::WHOLE, true)?;
        Ok(record_shard_of(self, directory, Shard::WHOLE, label)?.to_string())
    }

    fn train(&self, data: &Path, run: &Path, options: &TrainOptions) -> Result<()> {
        if !is_trained(self, run)? {
            train_hand(self, data, run, options)?;
        }
        Ok(())
    }
}

/// Scores of a model on each sequence of a directory, without the Kalman filter.
pub(super) fn scores(
    model: &HandNetwork,
    data: &Path,
    stride_ms: Option<u32>,
) -> Result<EvaluationScores> {
    let config = &model.checkpoint.config;
    let data = HandDataset::open(data, config)?;
    let stride_ms = stride_ms.unwrap_or(STRIDE_MS);
    let mut predictor = model.predictor(Precision::F32)?;
    let mut methods = [Method { name: "trained", predictor: &mut predictor, filtered: None }];
    let progress = bar("evaluating", evaluated_pose_count(config, &data, stride_ms), "poses");
    let advance = &mut |done| progress.inc(done);
    let results = evaluate(config, &data, &mut methods, stride_ms, advance)?;
    progress.finish_and_clear();
    let scores = results.iter().flat_map(|result| &result.evaluation.sequences);
    let recordings =
        data.sequences().iter().zip(scores).map(|(sequence, scores)| RecordingScores {
            recording: sequence.name().to_owned(),
            totals: totals(scores).into_iter().map(|totals| vec![totals]).collect(),
        });
    Ok(EvaluationScores { metrics: &METRICS, recordings: recordings.collect() })
}
