//! The task as the commands call it.

use std::path::Path;

use anyhow::Result;
use burn::module::Module as _;
use burn::tensor::Device;
use evpose_cli::configs;
use evpose_cli::tasks::args::{DirectoryArgs, EvalArgs, InferArgs, SimulateArgs, TrainArgs};
use evpose_cli::tasks::online::OnlineStream;
use evpose_cli::tasks::values::{ValueModel as _, record_values};
use evpose_cli::tasks::{DataSetInfo, Live, PoseModel, PoseTask, TaskArgs, finish_training};
use evpose_core::{SensorSize, seed_for};
use evpose_nn::weights;
use evpose_sim::SequenceSet;
use evpose_sim::set::PEOPLE;
use evpose_task::{Experiment, network_file};

use crate::config::BlobConfig;
use crate::network::{BlobModel, train_blob};
use crate::simulation::record;

pub(crate) struct BlobTask;

/// The files of the sequences: events, a table of poses, a description.
fn sequences(directory: &Path, config: &BlobConfig) -> SequenceSet {
    SequenceSet::new(directory, config.sequences).with_endings(PEOPLE)
}

impl PoseTask for BlobTask {
    fn name(&self) -> &'static str {
        BlobConfig::TASK
    }

    fn open(&self, checkpoint: &Path, device: &Device) -> Result<Box<dyn PoseModel>> {
        let (network, card) = weights::load(&network_file(checkpoint)?, device)?;
        Ok(Box::new(BlobModel { network, card, device: device.clone() }))
    }

    fn simulate(&self, args: &SimulateArgs) -> Result<()> {
        let mut config: BlobConfig = configs::load(&args.config.config, &args.config.overrides)?;
        config.seed = args.seed.unwrap_or(config.seed);
        if args.held_out {
            config.seed = seed_for(config.seed, "held out", 0) >> 1;
        }
        config.seconds = args.seconds.unwrap_or(config.seconds);
        config.sequences = args.sequences.unwrap_or(config.sequences);
        let set = sequences(&args.out, &config);
        record_values(args, &config, &set, |sequence| record(&config, &set, sequence))
    }

    fn train(&self, args: &TrainArgs) -> Result<()> {
        let config: BlobConfig = configs::load(&args.config.config, &args.config.overrides)?;
        let DirectoryArgs { data, out } = args.own.of(BlobConfig::TASK)?;
        args.device.open()?;
        let trained = train_blob(&config, &data, &out, &args.options())?;
        finish_training(trained, &out, config.training, config.seed, "samples")
    }

    fn data_set(&self, directory: &Path, config: &Path) -> Result<DataSetInfo> {
        let config = BlobConfig::read(config)?;
        Ok(DataSetInfo {
            content: "a disc that moves".to_owned(),
            sequences: config.sequences,
            seconds: config.seconds,
            seed: config.seed,
            set: sequences(directory, &config),
        })
    }
}

impl PoseModel for BlobModel {
    fn task(&self) -> &'static str {
        BlobConfig::TASK
    }

    fn description(&self) -> String {
        format!("blobs: {} parameters", self.network.num_params())
    }

    fn config_toml(&self) -> Result<String> {
        Ok(self.card.config.to_toml()?)
    }

    fn evaluate(&self, args: &EvalArgs) -> Result<()> {
        self.evaluate_values(args, &self.card.mean)
    }

    fn infer(&self, args: &InferArgs) -> Result<()> {
        self.write_values(args)
    }

    fn stream(&self, sensor: SensorSize, args: &TaskArgs<Live>) -> Result<Box<dyn OnlineStream>> {
        self.stream_values(sensor, args)
    }
}
