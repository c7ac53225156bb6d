//! The hand task: EventHands.

pub(crate) mod args;
mod conditions;
mod eval;
mod experiment;
mod foreign;
mod foreign_preview;
mod infer;
mod inputs;
mod precision;
mod simulate;
mod train;

use std::path::{Path, PathBuf};

use self::args::{HandEvalArgs, HandInferArgs, HandLiveArgs, HandSimulateArgs, HandTrainArgs};
use crate::args::ConfigArgs;
use crate::configs;
use crate::json::write_json;
use anyhow::{Context, Result, ensure};
use burn::module::Module;
use burn::tensor::Device;
use clap::Args as _;
use evpose_body::PosedBody;
use evpose_core::{Micros, SensorSize};
use evpose_infer::onnx::Interface;
use evpose_infer::{CalibrationRanges, Precision};
use evpose_io::OpenOptions;
use evpose_live::page::{HandMesh, Skeleton};
use evpose_nn::HandRegressorConfig;
use evpose_nn::graph::Graph;
use evpose_nn::weights::average;
use evpose_pose::HandParams;
use evpose_pose::metric::MeanPose;
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::SequenceSet;
use evpose_task::hand::{HandCheckpoint, HandConfig, HandView, NetworkPredictor, hand_stream};
use evpose_task::{Experiment, QuantizationRanges, TaskError};
use evpose_train::{HandDataset, untrained};

pub(in crate::tasks) use self::inputs::{denoise, described};
use crate::tasks::args::{EvalArgs, InferArgs, SimulateArgs, TrainArgs};
use crate::tasks::benchmark_recording;
use crate::tasks::experiment::{PoseExperiment, StartWeights};
use crate::tasks::online::{self, OnlineStream, TaskStream};
use crate::tasks::own_args::{Live, TaskArgs, TaskCommand};
use crate::tasks::scores::EvaluationScores;
use crate::tasks::task::{
    DataSetInfo, NetworkModel, PoseModel, PoseTask, PrecisionScores, StudiedTask,
};

/// Propagated poses per second.
const PROPAGATE_HZ: f64 = 1_000.0;

/// The hand task.
pub(crate) struct Hand;

impl PoseTask for Hand {
    fn name(&self) -> &'static str {
        HandConfig::TASK
    }

    fn open(&self, path: &Path, device: &Device) -> Result<Box<dyn PoseModel>> {
        let checkpoint = HandCheckpoint::load(path, device)?;
        let (path, device) = (Some(path.to_owned()), device.clone());
        Ok(Box::new(HandNetwork { checkpoint, path, device }))
    }

    fn simulate(&self, args: &SimulateArgs) -> Result<()> {
        simulate::run(args)
    }

    fn train(&self, args: &TrainArgs) -> Result<()> {
        train::run(args)
    }

    fn data_set(&self, directory: &Path, config: &Path) -> Result<DataSetInfo> {
        let HandConfig { simulation, seed, .. } = HandConfig::read(config)?;
        Ok(DataSetInfo {
            content: "hands".to_owned(),
            sequences: simulation.sequences,
            seconds: simulation.seconds,
            seed,
            set: SequenceSet::of_hands(directory, &simulation)?,
        })
    }

    fn arguments(&self, of: TaskCommand, command: clap::Command) -> clap::Command {
        match of {
            TaskCommand::Simulate => HandSimulateArgs::augment_args(command),
            TaskCommand::Train => HandTrainArgs::augment_args(command),
            TaskCommand::Eval => HandEvalArgs::augment_args(command),
            TaskCommand::Infer => HandInferArgs::augment_args(command),
            TaskCommand::Live => HandLiveArgs::augment_args(command),
        }
    }

    fn studied(&self) -> Result<&dyn StudiedTask> {
        Ok(self)
    }
}

