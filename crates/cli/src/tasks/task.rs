//! A pose task as the commands see it.

use std::path::{Path, PathBuf};

use crate::args::ConfigArgs;
use anyhow::{Result, bail};
use burn::tensor::Device;
use clap::Args as _;
use evpose_core::{Micros, RegistryEntry, SensorSize};
use evpose_infer::Precision;
use evpose_infer::onnx::Interface;
use evpose_io::OpenOptions;
use evpose_nn::graph::Graph;
use evpose_sim::SequenceSet;

use crate::tasks::args::{
    DirectoryArgs, EvalArgs, InferArgs, OneRecordingArgs, SimulateArgs, TrainArgs,
};
use crate::tasks::experiment::{PoseExperiment, StartWeights};
use crate::tasks::online::OnlineStream;
use crate::tasks::own_args::{Live, TaskArgs, TaskCommand};
use crate::tasks::scores::EvaluationScores;

/// A pose task. Adding one is an implementation and a line of [`TASKS`](crate::tasks::TASKS), or its
/// registration there by a program; every command then takes its configs and its checkpoints.
pub trait PoseTask: Sync {
    /// Name: `task` in configs.
    fn name(&self) -> &'static str;

    /// The model of a checkpoint, a run directory or a file of weights, on `device`.
    ///
    /// # Errors
    /// If it is of another task, or cannot be read.
    fn open(&self, checkpoint: &Path, device: &Device) -> Result<Box<dyn PoseModel>>;

    /// Runs `evpose simulate`.
    ///
    /// # Errors
    /// If the config is of another task, the simulation fails, or the task has none, as by default.
    fn simulate(&self, _args: &SimulateArgs) -> Result<()> {
        bail!("the task `{}` simulates nothing: it learns from data of others", self.name())
    }

    /// Runs `evpose train`.
    ///
    /// # Errors
    /// If the config is of another task, or the training fails.
    fn train(&self, args: &TrainArgs) -> Result<()>;

    /// The simulated data set in `directory`, by its config.
    ///
    /// # Errors
    /// If the config cannot be read, or the task simulates nothing, as by default.
    fn data_set(&self, directory: &Path, _config: &Path) -> Result<DataSetInfo> {
        bail!("{}: no data set: the task `{}` simulates nothing", directory.display(), self.name())
    }

    /// Adds the arguments that the task brings to a command, which it then takes by [`TaskArgs::of`]; by
    /// default one directory of data and one of the run, and one recording.
    fn arguments(&self, of: TaskCommand, command: clap::Command) -> clap::Command {
        match of {
            TaskCommand::Train => DirectoryArgs::augment_args(command),
            TaskCommand::Infer => OneRecordingArgs::augment_args(command),
            TaskCommand::Simulate | TaskCommand::Eval | TaskCommand::Live => command,
        }
    }

    /// The task as studies and benchmarks take it.
    ///
    /// # Errors
    /// If the task takes no part in them, as by default.
    fn studied(&self) -> Result<&dyn StudiedTask> {
        bail!("the task `{}` takes no part in studies and benchmarks", self.name())
    }
}

impl RegistryEntry for dyn PoseTask {
    const KIND: &'static str = "pose task";

    fn name(&self) -> &'static str {
        PoseTask::name(self)
    }
}

/// A pose task as studies and benchmarks take it.
pub trait StudiedTask {
    /// Name of the embedded config that trains on recordings in minutes.
    fn quick_config(&self) -> &'static str;

    /// The experiment of a config, its training from the weights `start`.
    ///
    /// # Errors
    /// If the config is of another task, or not valid.
    fn experiment(
        &self,
        config: &ConfigArgs,
        start: StartWeights<'_>,
    ) -> Result<Box<dyn PoseExperiment>>;

    /// A model with the initial weights of a config.
    ///
    /// # Errors
    /// If the config is of another task, or not valid.
    fn untrained(&self, config: &ConfigArgs, device: &Device) -> Result<Box<dyn PoseModel>>;

    /// A model of the published size with random weights on `device`: for benchmarks.
    ///
    /// # Errors
    /// If the network cannot be initialised.
    fn published(&self, device: &Device) -> Result<Box<dyn PoseModel>>;

    /// Simulates a recording at `rate` events a second into `directory`: for benchmarks. Returns
    /// its path.
    ///
    /// # Errors
    /// If the simulation fails.
    fn benchmark_recording(&self, directory: &Path, rate: f64) -> Result<PathBuf>;
}

/// A network with its decoder and its config, as a checkpoint holds them.
pub trait PoseModel {
    /// The name of its task.
    fn task(&self) -> &'static str;

