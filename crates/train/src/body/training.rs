//! A training run of bodies in its directory: started, interrupted, resumed, finished.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use burn::module::Module;
use burn::optim::AdamConfig;
use burn::optim::decay::WeightDecayConfig;
use burn::store::ModuleRecord;
use burn::tensor::Device;
use burn_train::metric::store::EventStoreClient;
use burn_train::{EarlyStoppingStrategy, Interrupter, Learner, SupervisedTraining};
use evpose_core::seed_for;
use evpose_nn::{BodyLoss, MoveEnet};
use sha2::{Digest, Sha256};

use super::frames::BodyFrames;
use super::loader::BodyLoader;
use super::task::{BODY_FIELDS, BodyLearner};
use crate::TrainError;
use crate::checkpoint::{AtomicCheckpointer, newest_checkpoint, weights_path};
use crate::guard::Guard;
use crate::history::History;
use crate::metric::FieldMetric;
use crate::progress_renderer::TrainingSpan;
use crate::retention::{LastTwoAndBest, best_interval};
use crate::training::{ADAM_EPSILON, RunDir, TrainOptions, renderer, settled};
use crate::waiting::{DataWait, WaitMeter};
use evpose_task::body::BodyCheckpoint;
use evpose_task::body::BodyConfig;
use evpose_task::body::{EarlyStop, ScheduledRate};
use evpose_task::hand::{BEST, LAST};

/// What a run came to.
#[derive(Debug)]
pub struct BodyTrainSummary {
    /// The network of the best validation, with what it was trained on.
    pub best: BodyCheckpoint,
    /// Its file.
    pub path: PathBuf,
    /// Images seen by this process in training.
    pub samples: u64,
    /// Those per second, validation included.
    pub samples_per_second: f64,
    /// Time this process trained.
    pub elapsed: std::time::Duration,
    /// How much of it, validation left out, was waiting for images.
    pub data_wait: DataWait,
    /// Whether it ended before all of its steps, since the loss had stopped falling.
    pub ended_early: bool,
}

/// A freshly initialised network, or the one that the config starts from.
///
/// # Errors
/// If that cannot be read, or is of another shape.
pub fn first_network(config: &BodyConfig, device: &Device) -> Result<MoveEnet, TrainError> {
    let Some(path) = &config.start_from else {
        return Ok(config.network.init(seed_for(config.seed, "weights", 0), device)?);
    };
    let found = BodyCheckpoint::load(path, device)?;
    if *found.network.config() != config.network {
        let message = format!(
            "holds a network of {:?}, and [network] says {:?}",
            found.network.config(),
            config.network
        );
        return Err(TrainError::Config { path: path.clone(), message });
    }
    Ok(found.network)
}

