//! Training of the hand network.

use std::path::Path;
use std::sync::Arc;

use burn::optim::lr_scheduler::module_lr_scheduler::ModuleLrScheduler;
use burn::tensor::Device;
use evpose_core::seed_for;
use evpose_nn::{HandHead, HandLoss, HandNetwork, HandRegressor};
use evpose_pose::HandParams;
use evpose_pose::metric::MeanPose;
use evpose_task::hand::{HandCheckpoint, HandConfig, HandView};
use evpose_task::schedule::TrainingPrecision;

use crate::TrainError;
use crate::devices::DeviceGroup;
use crate::hand::batches::HandBatches;
use crate::hand::dataset::{HandDataset, HandSplit};
use crate::hand::filter_noise::estimate_filters;
use crate::hand::joints::{JointBatches, JointTask};
use crate::hand::loss::HAND_VALUES;
use crate::metric::LoggedValue;
use crate::training::{
    Run, TrainOptions, TrainSummary, TrainingData, TrainingSpan, TrainingTask, check_shape,
};

/// Poses averaged for the mean pose, at most; spread evenly over the training data.
const MEAN_POSE_SAMPLES: u64 = 200_000;

/// A network of `config` with initial weights; the seed decides every one of them.
///
/// # Errors
/// If the config names no known network.
pub fn untrained(config: &HandConfig, device: &Device) -> Result<HandNetwork, TrainError> {
    Ok(HandNetwork::init(&config.network, seed_for(config.seed, "weights", 0), device)?)
}

/// The regressor that a training of `config` begins with: with initial weights, or the one that it
/// starts from.
///
/// # Errors
/// If that cannot be read, or is of another shape.
fn first_network(config: &HandConfig, device: &Device) -> Result<HandRegressor, TrainError> {
    let network = match &config.start_from {
        None => untrained(config, device)?,
        Some(path) => {
            let network = HandCheckpoint::load(path, device)?.network;
            check_shape(path, &network.config(), &config.network)?;
            network
        }
    };
    let regressor = network.into_regressor();
    Ok(regressor.unwrap_or_else(|| unreachable!("networks of joints have a task of their own")))
}

/// Trains the hand network of `config` on the sequences in `data`. Writes to the directory `run`:
/// `config.toml`, `metrics.jsonl`, `loading.jsonl` (the time it waited for data), `checkpoint/`,
/// and the networks `best.bpk` and `last.bpk`. With `training.estimate_filter`, the best one holds
/// filters of its own.
///
/// # Errors
/// If the data or the directory cannot be used, if `run` holds another run, or if the loss stops
/// being finite; checkpoints written before stay.
pub fn train_hand(
    config: &HandConfig,
    data: &Path,
    run: &Path,
    options: &TrainOptions,
) -> Result<TrainSummary<HandCheckpoint>, TrainError> {
    let training = &config.training;
    let devices = DeviceGroup::new(options.device, training)?;
    let span = TrainingSpan::from(training);
    // Before the data, which take long to read: a directory that cannot be used is refused at once.
    let run = Run::open(run, config, span, options)?;
    let HandSplit { train, valid, filter } = HandDataset::open(data, config)?.split(config)?;
    let (mean_pose, device) = (mean_pose(&train)?, devices.main());
    let task = HandTask { config, mean_pose, unseen: &filter, device };
    let [train, valid] = [train, valid].map(Arc::new);
    let validation_samples = training.validation_samples.min(valid.len());
    match config.network.head {
        HandHead::Regressor => {
            let [train, valid] = [train, valid].map(HandBatches);
            run.train(&task, &devices, TrainingData { train, valid, validation_samples })
        }
        HandHead::Joints => {
            let [train, valid] = [train, valid].map(JointBatches);
            let data = TrainingData { train, valid, validation_samples };
            run.train(&JointTask(task), &devices, data)
        }
    }
}

/// Puts filters into a checkpoint whose noise is that of its network on sequences it has not seen.
fn estimate_filter(
    checkpoint: &mut HandCheckpoint,
    unseen: &HandDataset,
    device: &Device,
) -> Result<(), TrainError> {
    let mut predictor = checkpoint.predictor(device.clone())?;
    let tracks = unseen.measured_tracks(&checkpoint.config, &mut predictor)?;
    let view = HandView::new(&checkpoint.config)?;
    let side = checkpoint.config.simulation.hands.side(0);
    if let Some(estimate) = estimate_filters(&view, side, &tracks)? {
        checkpoint.config.filter = estimate.plain;
        checkpoint.config.slow_motion.filter = estimate.adaptive;
    }
    Ok(())
}

/// The mean of the training poses, the baseline of evaluations.
fn mean_pose(train: &HandDataset) -> Result<HandParams, TrainError> {
    let mut mean = MeanPose::default();
    train.poses(MEAN_POSE_SAMPLES)?.iter().for_each(|pose| mean.push(pose));
    mean.mean().ok_or_else(|| TrainError::Stopped("the training poses have no mean".to_owned()))
}

/// The task of hands with a regressor.
pub(super) struct HandTask<'a> {
    pub(super) config: &'a HandConfig,
    mean_pose: HandParams,
    /// Sequences that filters are estimated on.
    pub(super) unseen: &'a HandDataset,
    pub(super) device: &'a Device,
}