    /// A description of the network, its input, its size and its training data.
    fn description(&self) -> String;

    /// The config as TOML.
    ///
    /// # Errors
    /// If it cannot be serialised.
    fn config_toml(&self) -> Result<String>;

    /// Runs `evpose eval`.
    ///
    /// # Errors
    /// If the data cannot be read, or an argument is for another task.
    fn evaluate(&self, args: &EvalArgs) -> Result<()>;

    /// Runs `evpose infer`.
    ///
    /// # Errors
    /// If the recording cannot be read, or an argument is for another task.
    fn infer(&self, args: &InferArgs) -> Result<()>;

    /// The stream from events of `sensor` to poses, for the online pipeline.
    ///
    /// # Errors
    /// If the model cannot be used with such a sensor, or an argument is for another task.
    fn stream(&self, sensor: SensorSize, args: &TaskArgs<Live>) -> Result<Box<dyn OnlineStream>>;

    /// The network for exports, quantisation, averages and studies.
    ///
    /// # Errors
    /// If they do not take it, as by default.
    fn network(&self) -> Result<&dyn NetworkModel> {
        bail!("networks of the task `{}` are not exported, quantised or averaged", self.task())
    }
}

/// A model whose network is compiled, and so exported, quantised, averaged and compared.
pub trait NetworkModel {
    /// The name of the network.
    fn network_name(&self) -> String;

    /// The network, layer by layer, with its weights.
    fn graph(&self) -> Graph;

    /// Channels, rows and columns of an input.
    fn input_shape(&self) -> [usize; 3];

    /// Names of inputs and outputs, and a description of the way from events to poses, for those who run an
    /// exported network.
    fn interface(&self) -> Interface {
        Interface { input: "input".to_owned(), ..Interface::default() }
    }

    /// Passes the network's inputs for a recording to `take`, of the first pass of several, each with the time
    /// stamp of its pose in `evpose infer`; `every_ms` apart, or else as the task infers by default. Returns
    /// warnings about the recording.
    ///
    /// # Errors
    /// If the recording cannot be read, or the task hands out none.
    fn for_each_input(
        &self,
        recording: &Path,
        every_ms: Option<u32>,
        opening: &OpenOptions,
        take: &mut dyn FnMut(Micros, &[f32]) -> Result<()>,
    ) -> Result<Vec<String>> {
        let _ = (recording, every_ms, opening, take);
        bail!("`{}` does not hand out its inputs", self.network_name())
    }

    /// Runs `evpose average`: writes the mean of this network and that of the checkpoint `other`, with
    /// this one's config, thresholds and provenance.
    ///
    /// # Errors
    /// If `other` cannot be read or is of another shape, or `out` cannot be written.
    fn save_average(&self, other: &Path, out: &Path) -> Result<()>;

    /// Up to `count` inputs of a data set, spread evenly: for the calibration of int8 inference.
    ///
    /// # Errors
    /// If the data set cannot be read.
    fn calibration_inputs(
        &self,
        data: &Path,
        count: u64,
    ) -> Result<Box<dyn ExactSizeIterator<Item = Result<Vec<f32>>> + '_>>;

    /// Runs `evpose quantize --evaluate`: accuracy and latency in each precision on a data set.
    ///
    /// # Errors
    /// If the data set cannot be read.
    fn evaluate_precisions(
        &self,
        data: &Path,
        ranges: &evpose_infer::CalibrationRanges,
        stride_ms: u32,
    ) -> Result<Vec<PrecisionScores>>;

    /// Scores on each recording of a directory, with a pose every `stride_ms` milliseconds, by
    /// default the task's.
    ///
    /// # Errors
    /// If the data cannot be read.
    fn scores(&self, data: &Path, stride_ms: Option<u32>) -> Result<EvaluationScores>;
}

/// A simulated data set, as its config describes it.
#[derive(Debug, Clone)]
pub struct DataSetInfo {
    /// Content in a few words.
    pub content: String,
    /// Number of sequences.
    pub sequences: usize,
    /// Length of each sequence in seconds.
    pub seconds: f64,
    /// Seed of the experiment.
    pub seed: u64,
    /// Recordings and labels.
    pub set: SequenceSet,
}

/// Accuracy and latency in a precision.
#[derive(Debug, Clone)]
pub struct PrecisionScores {
    /// Precision of the engine.
    pub precision: Precision,
    /// Median time of an inference of one input, in milliseconds.
    pub latency_ms: f64,
    /// Headings and cells of the table.
    pub cells: Vec<(&'static str, String)>,
    /// The scores as JSON.
    pub held_out: serde_json::Value,
}
