//! Experiments of bodies, step by step.

use std::path::Path;

use crate::progress::bar;
use crate::recorded::{self, claim, record_people_of, summary_of_people};
use anyhow::Result;
use evpose_core::Micros;
use evpose_core::stats::bootstrap::{BootstrapConfig, Totals};
use evpose_pose::metric::body::{BodySequence, JointErrors};
use evpose_sensor::SensorConfig;
use evpose_sim::config::SensorChoice;
use evpose_sim::{SequenceSet, Shard};
use evpose_task::Experiment;
use evpose_task::body::{BodyConfig, BodyPredictorOptions};
use evpose_train::body::{
    BODY_VALUES, BodyRecordings, evaluate_body, mean_pose_of_recordings, train_body,
};
use evpose_train::training::TrainingSpan;
use evpose_train::{LoggedValue, TrainOptions};

use super::BodyNetwork;
use crate::tasks::experiment::{PoseExperiment, is_trained};
use crate::tasks::scores::{EvaluationScores, Metric, RecordingScores};

const METRICS: [Metric; 3] = [
    Metric { key: "auc", heading: "AUC", digits: 3, is_error: false },
    Metric { key: "pck_40", heading: "PCK@0.4", digits: 3, is_error: false },
    Metric { key: "mpjpe_px", heading: "MPJPE px", digits: 2, is_error: true },
];

/// In the order of [`METRICS`], each joint by itself.
fn totals(sequence: &BodySequence) -> [Vec<Totals>; METRICS.len()] {
    let of = |value: fn(&JointErrors) -> Totals| sequence.raw.joints.iter().map(value).collect();
    [of(|joint| joint.pck.area()), of(|joint| joint.pck.correct(40)), of(|joint| joint.distance_px)]
}

impl PoseExperiment for BodyConfig {
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
        let training = &self.training;
        format!(
            "bodies: move_enet of width {}, {} steps of {} images",
            self.network.width, training.steps, training.batch_size
        )
    }

    fn length(&self) -> TrainingSpan {
        TrainingSpan::from(&self.training)
    }

    fn logged_values(&self) -> &'static [LoggedValue] {
        &BODY_VALUES
    }

    fn trains_on_recordings(&self) -> bool {
        self.data.source.is_recorded()
    }

    fn bootstrap(&self) -> BootstrapConfig {
        self.evaluation.bootstrap
    }

    fn simulate(&self, directory: &Path, _label: &str) -> Result<String> {
        let set = SequenceSet::of_people(directory, &self.simulation)?;
        claim(&set, self, Shard::WHOLE, true)?;
        Ok(summary_of_people(&record_people_of(self, directory, Shard::WHOLE)?, self))
    }

    fn train(&self, data: &Path, run: &Path, options: &TrainOptions) -> Result<()> {
        if !is_trained(self, run)? {
            train_body(self, recorded::frames(self, data)?, run, options)?;
        }
        Ok(())
    }
}

/// Scores of a model on each recording of a directory, at the instants of its predictions.
pub(super) fn scores(
    model: &BodyNetwork,
    data: &Path,
    stride_ms: Option<u32>,
) -> Result<EvaluationScores> {
    let checkpoint = &model.checkpoint;
    let predictor = model.predictor(BodyPredictorOptions::default())?;
    let recordings = BodyRecordings::open(data)?;
    let mean = checkpoint.mean_pose.map_or_else(|| mean_pose_of_recordings(&recordings), Ok)?;
    let every_ms = stride_ms.unwrap_or(checkpoint.config.evaluation.every_ms);
    let every = Micros(1_000 * i64::from(every_ms));
    let progress = bar("evaluating", recordings.files.len() as u64, "recordings");
    let advance = |done| progress.inc(done);
    let evaluated =
        evaluate_body(checkpoint, &predictor, &recordings, every, None, &mean, &advance)?;
    progress.finish_and_clear();
    let recordings = evaluated.recordings.iter().map(|recording| RecordingScores {
        recording: recording.events.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        totals: totals(&recording.network).to_vec(),
    });
    Ok(EvaluationScores { metrics: &METRICS, recordings: recordings.collect() })
}
