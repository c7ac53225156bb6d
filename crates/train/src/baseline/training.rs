//! Training of the baselines.

use std::path::Path;
use std::sync::Arc;

use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_core::seed_for;
use evpose_nn::{Adam, BaselineNetwork, BaselineNetworkConfig};
use evpose_pose::body::BodyPoints;
use evpose_task::Experiment as _;
use evpose_task::baseline::{BaselineCheckpoint, BaselineConfig};
use evpose_task::schedule::EarlyStop;

use super::batches::BaselineBatches;
use super::lift_mono;
use super::loss::{BASELINE_VALUES, BaselineLoss};
use crate::TrainError;
use crate::body::BodyFrames;
use crate::metric::LoggedValue;
use crate::training::{
    TrainOptions, TrainSummary, TrainingData, TrainingSpan, TrainingTask, check_shape, train,
};

/// The images of the recordings in `data` from which the network of `config` learns: for
/// `lift-mono` those of cameras that stand still and are known. `progress` receives 1 after each
/// recording.
///
/// # Errors
/// If files cannot be read, or there is nothing to train on.
pub fn baseline_frames(
    config: &BaselineConfig,
    data: &Path,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BodyFrames, TrainError> {
    let mut frames = BodyFrames::load(&config.body(), data, progress)?;
    if matches!(config.network, BaselineNetworkConfig::LiftMono(_)) {
        frames.frames.retain(|frame| lift_mono::depths(frame).is_some());
        if frames.is_empty() {
            let message =
                "lift-mono learns depths, and no recording here says where its camera stands: \
                 simulate with simulation.moving_cameras = 0, or use a calibrated data set"
                    .to_owned();
            return Err(TrainError::Config { path: data.to_owned(), message });
        }
    }
    Ok(frames)
}

/// Trains the network of `config` on `frames`, those of [`baseline_frames`]. Writes to the
/// directory `run` what [`train_body`](crate::body::train_body) writes.
///
/// # Errors
/// If the directory cannot be used, if it holds another run, or if the loss stops being finite;
/// checkpoints written before stay.
pub fn train_baseline(
    config: &BaselineConfig,
    frames: BodyFrames,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<BaselineCheckpoint>, TrainError> {
    config.validate()?;
    let training = &config.training;
    let span = TrainingSpan::from(training);
    let (torso_m, depths_m) = lift_mono::torso_and_depths_m(&frames).unzip();
    let task = BaselineTask {
        config,
        torso_m,
        depths_m,
        mean_pose: frames.mean_pose(),
        data: frames.digest(),
    };
    let [learnt, valid] = frames.split_for_training(config.data.validation_share)?.map(Arc::new);
    let data = TrainingData {
        validation_samples: training.validation_samples.min(valid.len() as u64),
        train: BaselineBatches::new(learnt, config),
        valid: BaselineBatches::new(valid, config),
    };
    train(&task, config, span, data, run, options)
}

struct BaselineTask<'a> {
    config: &'a BaselineConfig,
    torso_m: Option<f32>,
    depths_m: Option<[f32; 2]>,
    mean_pose: BodyPoints,
    /// Digest of the data.
    data: String,
}

impl TrainingTask for BaselineTask<'_> {
    type Network = BaselineNetwork;
    type Loss = BaselineLoss;
    type Checkpoint = BaselineCheckpoint;

    const VALUES: &'static [LoggedValue] = &BASELINE_VALUES;

    fn untrained(&self, device: &Device) -> Result<BaselineNetwork, TrainError> {
        Ok(self.config.network.init(0, device)?)
    }

    fn initial_network(&self, device: &Device) -> Result<BaselineNetwork, TrainError> {
        let Some(path) = &self.config.start_from else {
            return Ok(self
                .config
                .network
                .init(seed_for(self.config.seed, "weights", 0), device)?);
        };
        let start = BaselineCheckpoint::load(path, device)?;
        check_shape(path, &start.network.config(), &self.config.network)?;
        Ok(start.network)
    }

    fn loss(&self) -> BaselineLoss {
        BaselineLoss { sigma_cells: self.config.loss.sigma_px }
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

    fn checkpoint(&self, network: BaselineNetwork) -> BaselineCheckpoint {
        BaselineCheckpoint {
            config: self.config.clone(),
            network,
            torso_m: self.torso_m,
            depths_m: self.depths_m,
            mean_pose: Some(self.mean_pose),
            data: Some(self.data.clone()),
        }
    }

    fn save(checkpoint: &BaselineCheckpoint, path: &Path) -> Result<(), TrainError> {
        Ok(checkpoint.save(path)?)
    }
}
