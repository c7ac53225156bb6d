//! A training run in its directory: started, interrupted, resumed, finished.

use std::fs;
use std::io::stdout;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use burn::module::Module;
use burn::optim::AdamConfig;
use burn::store::ModuleRecord;
use burn::tensor::Device;
use burn_train::renderer::{MetricsRenderer, default_renderer};
use burn_train::{Interrupter, Learner, SupervisedTraining};
use evpose_core::seed_for;
use evpose_nn::{DeviceKind, HandLoss, HandRegressor};
use evpose_pose::HandParams;
use evpose_pose::metric::MeanPose;

use crate::TrainError;
use crate::checkpoint::{AtomicCheckpointer, newest_checkpoint, weights_path};
use crate::dataset::HandDataset;
use crate::devices::DeviceGroup;
use crate::guard::{Divergence, Guard};
use crate::hand_task::{HAND_FIELDS, HandLearner};
use crate::history::History;
use crate::loader::HandLoader;
use crate::metric::FieldMetric;
use crate::plain_renderer::PlainRenderer;
use crate::progress_renderer::{ProgressCallback, ProgressRenderer, TrainingSpan};
use crate::retention::{LastTwoAndBest, best_interval};
use crate::waiting::{DataWait, WaitMeter};
use evpose_task::hand::HandConfig;
use evpose_task::hand::{BEST, HandCheckpoint, LAST};

/// PyTorch's default; Burn's is 1e-5.
pub(crate) const ADAM_EPSILON: f32 = 1e-8;

/// Poses averaged for the mean pose, at most; spread evenly over the training data.
const MEAN_POSE_SAMPLES: u64 = 200_000;

/// How to run, as opposed to what.
#[derive(Debug, Clone)]
pub struct TrainOptions {
    /// What to compute on; the config says on how many of them.
    pub device: DeviceKind,
    /// Continue from the newest complete checkpoint of the directory.
    pub resume: bool,
    /// Plain lines even on a terminal.
    pub plain: bool,
    /// Receives the progress, in place of lines and dashboard.
    pub progress: Option<ProgressCallback>,
}

/// What a run came to.
#[derive(Debug)]
pub struct TrainSummary {
    /// The network of the best validation, with what it was trained on.
    pub best: HandCheckpoint,
    /// Its file.
    pub path: PathBuf,
    /// Training windows seen by this process per second, validation included.
    pub samples_per_second: f64,
    /// Training windows seen by this process.
    pub samples: u64,
    /// Time this process trained.
    pub elapsed: Duration,
    /// How much of it, validation left out, was waiting for windows.
    pub data_wait: DataWait,
}

/// Where a run keeps its things.
pub(crate) struct RunDir<'a>(pub(crate) &'a Path);

impl RunDir<'_> {
    pub(crate) fn config(&self) -> PathBuf {
        self.0.join("config.toml")
    }
    pub(crate) fn history(&self) -> PathBuf {
        self.0.join("metrics.jsonl")
    }
    pub(crate) fn loading(&self) -> PathBuf {
        self.0.join("loading.jsonl")
    }
    pub(crate) fn checkpoints(&self) -> PathBuf {
        self.0.join("checkpoint")
    }
}

/// A freshly initialised network; the seed decides every weight.
pub fn untrained(config: &HandConfig, device: &Device) -> Result<HandRegressor, TrainError> {
    let seed = seed_for(config.seed, "weights", 0);
    Ok(config.network.init(seed, device)?)
}

