//! The body task: MoveEnet.

pub(crate) mod args;
mod eval;
mod experiment;
mod images;
mod infer;
mod infer_cameras;
mod inputs;
mod precision;
mod simulate;
mod train;
mod world;

use std::path::{Path, PathBuf};

use self::args::{BodyEvalArgs, BodyInferArgs, BodyLiveArgs, BodySimulateArgs, BodyTrainArgs};
use crate::args::ConfigArgs;
use crate::configs;
use anyhow::{Context, Result, ensure};
use burn::module::Module;
use burn::tensor::Device;
use clap::Args as _;
use evpose_camera::Calibration;
use evpose_core::{Micros, SensorSize};
use evpose_infer::CalibrationRanges;
use evpose_infer::onnx::Interface;
use evpose_io::OpenOptions;
use evpose_live::page::Skeleton;
use evpose_nn::MoveEnetConfig;
use evpose_nn::graph::Graph;
use evpose_nn::weights::average;
use evpose_sim::SequenceSet;
use evpose_task::body::{
    BodyCheckpoint, BodyConfig, BodyPredictor, BodyPredictorOptions, PropagationConfig, body_stream,
};
use evpose_task::{Experiment, QuantizationRanges};
use evpose_train::body::{BodyFrames, BodyRecordings};

pub(in crate::tasks) use self::eval::{PERCENTS, print};
use crate::tasks::args::{EvalArgs, InferArgs, SimulateArgs, TrainArgs};
use crate::tasks::benchmark_recording;
use crate::tasks::experiment::{PoseExperiment, StartWeights};
use crate::tasks::online::{OnlineStream, TaskStream};
use crate::tasks::own_args::{Live, TaskArgs, TaskCommand};
use crate::tasks::scores::EvaluationScores;
use crate::tasks::task::{
    DataSetInfo, NetworkModel, PoseModel, PoseTask, PrecisionScores, StudiedTask,
};

/// Propagated poses per second.
const PROPAGATE_HZ: f64 = 500.0;

/// The body task.
pub(crate) struct Body;

impl PoseTask for Body {
    fn name(&self) -> &'static str {
        BodyConfig::TASK
    }

    fn open(&self, path: &Path, device: &Device) -> Result<Box<dyn PoseModel>> {
        let checkpoint = BodyCheckpoint::load(path, device)
            .with_context(|| format!("the body network {}", path.display()))?;
        let (path, device) = (Some(path.to_owned()), device.clone());
        Ok(Box::new(BodyNetwork { checkpoint, path, device }))
    }

    fn simulate(&self, args: &SimulateArgs) -> Result<()> {
        simulate::run(args)
    }

    fn train(&self, args: &TrainArgs) -> Result<()> {
        train::run(args)
    }

    fn data_set(&self, directory: &Path, config: &Path) -> Result<DataSetInfo> {
        let BodyConfig { simulation, seed, .. } = BodyConfig::read(config)?;
        Ok(DataSetInfo {
            content: format!("people: {}", simulation.activities.join(", ")),
            sequences: simulation.sequences,
            seconds: simulation.seconds,
            seed,
            set: SequenceSet::of_people(directory, &simulation)?,
        })
    }

    fn arguments(&self, of: TaskCommand, command: clap::Command) -> clap::Command {
        match of {
            TaskCommand::Simulate => BodySimulateArgs::augment_args(command),
            TaskCommand::Train => BodyTrainArgs::augment_args(command),
            TaskCommand::Eval => BodyEvalArgs::augment_args(command),
            TaskCommand::Infer => BodyInferArgs::augment_args(command),
            TaskCommand::Live => BodyLiveArgs::augment_args(command),
        }
    }

    fn studied(&self) -> Result<&dyn StudiedTask> {
        Ok(self)
    }
}

impl StudiedTask for Body {
    fn quick_config(&self) -> &'static str {
        "finetune"
    }

    fn experiment(
        &self,
        config: &ConfigArgs,
        start: StartWeights<'_>,
    ) -> Result<Box<dyn PoseExperiment>> {
        let config: BodyConfig = configs::load(&config.config, &config.overrides)?;
        let start_from = start.field(config.start_from.clone());
        Ok(Box::new(BodyConfig { start_from, ..config }))
    }

    fn untrained(&self, config: &ConfigArgs, device: &Device) -> Result<Box<dyn PoseModel>> {
        let config: BodyConfig = configs::load(&config.config, &config.overrides)?;
        let network = config.network.init(config.seed, device)?;
        let checkpoint = BodyCheckpoint { config, network, mean_pose: None, data: None };
        Ok(Box::new(BodyNetwork { checkpoint, path: None, device: device.clone() }))
    }

    fn published(&self, device: &Device) -> Result<Box<dyn PoseModel>> {
        let network = MoveEnetConfig::default().init(1, device)?;
        let config = BodyConfig::default();
        let checkpoint = BodyCheckpoint { config, network, mean_pose: None, data: None };
        Ok(Box::new(BodyNetwork { checkpoint, path: None, device: device.clone() }))
    }

    fn benchmark_recording(&self, directory: &Path, rate: f64) -> Result<PathBuf> {
        benchmark_recording::of_body(directory, rate)
    }
}