impl HandTask<'_> {
    /// The checkpoint of a network of either kind.
    pub(super) fn checkpoint_of(&self, network: HandNetwork) -> HandCheckpoint {
        let (config, mean_pose) = (self.config.clone(), Some(self.mean_pose));
        HandCheckpoint { config, network, mean_pose }
    }
}

impl TrainingTask for HandTask<'_> {
    type Network = HandRegressor;
    type Loss = HandLoss;
    type Checkpoint = HandCheckpoint;

    const VALUES: &'static [LoggedValue] = &HAND_VALUES;

    fn untrained(&self, device: &Device) -> Result<HandRegressor, TrainError> {
        Ok(self.config.network.init(seed_for(self.config.seed, "weights", 0), device)?)
    }

    fn initial_network(&self, device: &Device) -> Result<HandRegressor, TrainError> {
        first_network(self.config, device)
    }

    fn loss(&self) -> HandLoss {
        HandLoss::new(self.config.loss)
    }

    fn precision(&self) -> TrainingPrecision {
        self.config.training.precision
    }

    fn learning_rate(&self) -> ModuleLrScheduler {
        let training = &self.config.training;
        training.schedule.rate(training.learning_rate, training.steps).into()
    }

    fn checkpoint(&self, network: HandRegressor) -> HandCheckpoint {
        self.checkpoint_of(HandNetwork::Regressor(network))
    }

    fn finish(&self, best: &mut HandCheckpoint) -> Result<(), TrainError> {
        if self.config.training.estimate_filter {
            estimate_filter(best, self.unseen, self.device)?;
        }
        Ok(())
    }

    fn save(checkpoint: &HandCheckpoint, path: &Path) -> Result<(), TrainError> {
        Ok(checkpoint.save(path)?)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;
    use evpose_nn::DeviceKind;
    use evpose_sim::{Simulation, record_all};

    use super::*;
    use crate::hand::small_config;
    use crate::{Method, evaluate};

    /// Of a size that no `.evc` file holds: the network sees them pooled to its own view.
    #[test]
    fn networks_train_and_are_evaluated_before_sensors_of_more_than_256_rows() {
        let mut config = small_config(0.15, 0.4);
        (config.training.batch_size, config.training.steps) = (4, 2);
        config.evaluation.first_ms = 200;
        let mut simulation = config.simulation.clone();
        simulation.sensor_size = SensorSize { width: 346, height: 260 };
        simulation.image_scale = 1.0;
        let directory = tempfile::tempdir().unwrap();
        let (data, run) = (directory.path().join("data"), directory.path().join("run"));
        record_all(&Simulation::new(&simulation, config.seed).unwrap(), &data, &|_| {}).unwrap();
        // An .evc file has room for 256 rows, so these sensors have .raw files.
        assert!(data.join("0000.raw").exists() && !data.join("0000.evc").exists());
        let options = TrainOptions::new(DeviceKind::Flex);
        let summary = train_hand(&config, &data, &run, &options).unwrap();
        assert_eq!(summary.samples, 8);
        let data = HandDataset::open(&data, &config).unwrap();
        assert_eq!(data.sequences()[0].sensor(), config.simulation.image_size());
        assert!(data.memory_bytes() > 8 * 400, "{}", data.memory_bytes());
        let mut trained = summary.best.predictor(Device::flex()).unwrap();
        let mut methods = [Method { name: "trained", predictor: &mut trained, filtered: None }];
        let results = evaluate(&config, &data, &mut methods, 50, &mut |_| {}).unwrap();
        assert_eq!(results[0].tracks[0].frames, [200, 250, 300, 350]);
    }

    #[test]
    fn a_run_that_was_paused_ends_with_the_bytes_of_one_that_was_not() {
        let mut config = small_config(0.15, 0.4);
        (config.training.batch_size, config.training.steps) = (2, 6);
        // The rate at each step is that of the whole run.
        config.training.schedule.cosine = true;
        let directory = tempfile::tempdir().unwrap();
        let [data, whole, paused] = ["data", "whole", "paused"].map(|n| directory.path().join(n));
        record_all(&Simulation::new(&config.simulation, 1).unwrap(), &data, &|_| {}).unwrap();
        let train = |run: &Path, pause_after| {
            let options = TrainOptions::new(DeviceKind::Flex);
            let options = TrainOptions { resume: true, pause_after, ..options };
            train_hand(&config, &data, run, &options).unwrap()
        };
        assert!(!train(&whole, None).is_paused);
        // Rounded up to a validation; twice, as by a process that was killed before it could say so.
        for (pause, samples) in [(3, 8), (3, 0)] {
            let summary = train(&paused, Some(pause));
            assert!(summary.is_paused && !summary.ended_early);
            assert_eq!(summary.samples, samples);
            assert!(summary.path.exists(), "{}", summary.path.display());
            assert!(!paused.join("best.bpk").exists() && !paused.join("last.bpk").exists());
        }
        let summary = train(&paused, Some(100));
        assert_eq!((summary.is_paused, summary.samples), (false, 4));
        for file in ["best.bpk", "last.bpk", "metrics.jsonl", "checkpoint/optimizer-3.bpk"] {
            let [one, other] = [&whole, &paused].map(|run| std::fs::read(run.join(file)).unwrap());
            assert!(one == other, "{file} differs");
        }
    }
}
