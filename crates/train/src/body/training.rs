//! Training of the body network.

use std::path::Path;
use std::sync::Arc;

use burn::optim::AdamConfig;
use burn::optim::decay::WeightDecayConfig;
use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_core::seed_for;
use evpose_nn::{BodyLoss, MoveEnet};
use evpose_pose::body::BodyPoints;
use evpose_task::body::{BodyCheckpoint, BodyConfig};
use evpose_task::schedule::EarlyStop;

use super::confidence::calibrate_confidence;
use super::filter_noise::calibrate_filter;
use super::frames::BodyFrames;
use super::learner::{BODY_FIELDS, BodyLearner, BodyScalars};
use super::loader::{BodyBatches, BodyItem};
use crate::TrainError;
use crate::batch_loader::BatchLoader;
use crate::devices::DeviceGroup;
use crate::guard::Guard;
use crate::metric::Field;
use crate::passes::TrainingSpan;
use crate::training::{
    ADAM_EPSILON, Loaders, Run, TrainOptions, TrainSummary, TrainingTask, check_shape,
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

/// Trains the network of `config` on `frames`, of which it holds back some sequences for validation. Writes to
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
    let task = BodyTask { config, mean_pose: frames.mean_pose(), data: frames.digest() };
    train(&task, frames.split(config.data.validation_share), run, options)
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
    let task = BodyTask { config, mean_pose: frames.mean_pose(), data: frames.digest() };
    train(&task, (frames, others), run, options)
}

fn train(
    task: &BodyTask<'_>,
    (train, valid): (BodyFrames, BodyFrames),
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<BodyCheckpoint>, TrainError> {
    let config = task.config;
    let training = &config.training;
    let devices = DeviceGroup::single(options.device)?;
    let span = TrainingSpan {
        batch_size: training.batch_size,
        steps: training.steps,
        steps_per_interval: training.steps_per_validation,
    };
    let run = Run::open(run, config, span, options)?;
    if train.is_empty() || valid.is_empty() {
        let message = format!(
            "{} images to train on and {} to validate with: more recordings are needed",
            train.len(),
            valid.len()
        );
        return Err(TrainError::Field { field: "data.validation_share", message });
    }
    let device = devices.main().clone();
    let train = BatchLoader::training(
        BodyBatches::new(Arc::new(train), config),
        (run.first_interval(), span),
        device.clone().autodiff(),
        run.meter().clone(),
    );
    let valid = Arc::new(valid);
    // Validation may ask for more than there is.
    let samples = training.validation_samples.min(valid.len() as u64);
    let batches = BodyBatches::new(Arc::clone(&valid), config);
    let loader = BatchLoader::validation(batches, training.batch_size, samples, device);
    let mut summary =
        run.train(task, &devices, Loaders { train: Arc::new(train), valid: Arc::new(loader) })?;
    if training.calibrate_confidence && !summary.is_paused {
        // Of the best network, which is known only now.
        let samples = training.validation_samples as usize;
        calibrate_confidence(&mut summary.best, &valid, samples)?;
        calibrate_filter(&mut summary.best, &valid, samples)?;
        summary.best.save(&summary.path)?;
    }
    Ok(summary)
}

struct BodyTask<'a> {
    config: &'a BodyConfig,
    mean_pose: BodyPoints,
    /// Digest of the data.
    data: String,
}

impl TrainingTask for BodyTask<'_> {
    type Batch = BodyItem;
    type Scalars = BodyScalars;
    type Network = MoveEnet;
    type Learner = BodyLearner;
    type Checkpoint = BodyCheckpoint;

    const FIELDS: &'static [Field<BodyScalars>] = &BODY_FIELDS;

    fn untrained(&self, device: &Device) -> Result<MoveEnet, TrainError> {
        Ok(self.config.network.init(0, device)?)
    }

    fn initial_network(&self, device: &Device) -> Result<MoveEnet, TrainError> {
        first_network(self.config, device)
    }

    fn learner(&self, network: MoveEnet, guard: Guard) -> BodyLearner {
        BodyLearner::new(
            network,
            BodyLoss::new(self.config.loss, self.config.network.joints),
            guard,
        )
    }

    fn network(learner: BodyLearner) -> MoveEnet {
        learner.network
    }

    fn optimizer(&self) -> AdamConfig {
        let decay = self.config.training.weight_decay;
        let decay = (decay > 0.0).then(|| WeightDecayConfig::new(decay));
        AdamConfig::new().with_epsilon(ADAM_EPSILON).with_weight_decay(decay)
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

    fn save(checkpoint: &BodyCheckpoint, path: &Path) -> Result<(), TrainError> {
        Ok(checkpoint.save(path)?)
    }
}
