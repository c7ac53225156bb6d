//! The streams of either task, for the online pipeline.

use std::path::Path;

use anyhow::{Result, bail};
use burn::tensor::Device;
use clap::ValueEnum;
use evpose_body::PosedBody;
use evpose_core::SensorSize;
use evpose_infer::Precision;
use evpose_live::page::HandMesh;
use evpose_nn::DeviceKind;
use evpose_pose::HandParams;
use evpose_pose::stream::PoseStream;
use evpose_task::body::{
    BodyCheckpoint, BodyFrontend, BodyPredictorOptions, BodyWorker, PropagationConfig, body_stream,
};
use evpose_task::hand::{
    HandCheckpoint, HandConfig, HandFrontend, HandView, HandWorker, NetworkPredictor, hand_stream,
};

use crate::args::DeviceArgs;
use crate::{body_checkpoint, hand_predictor};

/// A task of the online pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LiveTask {
    /// 12 parameters and 21 joints of a hand
    Hand,
    /// 13 joints of a person
    Body,
}

/// Inputs per inference on devices other than the CPU, as published.
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
    Body(Box<PoseStream<BodyFrontend, BodyWorker>>),
    /// And the experiment, which knows the surface of its hand.
    Hand(Box<PoseStream<HandFrontend, HandWorker<NetworkPredictor>>>, Box<HandConfig>),
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
        let hand = HandCheckpoint::load(checkpoint, &device)?;
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
        let task = body_stream(checkpoint, sensor, &PropagationConfig::default(), predictor)?;
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
        let task = hand_stream(config, predictor, sensor, batch)?;
        Ok(Self::Hand(Box::new(task), Box::new(config.clone())))
    }

    /// Poses a second between those of the network, if nobody says how many.
    pub fn default_propagate_hz(&self) -> f64 {
        match self {
            Self::Body(_) => 500.0,
            Self::Hand(..) => 1_000.0,
        }
    }
}

/// The mesh of the hand of `config`, for a page.
///
/// # Errors
/// If the file of its model cannot be read.
pub fn hand_mesh(config: &HandConfig) -> Result<HandMesh> {
    let (view, side) = (HandView::new(config)?, config.simulation.hands.side(0));
    let faces = view.faces(side).to_vec();
    let mut scratch = PosedBody::default();
    let vertices = move |params: &HandParams| view.vertices_px(side, params, &mut scratch);
    Ok(HandMesh { faces, vertices: Box::new(vertices) })
}
