//! A training run of any task in its directory: started, interrupted, resumed, finished.
//!
//! * [`TrainingTask`], [`TrainingLoss`]: what a task brings: network, loss, optimiser, checkpoint.
//! * [`BatchSource`]: its samples as batches, in the order of [`SampleOrder`].
//! * [`PlaneNetwork`], [`PlaneSamples`], [`MeanSquareError`]: both, of networks from planes to values.
//! * [`train`]: the run. It shuffles, optimises, validates, logs and writes checkpoints; a run that was
//!   interrupted goes on with `resume` and ends with the same bytes.
//! * [`mixed`]: number formats of convolutions.
//!
//! `examples/task` trains a network of its own with them.

mod directory;
mod learner;
mod lock;
pub mod mixed;
mod planes;
mod task;

use std::io::stdout;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use burn::module::Module as _;
use burn::store::ModuleRecord;
use burn::tensor::Device;
use burn_train::metric::store::EventStoreClient;
use burn_train::renderer::MetricsRenderer;
use burn_train::{EarlyStoppingStrategy, Interrupter, SupervisedTraining};
use evpose_nn::DeviceKind;
use evpose_nn::weights::read_checked;
use evpose_task::schedule::EarlyStop;
use evpose_task::{BEST, Experiment, LAST};

use crate::TrainError;
use crate::batch_loader::BatchLoader;
use crate::checkpoint::{AtomicCheckpointer, newest_checkpoint, weights_path};
use crate::devices::DeviceGroup;
use crate::guard::{Divergence, Guard};
use crate::history::History;
use crate::metric::ValueMetric;
use crate::plain_renderer::PlainRenderer;
use crate::progress_renderer::{ProgressCallback, ProgressRenderer};
use crate::retention::{LastTwoAndBest, best_interval};
use crate::waiting::{DataWait, WaitMeter};
use directory::RunDirectory;
use learner::Learner;
use lock::RunLock;
use task::BatchOf;

pub use crate::batch_loader::BatchSource;
pub use crate::metric::BatchValues;
pub use crate::order::SampleOrder;
pub use crate::passes::{Passes, TrainingSpan};
pub(crate) use learner::StepBatch;
pub use learner::TrainingLoss;
pub use planes::{MeanSquareError, PlaneBatch, PlaneNetwork, PlaneSamples};
pub use task::TrainingTask;

/// Whether the network in the file `path`, which a training starts from, is of the shape of the
/// config.
///
/// # Errors
/// If it is not.
pub(crate) fn check_shape<C: PartialEq + std::fmt::Debug>(
    path: &Path,
    network: &C,
    config: &C,
) -> Result<(), TrainError> {
    if network == config {
        return Ok(());
    }
    let message = format!("holds a network of {network:?}, and [network] says {config:?}");
    Err(TrainError::Config { path: path.to_path_buf(), message })
}

/// The options of a run that do not change its result.
#[derive(Debug, Clone)]
pub struct TrainOptions {
    /// The kind of device; the config says how many of them.
    pub device: DeviceKind,
    /// Continue from the newest complete checkpoint of the directory.
    pub resume: bool,
    /// Plain lines even on a terminal.
    pub plain: bool,
    /// Receives the progress, in place of lines and dashboard.
    pub progress: Option<ProgressCallback>,
    /// Pause after this many optimiser steps, rounded up to the next validation, so that the same
    /// run can go on from there with `resume`; none trains to the end. The learning rate is that of
    /// the whole run: a run that was paused ends with the weights of one that was not.
    pub pause_after: Option<u64>,
}

impl TrainOptions {
    /// A new run to its end, in plain lines.
    pub fn new(device: DeviceKind) -> Self {
        Self { device, resume: false, plain: true, progress: None, pause_after: None }
    }
}

/// The result of a run that came to its end, or to its pause.
#[derive(Debug)]
pub struct TrainSummary<C> {
    /// The network of the best validation, with the experiment it came from.
    pub best: C,
    /// Its file; that of a checkpoint while the run is paused.
    pub path: PathBuf,
    /// Training samples of this process.
    pub samples: u64,
    /// Those per second, validation included.
    pub samples_per_second: f64,
    /// Time for which this process trained.
    pub elapsed: Duration,
    /// The part of it, validation left out, in which the network waited for data.
    pub data_wait: DataWait,
    /// Whether it ended before all of its steps, because the validation loss had stopped falling.
    pub ended_early: bool,
    /// Whether it paused at [`TrainOptions::pause_after`] and steps are left.
    pub is_paused: bool,
}

/// The samples of a training.
#[derive(Debug, Clone)]
pub struct TrainingData<S> {
    /// Those that it learns from.
    pub train: S,
    /// Those that it is validated with.
    pub valid: S,
    /// How many of the latter are seen at each validation, spread evenly over them.
    pub validation_samples: u64,
}