impl StudiedTask for Hand {
    fn quick_config(&self) -> &'static str {
        "quick"
    }

    fn experiment(
        &self,
        config: &ConfigArgs,
        start: StartWeights<'_>,
    ) -> Result<Box<dyn PoseExperiment>> {
        let config: HandConfig = configs::load(&config.config, &config.overrides)?;
        let start_from = start.field(config.start_from.clone());
        Ok(Box::new(HandConfig { start_from, ..config }))
    }

    fn untrained(&self, config: &ConfigArgs, device: &Device) -> Result<Box<dyn PoseModel>> {
        let config = configs::load(&config.config, &config.overrides)?;
        let network = untrained(&config, device)?;
        let checkpoint = HandCheckpoint { config, network, mean_pose: None };
        Ok(Box::new(HandNetwork { checkpoint, path: None, device: device.clone() }))
    }

    fn published(&self, device: &Device) -> Result<Box<dyn PoseModel>> {
        let network = evpose_nn::HandNetwork::init(&HandRegressorConfig::default(), 1, device)?;
        let checkpoint = HandCheckpoint { config: HandConfig::default(), network, mean_pose: None };
        Ok(Box::new(HandNetwork { checkpoint, path: None, device: device.clone() }))
    }

    fn benchmark_recording(&self, directory: &Path, rate: f64) -> Result<PathBuf> {
        benchmark_recording::of_hand(directory, rate)
    }
}

pub(crate) struct HandNetwork {
    pub(crate) checkpoint: HandCheckpoint,
    /// The checkpoint; none for weights that were not read.
    path: Option<PathBuf>,
    pub(crate) device: Device,
}

impl HandNetwork {
    /// A predictor in a precision; int8 takes its ranges from the file beside the checkpoint.
    ///
    /// # Errors
    /// If the precision is not f32 on a device other than flex, or int8 without that file.
    pub(crate) fn predictor(&self, precision: Precision) -> Result<NetworkPredictor> {
        if precision == Precision::F32 {
            return Ok(self.checkpoint.predictor(self.device.clone())?);
        }
        // Reduced precision is the engine's, which computes on the CPU alone.
        ensure!(self.device == Device::flex(), TaskError::Precision { precision });
        let HandCheckpoint { config, network, .. } = &self.checkpoint;
        let graph = || network.graph();
        let ranges = QuantizationRanges::needed(precision, self.path.as_deref(), graph)?;
        Ok(NetworkPredictor::compiled(config, network, precision, ranges)?)
    }

    /// The mean pose of its training data, or else of `data`, which is a stronger baseline.
    fn mean_pose(&self, data: &HandDataset) -> Result<HandParams> {
        // Imported weights carry no mean pose of their training data.
        if let Some(mean) = self.checkpoint.mean_pose {
            return Ok(mean);
        }
        let mut mean = MeanPose::default();
        data.poses(100_000)?.iter().for_each(|pose| mean.push(pose));
        mean.mean().context("no poses to average")
    }
}

