//! A network before events, of either kind.

use std::path::Path;

use anyhow::{Result, bail};
use burn::tensor::Device;
use clap::ValueEnum;
use evpose_core::SensorSize;
use evpose_infer::Precision;
use evpose_live::{BodyEye, BodyNetwork, HandEye, HandNetwork, Task, body_task, hand_task};
use evpose_nn::DeviceKind;
use evpose_train::body::{BetweenConfig, BodyCheckpoint, BodyPredictorOptions};
use evpose_train::{Checkpoint, HandConfig, NetworkPredictor};

use crate::args::DeviceArgs;
use crate::{body_checkpoint, hand_predictor};

/// Whose poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LiveTask {
    /// 12 parameters and 21 joints of a hand
    Hand,
    /// 13 joints of a person
    Body,
}

/// Surfaces at once where the CPU does not compute, as published.
const BATCH: usize = 16;

/// How a network is used.
pub struct TaskOptions<'a> {
    /// Precision of the arithmetic of the network.
    pub precision: Precision,
    /// Device and threads.
    pub device: &'a DeviceArgs,
    /// Surfaces of hands at once.
    pub batch: Option<u16>,
    /// Joints of bodies of a lower score are not found.
    pub confidence: f32,
}

/// Eyes and networks of either kind.
pub enum AnyTask {
    /// A network of bodies.
    Body(Box<Task<BodyEye, BodyNetwork>>),
    /// And the experiment, which knows the surface of its hand.
    Hand(Box<Task<HandEye, HandNetwork<NetworkPredictor>>>, Box<HandConfig>),
}

impl AnyTask {
    /// The network of `checkpoint` before events of `sensor`.
    pub fn load(
        checkpoint: &Path,
        wanted: Option<LiveTask>,
        sensor: SensorSize,
        options: &TaskOptions<'_>,
    ) -> Result<Self> {
        if let Some(network) = body_checkpoint::checkpoint(checkpoint, &Device::flex())? {
            if wanted == Some(LiveTask::Hand) {
                bail!("{}: a network of bodies, not of hands", checkpoint.display());
            }
            return Self::of_body(&network, sensor, options);
        }
        if wanted == Some(LiveTask::Body) {
            bail!("{}: a network of hands, not of bodies", checkpoint.display());
        }
        let device = options.device.open()?;
        let hand = Checkpoint::load(checkpoint, &device)?;
        let trained_for = hand.config.simulation.image_size();
        if sensor != trained_for {
            bail!("events of {sensor}, but the network was trained for {trained_for}");
        }
        let predictor =
            hand_predictor::predictor(checkpoint, hand.network, options.precision, device)?;
        Self::of_hand(&hand.config, predictor, sensor, options)
    }

    /// A network of bodies.
    pub fn of_body(
        checkpoint: &BodyCheckpoint,
        sensor: SensorSize,
        options: &TaskOptions<'_>,
    ) -> Result<Self> {
        let predictor = BodyPredictorOptions {
            precision: options.precision,
            confidence: options.confidence,
            ..BodyPredictorOptions::default()
        };
        let task = body_task(checkpoint, sensor, &BetweenConfig::default(), predictor)?;
        Ok(Self::Body(Box::new(task)))
    }

    /// A network of hands.
    pub fn of_hand(
        config: &HandConfig,
        predictor: NetworkPredictor,
        sensor: SensorSize,
        options: &TaskOptions<'_>,
    ) -> Result<Self> {
        let on_cpu = options.device.device == DeviceKind::Flex;
        let batch = options.batch.map_or(if on_cpu { 1 } else { BATCH }, usize::from);
        let task = hand_task(config, predictor, sensor, batch)?;
        Ok(Self::Hand(Box::new(task), Box::new(config.clone())))
    }

    /// Poses a second between those of the network, if nobody says how many.
    pub fn usual_between_hz(&self) -> f64 {
        match self {
            Self::Body(_) => 500.0,
            Self::Hand(..) => 1_000.0,
        }
    }
}
