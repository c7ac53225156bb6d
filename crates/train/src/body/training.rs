//! Training of the body network.

use std::path::Path;
use std::sync::Arc;

use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_core::seed_for;
use evpose_nn::{Adam, BodyLoss, MoveEnet};
use evpose_pose::body::BodyPoints;
use evpose_task::body::{BodyCheckpoint, BodyConfig};
use evpose_task::schedule::{EarlyStop, TrainingPrecision};

use super::confidence::calibrate_confidence;
use super::filter_noise::calibrate_filter;
use super::frames::BodyFrames;
use super::loader::BodyBatches;
use super::loss::BODY_VALUES;
use crate::TrainError;
use crate::metric::LoggedValue;
use crate::training::{
    TrainOptions, TrainSummary, TrainingData, TrainingSpan, TrainingTask, check_shape, train,
};

/// A network with initial weights, or the one that the config starts from.
///
/// # Errors
/// If that cannot be read, or is of another shape.
pub fn first_network(config: &BodyConfig, device: &Device) -> Result<MoveEnet, TrainError> {
    let Some(path) = &config.start_from else {
        return Ok(config.network.init(seed_for(config.seed, "weights", 0), device)?);
    };
    let start = BodyCheckpoint::load(path, device)?;
    check_shape(path, start.network.config(), &config.network)?;
    Ok(start.network)
}

/// Trains the network of `config` on `frames`, with some sequences held out for validation. Writes to
/// the directory `run`: `config.toml`, `metrics.jsonl`, `loading.jsonl`, `checkpoint/`, and the networks
/// `best.bpk` and `last.bpk`. With `training.calibrate_confidence`, the best one holds thresholds and a filter of
/// its own.
///
/// # Errors
/// If the directory cannot be used, if it holds another run, or if the loss stops being finite;
/// checkpoints written before stay.
pub fn train_body(
    config: &BodyConfig,
    frames: BodyFrames,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<BodyCheckpoint>, TrainError> {
    let (mean_pose, data) = (frames.mean_pose(), frames.digest());
    let frames = frames.split_for_training(config.data.validation_share)?;
    train_split(config, (mean_pose, data), frames, run, options)
}

/// As [`train_body`] on `frames` alone, validated on `others`: learning curves of people that nothing is
/// trained on. Who evaluates on them takes the last network, since the best one is chosen by them.
///
/// # Errors
/// As [`train_body`].
pub fn train_body_validated_on(
    others: BodyFrames,
    config: &BodyConfig,
    frames: BodyFrames,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<BodyCheckpoint>, TrainError> {
    let (mean_pose, data) = (frames.mean_pose(), frames.digest());
    let frames = BodyFrames::for_training([frames, others])?;
    train_split(config, (mean_pose, data), frames, run, options)
}

fn train_split(
    config: &BodyConfig,
    (mean_pose, digest): (BodyPoints, String),
    frames: [BodyFrames; 2],
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<BodyCheckpoint>, TrainError> {
    let training = &config.training;
    let span = TrainingSpan::from(training);
    let [learnt, valid] = frames.map(Arc::new);
    let task = BodyTask { config, mean_pose, data: digest, valid: &valid };
    let data = TrainingData {
        train: BodyBatches::new(learnt, config),
        valid: BodyBatches::new(Arc::clone(&valid), config),
        // Validation may ask for more than there is.
        validation_samples: training.validation_samples.min(valid.len() as u64),
    };
    train(&task, config, span, data, run, options)
}

struct BodyTask<'a> {
    config: &'a BodyConfig,
    mean_pose: BodyPoints,
    /// Digest of the data.
    data: String,
    /// Images that thresholds and a filter are calibrated on.
    valid: &'a BodyFrames,
}

impl TrainingTask for BodyTask<'_> {
    type Network = MoveEnet;
    type Loss = BodyLoss;
    type Checkpoint = BodyCheckpoint;

    const VALUES: &'static [LoggedValue] = &BODY_VALUES;

    fn untrained(&self, device: &Device) -> Result<MoveEnet, TrainError> {
        Ok(self.config.network.init(0, device)?)
    }

    fn initial_network(&self, device: &Device) -> Result<MoveEnet, TrainError> {
        first_network(self.config, device)
    }

    fn loss(&self) -> BodyLoss {
        BodyLoss::new(self.config.loss, self.config.network.joints)
    }

    fn precision(&self) -> TrainingPrecision {
        self.config.training.precision
    }

    fn optimizer(&self) -> Adam {
        Adam::new(self.config.training.weight_decay)
    }

    fn learning_rate(&self) -> ModuleLrScheduler {
        let training = &self.config.training;
        training.schedule.rate(training.learning_rate, training.steps).into()
    }

    fn early_stop(&self) -> Option<EarlyStop> {
        Some(self.config.training.early_stop)
    }

    fn checkpoint(&self, network: MoveEnet) -> BodyCheckpoint {
        BodyCheckpoint {
            config: self.config.clone(),
            network,
            mean_pose: Some(self.mean_pose),
            data: Some(self.data.clone()),
        }
    }

    fn finish(&self, best: &mut BodyCheckpoint) -> Result<(), TrainError> {
        let training = &self.config.training;
        if training.calibrate_confidence {
            let samples = training.validation_samples as usize;
            calibrate_confidence(best, self.valid, samples)?;
            calibrate_filter(best, self.valid, samples)?;
        }
        Ok(())
    }

    fn save(checkpoint: &BodyCheckpoint, path: &Path) -> Result<(), TrainError> {
        Ok(checkpoint.save(path)?)
    }
}
