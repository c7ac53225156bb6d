//! The task of the networks that MoveEnet is compared with, DHP19's and LiftMono-HPE: trained on recordings of people, and used as
//! those of bodies are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use burn::module::Module as _;
use burn::tensor::Device;
use clap::Args as _;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::{Micros, SensorSize};
use evpose_io::Windows;
use evpose_io::poses::PoseKind;
use evpose_live::page::Skeleton;
use evpose_pose::stream::InferenceSchedule;
use evpose_task::baseline::{BaselineCheckpoint, BaselineConfig, baseline_stream};
use evpose_task::{Experiment as _, RecordingStream};
use evpose_train::baseline::{baseline_frames, evaluate_baseline, train_baseline};
use evpose_train::body::{BodyFrames, BodyRecordings};
use evpose_train::training::TrainingSpan;

use crate::configs;
use crate::json::write_json;
use crate::progress::{bar, say};
use crate::tasks::args::{EvalArgs, InferArgs, OneRecordingArgs, StartArgs, TrainArgs};
use crate::tasks::body::{PERCENTS, print};
use crate::tasks::finish_training;
use crate::tasks::infer_all::write_rows;
use crate::tasks::online::{OnlineStream, TaskStream};
use crate::tasks::own_args::{Live, NoArgs, TaskArgs, TaskCommand};
use crate::tasks::task::{PoseModel, PoseTask};

/// The task of either network.
pub(crate) struct Baseline;

impl PoseTask for Baseline {
    fn name(&self) -> &'static str {
        BaselineConfig::TASK
    }

    fn open(&self, checkpoint: &Path, device: &Device) -> Result<Box<dyn PoseModel>> {
        Ok(Box::new(BaselineModel(BaselineCheckpoint::load(checkpoint, device)?)))
    }

    fn train(&self, args: &TrainArgs) -> Result<()> {
        let BaselineTrainArgs { data, out, start } = args.own.of(BaselineConfig::TASK)?;
        let mut config: BaselineConfig =
            configs::load(&args.config.config, &args.config.overrides)?;
        config.start_from = start.or(config.start_from.take())?;
        let out = out.unwrap_or_else(|| config.out.clone());
        // An error now rather than after the reading.
        args.device.open()?;
        let frames = frames(&config, &data)?;
        let trained = train_baseline(&config, frames, &out, &args.options());
        finish_training(trained, &out, TrainingSpan::from(&config.training), config.seed, "images")
    }

    fn arguments(&self, of: TaskCommand, command: clap::Command) -> clap::Command {
        match of {
            TaskCommand::Train => BaselineTrainArgs::augment_args(command),
            TaskCommand::Infer => OneRecordingArgs::augment_args(command),
            TaskCommand::Simulate | TaskCommand::Eval | TaskCommand::Live => command,
        }
    }
}

#[derive(Debug, clap::Args)]
struct BaselineTrainArgs {
    /// Directory of recordings of people
    #[arg(long)]
    data: PathBuf,
    /// Directory of the run [default: the config's `out`]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    start: StartArgs,
}

/// The images of the recordings in `data`.
fn frames(config: &BaselineConfig, data: &Path) -> Result<BodyFrames> {
    let progress = bar("reading", BodyRecordings::open(data)?.files.len() as u64, "recordings");
    let frames = baseline_frames(config, data, &|done| progress.inc(done))?;
    progress.finish_and_clear();
    say(format!("{} images of {}", frames.len(), data.display()));
    Ok(frames)
}

/// A network with the experiment it came from.
struct BaselineModel(BaselineCheckpoint);

impl BaselineModel {
    /// Time between poses, by the config if not stated.
    fn every(&self, stride_ms: Option<u32>) -> Micros {
        Micros(1_000 * i64::from(stride_ms.unwrap_or(self.0.config.data.every_ms).max(1)))
    }
}

impl PoseModel for BaselineModel {
    fn task(&self) -> &'static str {
        BaselineConfig::TASK
    }

    fn description(&self) -> String {
        let BaselineConfig { network, image, .. } = &self.0.config;
        format!(
            "{}: {} joints from {} of {}x{} pixels, {} parameters",
            network.kind(),
            network.joints(),
            image.representation,
            image.width_px,
            image.height_px,
            self.0.network.num_params(),
        )
    }

    fn config_toml(&self) -> Result<String> {
        Ok(self.0.config.to_toml()?)
    }

    fn evaluate(&self, args: &EvalArgs) -> Result<()> {
        let NoArgs {} = args.own.of(self.task())?;
        let data = args.data.as_deref().context("--data, a directory of recordings, is missing")?;
        let recordings = BodyRecordings::open(data)?;
        let progress = bar("evaluating", recordings.files.len() as u64, "recordings");
        let advance = |done| progress.inc(done);
        let every = self.every(args.stride_ms);
        let (scores, _) = evaluate_baseline(&self.0, &recordings, every, &advance)?;
        progress.finish_and_clear();
        let summary = scores.summary(&PERCENTS, &BootstrapConfig::default())?;
        print("network", &summary.raw);
        write_json(args.json.as_deref(), &BTreeMap::from([("network", summary)]))
    }

    fn infer(&self, args: &InferArgs) -> Result<()> {
        let own: OneRecordingArgs = args.own.of(self.task())?;
        let windows = Windows::open(&own.events, &args.opening.options_with_sensor(&own.events)?)?;
        let stream = baseline_stream(&self.0, windows.sensor(), None)?;
        let every = InferenceSchedule::Every(self.every(args.stride_ms));
        write_rows(&mut RecordingStream::new(windows, stream, every), PoseKind::Body, args, &own)
    }

    fn stream(&self, sensor: SensorSize, args: &TaskArgs<Live>) -> Result<Box<dyn OnlineStream>> {
        let NoArgs {} = args.of(self.task())?;
        let stream = baseline_stream(&self.0, sensor, None)?;
        Ok(Box::new(TaskStream::new(stream, 0.0, Skeleton::Body)))
    }
}