/// Trains the hand network of `config` on the sequences in `data` and leaves everything in `run`:
/// `config.toml`, `metrics.jsonl`, `loading.jsonl` (how long it waited for data), `checkpoint/`, and
/// the networks `best.bpk` and `last.bpk`.
///
/// # Errors
/// If the data or the directory cannot be used, if `run` holds another run, or if the loss stops
/// being a number; checkpoints written before stay.
pub fn train_hand(
    config: &HandConfig,
    data: &Path,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary, TrainError> {
    let devices = DeviceGroup::new(options.device, &config.training)?;
    let dir = RunDir(run);
    let from = prepare(config, &dir, options.resume)?;
    let training = &config.training;
    let intervals = training.steps.div_ceil(training.steps_per_validation) as usize;

    let (train, valid) = HandDataset::open(data, config)?.split(training.validation_s, config)?;
    let mean_pose = mean_pose(&train)?;
    let device = devices.main().clone().autodiff();
    let interrupter = Interrupter::new();
    let span = (from + 1, training.steps, training.steps_per_validation);
    let meter = WaitMeter::resume(&dir.loading(), from)?;
    let loader = HandLoader::training(Arc::new(train), training.batch_size, span, device.clone());
    let loader = devices.share(loader.metered(meter.clone()), &interrupter);
    let validation = HandLoader::validation(
        Arc::new(valid),
        training.batch_size,
        training.validation_samples,
        devices.main().clone(),
    );

    let history = History::resume(&dir.history(), from)?;
    let guard = Guard::new(interrupter.clone());
    let network = untrained(config, &device)?;
    let learner = Learner::new(
        HandLearner::new(network, HandLoss::new(config.loss), guard.clone()),
        AdamConfig::new().with_epsilon(ADAM_EPSILON).init(),
        training.learning_rate,
    );

    let telling = TrainingSpan {
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
        .renderer(renderer(&interrupter, options, telling, &meter));
    for field in HAND_FIELDS {
        supervised = supervised
            .metric_train_numeric(FieldMetric::new(field))
            .metric_valid_numeric(FieldMetric::new(field));
    }
    if let Some(strategy) = devices.strategy() {
        supervised = supervised.with_training_strategy(strategy);
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

    let mut last = HandCheckpoint {
        config: config.clone(),
        network: result.model.network,
        mean_pose: Some(mean_pose),
    };
    last.save(&run.join(LAST))?;
    if let Some(best) = best_interval(&history.validation_losses()) {
        last.network = restore(config, &weights_path(&dir.checkpoints(), best), devices.main())?;
    }
    last.save(&run.join(BEST))?;
    let already = (from as u64 * training.steps_per_validation).min(training.steps);
    let samples = (training.steps - already) * training.batch_size as u64;
    Ok(TrainSummary {
        best: last,
        path: run.join(BEST),
        samples_per_second: samples as f64 / elapsed.as_secs_f64(),
        samples,
        elapsed,
        data_wait: meter.total()?,
    })
}

/// The mean of the training poses: the predictor to beat.
fn mean_pose(train: &HandDataset) -> Result<HandParams, TrainError> {
    let mut mean = MeanPose::default();
    train.poses(MEAN_POSE_SAMPLES)?.iter().for_each(|pose| mean.push(pose));
    mean.mean().ok_or_else(|| TrainError::Stopped("the training poses have no mean".to_owned()))
}

/// Whether a training came to its end, or what stopped it.
pub(crate) fn settled(
    dir: &RunDir<'_>,
    guard: &Guard,
    error: Option<String>,
    interruption: Option<Option<String>>,
) -> Result<(), TrainError> {
    if let Some(divergence) = guard.divergence() {
        let newest = newest_checkpoint(&dir.checkpoints())?;
        let checkpoint = newest.map(|interval| weights_path(&dir.checkpoints(), interval));
        let Divergence { loss, step } = divergence;
        return Err(TrainError::Diverged { loss, step, checkpoint });
    }
    if let Some(error) = error {
        return Err(TrainError::Stopped(error));
    }
    match interruption {
        None => Ok(()),
        Some(reason) => Err(TrainError::Stopped(format!(
            "{}; continue with --resume from the last checkpoint",
            reason.unwrap_or_else(|| "interrupted".to_owned())
        ))),
    }
}

/// Makes the directory ready and tells which validation interval to continue after, 0 for none.
fn prepare(config: &HandConfig, dir: &RunDir<'_>, resume: bool) -> Result<usize, TrainError> {
    let refuse = |message: &str| {
        Err(TrainError::Resume { path: dir.0.to_path_buf(), message: message.to_owned() })
    };
    let newest = newest_checkpoint(&dir.checkpoints())?;
    if resume && dir.config().exists() {
        let fields = config.differences(&HandConfig::read(&dir.config())?)?;
        if !fields.is_empty() {
            return Err(TrainError::ConfigDiffers { path: dir.config(), fields });
        }
    } else if newest.is_some() {
        return refuse("it already holds checkpoints; add --resume, or choose another --out");
    }
    fs::create_dir_all(dir.checkpoints())
        .map_err(|source| TrainError::Io { path: dir.checkpoints(), source })?;
    evpose_core::atomic_write(dir.config(), config.to_toml()?.as_bytes())
        .map_err(|source| TrainError::Io { path: dir.config(), source })?;
    Ok(if resume { newest.unwrap_or(0) } else { 0 })
}

/// The progress callback if there is one, else Burn's dashboard on a terminal and plain lines
/// elsewhere.
pub(crate) fn renderer(
    interrupter: &Interrupter,
    options: &TrainOptions,
    span: TrainingSpan,
    meter: &WaitMeter,
) -> Box<dyn MetricsRenderer> {
    use std::io::IsTerminal as _;
    if let Some(callback) = &options.progress {
        return Box::new(ProgressRenderer::new(callback.clone(), span));
    }
    if !options.plain && cfg!(feature = "tui") && stdout().is_terminal() {
        default_renderer(interrupter.clone(), None)
    } else {
        Box::new(PlainRenderer::new(stdout(), meter.clone()))
    }
}

/// The network of a training checkpoint.
fn restore(config: &HandConfig, path: &Path, device: &Device) -> Result<HandRegressor, TrainError> {
    let guard = Guard::new(Interrupter::new());
    let learner = HandLearner::new(untrained(config, device)?, HandLoss::new(config.loss), guard);
    let record = ModuleRecord::load(path)
        .map_err(|error| TrainError::Stopped(format!("{}: {error}", path.display())))?;
    Ok(learner.load_record(record).network)
}