/// Trains `task`, the one of `config`, on one device. Writes to the directory `run`: `config.toml`,
/// `metrics.jsonl`, `loading.jsonl` (the time it waited for data), `checkpoint/`, and the networks
/// `best.bpk` and `last.bpk`.
///
/// # Errors
/// If the directory cannot be used, if it holds another run, or if the loss stops being finite;
/// checkpoints written before stay.
pub fn train<T, S>(
    task: &T,
    config: &impl Experiment,
    span: TrainingSpan,
    data: TrainingData<S>,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<T::Checkpoint>, TrainError>
where
    T: TrainingTask,
    S: BatchSource<Item = BatchOf<T>>,
{
    let devices = DeviceGroup::single(options.device)?;
    Run::open(run, config, span, options)?.train(task, &devices, data)
}

/// A run whose directory is ready.
pub(crate) struct Run<'a> {
    directory: RunDirectory<'a>,
    /// The validation interval of the checkpoint that is continued, 0 for none.
    resumed: usize,
    span: TrainingSpan,
    options: &'a TrainOptions,
    interrupter: Interrupter,
    meter: WaitMeter,
    /// Until the best network is written.
    _lock: RunLock,
}

impl<'a> Run<'a> {
    /// Prepares the directory `path` for a training of `config`.
    ///
    /// # Errors
    /// If it cannot be written, holds another run, or another process trains there.
    pub(crate) fn open(
        path: &'a Path,
        config: &impl Experiment,
        span: TrainingSpan,
        options: &'a TrainOptions,
    ) -> Result<Self, TrainError> {
        let directory = RunDirectory(path);
        let (_lock, resumed) = directory.prepare(config, options.resume)?;
        let meter = WaitMeter::resume(&directory.loading(), resumed)?;
        let interrupter = Interrupter::new();
        Ok(Self { directory, resumed, span, options, interrupter, meter, _lock })
    }

    /// Trains to the end, and writes the last and the best network; or to the pause, which leaves
    /// checkpoints alone.
    ///
    /// # Errors
    /// If a batch or a file cannot be read or written, if the loss stops being finite, or if the
    /// run is interrupted; checkpoints written before stay.
    pub(crate) fn train<T, S>(
        self,
        task: &T,
        devices: &DeviceGroup,
        data: TrainingData<S>,
    ) -> Result<TrainSummary<T::Checkpoint>, TrainError>
    where
        T: TrainingTask,
        S: BatchSource<Item = BatchOf<T>>,
    {
        let history = History::resume(&self.directory.history(), self.resumed)?;
        self.directory.leave_out_lost_networks(&history)?;
        let guard = Guard::new(self.interrupter.clone());
        let precision = task.precision();
        mixed::check(precision, devices.main())?;
        let network = task.initial_network(&devices.main().clone().autodiff())?;
        let learner = burn_train::Learner::new(
            Learner::new(network, task.loss(), precision, guard.clone()),
            task.optimizer().into(),
            task.learning_rate(),
        );
        let supervised = self.supervised(task, devices, data, &history);

        // The rate is that of training alone: preparation does not count.
        let started = Instant::now();
        let result = supervised.launch(learner);
        let elapsed = started.elapsed();
        // A dashboard gives the terminal back when it is dropped, before anything is printed.
        drop(result.renderer);
        // Also after a fault: a resumed run needs the lines of its checkpoints.
        history.flush()?;
        let interruption = result.interrupted.map(|interruption| interruption.reason);
        self.check_end(&guard, result.error.map(|error| error.to_string()), interruption)?;

        let losses = history.validation_losses();
        let intervals = self.span.intervals();
        let done = losses.keys().last().copied().unwrap_or(intervals);
        let is_over = task.early_stop().is_some_and(|rule| rule.ends(&losses, done));
        let is_paused = done < intervals && done >= self.last_interval() && !is_over;
        let best_interval = best_interval(&history.losses_of_networks());
        let mut path = self.directory.0.join(BEST);
        let last = task.checkpoint(result.model.network);
        if is_paused {
            path = weights_path(&self.directory.checkpoints(), best_interval.unwrap_or(done));
        } else {
            T::save(&last, &self.directory.0.join(LAST))?;
        }
        // In memory there is the last network alone.
        let mut best = match best_interval {
            Some(best) => task.checkpoint(self.restore(task, best, devices.main())?),
            None => last,
        };
        if !is_paused {
            task.finish(&mut best)?;
            // The last file of all: where it is, the training has ended.
            T::save(&best, &path)?;
        }
        // A resumed run did not compute the steps before its checkpoint.
        let steps = self.span.steps_by(done) - self.span.steps_by(self.resumed.min(done));
        let samples = steps * self.span.batch_size as u64;
        Ok(TrainSummary {
            best,
            path,
            samples,
            samples_per_second: samples as f64 / elapsed.as_secs_f64(),
            elapsed,
            data_wait: self.meter.total()?,
            ended_early: done < intervals && !is_paused,
            is_paused,
        })
    }