/// Trains the network of `config` on `frames` and leaves everything in `run`: `config.toml`,
/// `metrics.jsonl`, `loading.jsonl`, `checkpoint/`, and the networks `best.bpk` and `last.bpk`.
///
/// # Errors
/// If the directory cannot be used, if it holds another run, or if the loss stops being a number;
/// checkpoints written before stay.
pub fn train_body(
    config: &BodyConfig,
    frames: BodyFrames,
    run: &Path,
    options: &TrainOptions,
) -> Result<BodyTrainSummary, TrainError> {
    let main = options.device.resolve()?;
    let dir = RunDir(run);
    let from = prepare(config, &dir, options.resume)?;
    let training = &config.training;
    let intervals = training.steps.div_ceil(training.steps_per_validation) as usize;
    let digest = digest_of(&frames);
    let mean_pose = frames.mean_pose();
    let (train, valid) = frames.split(config.data.validation_share);
    if train.is_empty() || valid.is_empty() {
        let message = format!(
            "{} images to train on and {} to validate with: more recordings are needed",
            train.len(),
            valid.len()
        );
        return Err(TrainError::Field { field: "data.validation_share", message });
    }

    let device = main.clone().autodiff();
    let interrupter = Interrupter::new();
    let meter = WaitMeter::resume(&dir.loading(), from)?;
    let loader =
        BodyLoader::training(Arc::new(train), config, from + 1, device.clone(), meter.clone());
    let validation = BodyLoader::validation(Arc::new(valid), config, main.clone());
    let history = History::resume(&dir.history(), from)?;
    let guard = Guard::new(interrupter.clone());
    let rate = ScheduledRate {
        schedule: training.schedule.clone(),
        learning_rate: training.learning_rate,
        steps: training.steps,
        next: 0,
    };
    let decay =
        (training.weight_decay > 0.0).then(|| WeightDecayConfig::new(training.weight_decay));
    let learner = Learner::new(
        BodyLearner::new(
            first_network(config, &device)?,
            BodyLoss::new(config.loss, config.network.joints),
            guard.clone(),
        ),
        AdamConfig::new().with_epsilon(ADAM_EPSILON).with_weight_decay(decay).init(),
        rate,
    );
    let span = TrainingSpan {
        batch_size: training.batch_size,
        steps: training.steps,
        steps_per_interval: training.steps_per_validation,
    };
    let [weights, optimizer, schedule] = AtomicCheckpointer::parts(&dir.checkpoints());
    let mut supervised = SupervisedTraining::new(run, Arc::new(loader), Arc::new(validation))
        .num_epochs(intervals)
        .with_interrupter(interrupter.clone())
        .with_metric_logger(history.clone())
        .with_checkpointing_strategy(LastTwoAndBest::new(history.clone()))
        .with_custom_checkpointers(weights, optimizer, schedule)
        .with_application_logger(None)
        .early_stopping(StopsFalling { rule: training.early_stop, history: history.clone() })
        .renderer(renderer(&interrupter, options, span, &meter));
    for field in BODY_FIELDS {
        supervised = supervised
            .metric_train_numeric(FieldMetric::new(field))
            .metric_valid_numeric(FieldMetric::new(field));
    }
    if from > 0 {
        supervised = supervised.checkpoint(from);
    }

    let started = Instant::now();
    let result = supervised.launch(learner);
    let elapsed = started.elapsed();
    drop(result.renderer);
    history.flush()?;
    let interruption = result.interrupted.map(|interruption| interruption.reason);
    settled(&dir, &guard, result.error.map(|error| error.to_string()), interruption)?;

    let losses = history.validation_losses();
    let mut saved = BodyCheckpoint {
        config: config.clone(),
        network: result.model.network,
        mean_pose: Some(mean_pose),
        data: Some(digest),
    };
    saved.save(&run.join(LAST))?;
    if let Some(best) = best_interval(&losses) {
        saved.network = restore(config, &weights_path(&dir.checkpoints(), best), &main)?;
    }
    saved.save(&run.join(BEST))?;
    let done = losses.keys().last().copied().unwrap_or(intervals);
    let steps =
        |interval: usize| (interval as u64 * training.steps_per_validation).min(training.steps);
    let samples = (steps(done) - steps(from.min(done))) * training.batch_size as u64;
    Ok(BodyTrainSummary {
        best: saved,
        path: run.join(BEST),
        samples_per_second: samples as f64 / elapsed.as_secs_f64(),
        samples,
        elapsed,
        data_wait: meter.total()?,
        ended_early: done < intervals,
    })
}

/// Ends a training as its rule says.
#[derive(Clone)]
struct StopsFalling {
    rule: EarlyStop,
    history: History,
}

impl EarlyStoppingStrategy for StopsFalling {
    fn should_stop(&mut self, interval: usize, _: &EventStoreClient) -> bool {
        self.rule.ends(&self.history.validation_losses(), interval)
    }
}

/// A digest of all images and labels.
fn digest_of(frames: &BodyFrames) -> String {
    let mut hash = Sha256::new();
    for frame in &frames.frames {
        hash.update(frame.image.data());
        for keypoint in &frame.label.keypoints {
            hash.update(keypoint.position.x.to_le_bytes());
            hash.update(keypoint.position.y.to_le_bytes());
        }
    }
    let bytes = hash.finalize();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Makes the directory ready and tells which validation interval to continue after, 0 for none.
fn prepare(config: &BodyConfig, dir: &RunDir<'_>, resume: bool) -> Result<usize, TrainError> {
    let newest = newest_checkpoint(&dir.checkpoints())?;
    if resume && dir.config().exists() {
        let fields = config.differences(&BodyConfig::read(&dir.config())?)?;
        if !fields.is_empty() {
            return Err(TrainError::ConfigDiffers { path: dir.config(), fields });
        }
    } else if newest.is_some() {
        let message =
            "it already holds checkpoints; add --resume, or choose another --out".to_owned();
        return Err(TrainError::Resume { path: dir.0.to_path_buf(), message });
    }
    fs::create_dir_all(dir.checkpoints())
        .map_err(|source| TrainError::Io { path: dir.checkpoints(), source })?;
    evpose_core::atomic_write(dir.config(), config.to_toml()?.as_bytes())
        .map_err(|source| TrainError::Io { path: dir.config(), source })?;
    Ok(if resume { newest.unwrap_or(0) } else { 0 })
}

/// The network of a training checkpoint.
fn restore(config: &BodyConfig, path: &Path, device: &Device) -> Result<MoveEnet, TrainError> {
    let guard = Guard::new(Interrupter::new());
    let network = config.network.init(0, device)?;
    let learner =
        BodyLearner::new(network, BodyLoss::new(config.loss, config.network.joints), guard);
    let record = ModuleRecord::load(path)
        .map_err(|error| TrainError::Stopped(format!("{}: {error}", path.display())))?;
    Ok(learner.load_record(record).network)
}