impl PoseModel for HandNetwork {
    fn task(&self) -> &'static str {
        Hand.name()
    }

    fn description(&self) -> String {
        let config = &self.checkpoint.config;
        let (representation, simulation) = (&config.representation, &config.simulation);
        format!(
            "hands: {} of width {} from {} of {} ms at {}, {} parameters",
            config.network.backbone,
            config.network.width,
            representation.name,
            representation.window_ms,
            simulation.image_size(),
            self.checkpoint.network.num_params(),
        )
    }

    fn config_toml(&self) -> Result<String> {
        Ok(Experiment::to_toml(&self.checkpoint.config)?)
    }

    fn evaluate(&self, args: &EvalArgs) -> Result<()> {
        let own: HandEvalArgs = args.own.of(Hand.name())?;
        if let Some(data) = &args.data {
            eval::run(self, args, &own.own, data)?;
        }
        if let Some(foreign) = &own.own.foreign {
            let report = foreign::run(self, &own, &foreign.join("hands"))?;
            // There is one file, which is that of the data where both are asked for.
            if args.data.is_none() {
                write_json(args.json.as_deref(), &report)?;
            }
        }
        if args.data.is_none() && own.own.foreign.is_none() {
            conditions::run(self, args, &own)?;
        }
        Ok(())
    }

    fn infer(&self, args: &InferArgs) -> Result<()> {
        infer::run(self, args, &args.own.of(Hand.name())?)
    }

    fn stream(&self, sensor: SensorSize, args: &TaskArgs<Live>) -> Result<Box<dyn OnlineStream>> {
        let HandLiveArgs { own: options, length } = args.of(Hand.name())?;
        let config = self.checkpoint.config.clone();
        let calibration = infer::calibration(&config, sensor, options.camera.as_deref())?;
        let batch = online::batch(options.batch, &self.device);
        let predictor = self.predictor(options.precision)?;
        // The newest input wins: under load, an older one would only add latency.
        let schedule = InferenceSchedule::NewestWhenFree;
        let mut stream = hand_stream(&config, predictor, &calibration, schedule, batch)?;
        if let Some(length_m) = length.metres() {
            stream.frontend.hand_length(length_m);
        }
        let stream = TaskStream::new(stream, PROPAGATE_HZ, Skeleton::Hand);
        Ok(Box::new(stream.with_mesh(move || hand_mesh(&config))))
    }

    fn network(&self) -> Result<&dyn NetworkModel> {
        Ok(self)
    }
}

impl NetworkModel for HandNetwork {
    fn network_name(&self) -> String {
        let network = &self.checkpoint.config.network;
        format!("{} of width {}", network.backbone, network.width)
    }

    fn graph(&self) -> Graph {
        self.checkpoint.network.graph()
    }

    fn input_shape(&self) -> [usize; 3] {
        let size = self.checkpoint.config.network_size();
        [self.graph().nodes[0].channels, size.height.into(), size.width.into()]
    }

    fn interface(&self) -> Interface {
        inputs::interface(self)
    }

    fn for_each_input(
        &self,
        recording: &Path,
        every_ms: Option<u32>,
        opening: &OpenOptions,
        take: &mut dyn FnMut(Micros, &[f32]) -> Result<()>,
    ) -> Result<Vec<String>> {
        inputs::for_each(self, recording, every_ms, opening, take)
    }

    fn save_average(&self, other: &Path, out: &Path) -> Result<()> {
        let HandCheckpoint { config, network, mean_pose } = &self.checkpoint;
        let other = HandCheckpoint::load(other, &Device::flex())?;
        ensure!(other.config.network == config.network, "the networks are of different shapes");
        let network = average(&other.network, network.clone());
        Ok(HandCheckpoint { config: config.clone(), network, mean_pose: *mean_pose }.save(out)?)
    }

    fn calibration_inputs(
        &self,
        data: &Path,
        count: u64,
    ) -> Result<Box<dyn ExactSizeIterator<Item = Result<Vec<f32>>> + '_>> {
        let data = HandDataset::open(data, &self.checkpoint.config)?;
        let count = count.min(data.len()) as usize;
        Ok(Box::new(
            (0..count).map(move |window| {
                Ok(data.plain_input(window as u64 * data.len() / count as u64)?)
            }),
        ))
    }

    fn evaluate_precisions(
        &self,
        data: &Path,
        ranges: &CalibrationRanges,
        stride_ms: u32,
    ) -> Result<Vec<PrecisionScores>> {
        precision::evaluate(&self.checkpoint, data, ranges, stride_ms)
    }

    fn scores(&self, data: &Path, stride_ms: Option<u32>) -> Result<EvaluationScores> {
        experiment::scores(self, data, stride_ms)
    }
}

fn hand_mesh(config: &HandConfig) -> Result<HandMesh> {
    let (view, side) = (HandView::new(config)?, config.simulation.hands.side(0));
    let faces = view.faces(side).to_vec();
    let mut scratch = PosedBody::default();
    let vertices = move |params: &HandParams| view.vertices_px(side, params, &mut scratch);
    Ok(HandMesh { faces, vertices: Box::new(vertices) })
}