pub(crate) struct BodyNetwork {
    checkpoint: BodyCheckpoint,
    /// The checkpoint; none for weights that were not read.
    path: Option<PathBuf>,
    device: Device,
}

impl BodyNetwork {
    /// A predictor; int8 takes its ranges from the file beside the checkpoint.
    fn predictor(&self, options: BodyPredictorOptions) -> Result<BodyPredictor> {
        let graph = || self.graph();
        let ranges = QuantizationRanges::needed(options.precision, self.path.as_deref(), graph)?;
        Ok(BodyPredictor::new(&self.checkpoint, options, ranges.as_ref())?)
    }
}

impl PoseModel for BodyNetwork {
    fn task(&self) -> &'static str {
        Body.name()
    }

    fn description(&self) -> String {
        let BodyCheckpoint { config, network, data, .. } = &self.checkpoint;
        let mut text = format!(
            "bodies: {} joints from {} of {side}x{side} pixels, {} parameters",
            network.config().joints,
            config.image.representation,
            network.num_params(),
            side = config.image.side_px,
        );
        if let Some(data) = data {
            text += &format!("\ntrained on data of SHA-256 {data}");
        }
        text
    }

    fn config_toml(&self) -> Result<String> {
        Ok(Experiment::to_toml(&self.checkpoint.config)?)
    }

    fn evaluate(&self, args: &EvalArgs) -> Result<()> {
        eval::run(self, args, &args.own.of(Body.name())?)
    }

    fn infer(&self, args: &InferArgs) -> Result<()> {
        infer::run(self, args, &args.own.of(Body.name())?)
    }

    fn stream(&self, sensor: SensorSize, args: &TaskArgs<Live>) -> Result<Box<dyn OnlineStream>> {
        let BodyLiveArgs { own: options, min_score, confidence, consensus } =
            args.of(Body.name())?;
        let mut predictor = self.predictor(BodyPredictorOptions {
            precision: options.precision,
            confidence,
            consensus: Some(consensus),
            ..BodyPredictorOptions::default()
        })?;
        // Every image of a batch but the last waits, so that only who asks for it gets one.
        let batch = options.batch.map_or(1, usize::from);
        if self.device != Device::flex() {
            predictor.warm_up(batch);
        }
        let propagation = PropagationConfig::default();
        // Nothing in 2D follows from the focal length: a guess needs no note.
        let calibration = Calibration::choose(options.camera.as_deref(), sensor)?;
        let mut stream =
            body_stream(&self.checkpoint, &calibration, Some(&propagation), predictor)?;
        stream.frontend =
            stream.frontend.with_batch(batch).with_filter(self.checkpoint.config.filter)?;
        if let Some(min_score) = min_score {
            stream.frontend = stream.frontend.with_min_score(min_score);
        }
        Ok(Box::new(TaskStream::new(stream, PROPAGATE_HZ, Skeleton::Body)))
    }

    fn network(&self) -> Result<&dyn NetworkModel> {
        Ok(self)
    }
}

impl NetworkModel for BodyNetwork {
    fn network_name(&self) -> String {
        format!("move_enet of width {}", self.checkpoint.network.config().width)
    }

    fn graph(&self) -> Graph {
        self.checkpoint.network.graph()
    }

    fn input_shape(&self) -> [usize; 3] {
        let side = self.checkpoint.config.image.side_px;
        [self.graph().nodes[0].channels, side, side]
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
        let BodyCheckpoint { config, network, mean_pose, data } = &self.checkpoint;
        let other = BodyCheckpoint::load(other, &self.device)?.network;
        ensure!(other.config() == network.config(), "the networks are of different shapes");
        let network = average(&other, network.clone());
        let (config, data) = (config.clone(), data.clone());
        Ok(BodyCheckpoint { config, network, mean_pose: *mean_pose, data }.save(out)?)
    }

    fn calibration_inputs(
        &self,
        data: &Path,
        count: u64,
    ) -> Result<Box<dyn ExactSizeIterator<Item = Result<Vec<f32>>> + '_>> {
        let BodyFrames { frames } =
            BodyRecordings::open(data)?.frames(&self.checkpoint.config, &|_| {})?;
        ensure!(!frames.is_empty(), "{}: no images", data.display());
        let mut predictor = self.predictor(BodyPredictorOptions::default())?;
        let count = (count as usize).min(frames.len());
        Ok(Box::new((0..count).map(move |k| {
            let image = &frames[k * frames.len() / count].image;
            // Both passes of the network are inferred in int8.
            let input =
                if k % 2 == 0 { predictor.input(image) } else { predictor.second_input(image) };
            Ok(input.to_vec())
        })))
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