    /// The validation interval that the run ends or pauses after.
    fn last_interval(&self) -> usize {
        let intervals = self.span.intervals();
        let pause = |steps: u64| steps.div_ceil(self.span.steps_per_validation).max(1) as usize;
        self.options.pause_after.map_or(intervals, |steps| pause(steps).min(intervals))
    }

    fn supervised<T, S>(
        &self,
        task: &T,
        devices: &DeviceGroup,
        TrainingData { train, valid, validation_samples }: TrainingData<S>,
        history: &History,
    ) -> SupervisedTraining<Learner<T::Network, T::Loss>>
    where
        T: TrainingTask,
        S: BatchSource<Item = BatchOf<T>>,
    {
        let (from, device) = ((self.resumed + 1, self.span), devices.main().clone());
        let (autodiff, meter) = (device.clone().autodiff(), self.meter.clone());
        let train = BatchLoader::training(train, from, autodiff, meter);
        // Each device takes its part of every batch.
        let train = devices.share(train, &self.interrupter);
        let size = self.span.batch_size;
        // Validation needs no gradients: its device is the one without autodiff.
        let valid = BatchLoader::validation(valid, size, validation_samples, device);
        let [weights, optimizer, schedule] =
            AtomicCheckpointer::parts(&self.directory.checkpoints());
        let mut supervised =
            SupervisedTraining::new(self.directory.0, Arc::new(train), Arc::new(valid))
                .num_epochs(self.last_interval())
                .with_interrupter(self.interrupter.clone())
                .with_metric_logger(history.clone())
                .with_checkpointing_strategy(LastTwoAndBest(history.clone()))
                .with_custom_checkpointers(weights, optimizer, schedule)
                .with_application_logger(None)
                .renderer(self.renderer());
        for metric in T::VALUES.iter().enumerate().map(ValueMetric::new) {
            supervised =
                supervised.metric_train_numeric(metric.clone()).metric_valid_numeric(metric);
        }
        if let Some(rule) = task.early_stop() {
            supervised = supervised.early_stopping(EndsEarly { rule, history: history.clone() });
        }
        if let Some(strategy) = devices.strategy() {
            supervised = supervised.with_training_strategy(strategy);
        }
        if self.resumed > 0 {
            supervised = supervised.checkpoint(self.resumed);
        }
        supervised
    }

    /// The progress callback if there is one, else Burn's dashboard on a terminal and plain lines
    /// elsewhere.
    fn renderer(&self) -> Box<dyn MetricsRenderer> {
        #[cfg(feature = "tui")]
        use std::io::IsTerminal as _;
        if let Some(callback) = &self.options.progress {
            // For the caller, a run that pauses is complete at the pause.
            let steps = self.span.steps_by(self.last_interval());
            let span = TrainingSpan { steps, ..self.span };
            return Box::new(ProgressRenderer::new(callback.clone(), span));
        }
        #[cfg(feature = "tui")]
        if !self.options.plain && stdout().is_terminal() {
            return Box::new(crate::dashboard::Dashboard::new(self.interrupter.clone()));
        }
        Box::new(PlainRenderer::new(stdout(), self.meter.clone()))
    }

    /// # Errors
    /// The reason why the training did not come to its end, if it did not.
    fn check_end(
        &self,
        guard: &Guard,
        error: Option<String>,
        interruption: Option<Option<String>>,
    ) -> Result<(), TrainError> {
        // The guard interrupts the training: its reason comes first.
        if let Some(Divergence { loss, step, is_validation }) = guard.divergence() {
            let checkpoints = self.directory.checkpoints();
            let newest = newest_checkpoint(&checkpoints)?;
            let checkpoint = newest.map(|interval| weights_path(&checkpoints, interval));
            return Err(TrainError::Diverged { loss, step, is_validation, checkpoint });
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

    /// The network of the checkpoint of validation interval `interval`.
    fn restore<T: TrainingTask>(
        &self,
        task: &T,
        interval: usize,
        device: &Device,
    ) -> Result<T::Network, TrainError> {
        // Nothing is trained with this guard, and it must not stop the training that asks.
        let guard = Guard::new(Interrupter::new());
        let learner = Learner::new(task.untrained(device)?, task.loss(), task.precision(), guard);
        let path = weights_path(&self.directory.checkpoints(), interval);
        let record = ModuleRecord::from_bytes(read_checked(&path)?)
            .map_err(|error| TrainError::Stopped(format!("{}: {error}", path.display())))?;
        Ok(learner.load_record(record).network)
    }
}

/// Ends a training by the rule of its config.
#[derive(Clone)]
struct EndsEarly {
    rule: EarlyStop,
    history: History,
}

impl EarlyStoppingStrategy for EndsEarly {
    fn should_stop(&mut self, interval: usize, _: &EventStoreClient) -> bool {
        self.rule.ends(&self.history.validation_losses(), interval)
    }
}
