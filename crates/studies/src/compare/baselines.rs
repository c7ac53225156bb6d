//! Networks of others, trained here: their configs, scaled as MoveEnet is, and their trainings.

use anyhow::Result;
use evpose_cli::progress::{say, training_bar};
use evpose_nn::{BaselineNetworkConfig, DeviceKind};
use evpose_task::baseline::BaselineConfig;
use evpose_train::baseline::{baseline_frames, train_baseline};

use crate::compare::data::Data;
use crate::compare::networks;
use crate::compare::stages::Stages;
use crate::compare::system::BaselineKind;
use crate::study::{StudyDirectory, Training};

/// Side of MoveEnet's input as published, in pixels.
const PUBLISHED_SIDE_PX: f64 = 192.0;
/// Sides of inputs are multiples of it, in pixels.
const SIDE_STEP_PX: f64 = 4.0;
/// The smallest side, in pixels.
const MIN_SIDE_PX: f64 = 32.0;

impl BaselineKind {
    /// The training beside that of `stages`: the same recordings, steps and batches; input and channels
    /// in proportion to the published ones as those of MoveEnet are.
    pub(crate) fn config(self, stages: &Stages) -> BaselineConfig {
        let experiment = &stages.finetune;
        let mut config = match self {
            Self::Dhp19Cnn => BaselineConfig::dhp19_cnn(),
            Self::LiftMono => BaselineConfig::lift_mono(),
        };
        let scale = experiment.image.side_px as f64 / PUBLISHED_SIDE_PX;
        #[expect(clippy::float_cmp, reason = "the published size is kept to the pixel")]
        if scale != 1.0 {
            let side = |published: usize| {
                let scaled = published as f64 * scale / SIDE_STEP_PX;
                (scaled.round() * SIDE_STEP_PX).max(MIN_SIDE_PX) as usize
            };
            let (width_px, height_px) = (config.image.width_px, config.image.height_px);
            config = config.with_size(side(width_px), side(height_px));
        }
        match &mut config.network {
            BaselineNetworkConfig::Dhp19Cnn(network) => network.width = experiment.network.width,
            BaselineNetworkConfig::LiftMono(network) => network.width = experiment.network.width,
        }
        // With the view and the filter of MoveEnet, both networks see the same events.
        config.image.view = experiment.image.view;
        config.image.denoise = experiment.image.denoise;
        config.of_experiment(experiment)
    }
}

/// Trains a baseline under a seed, unless it is finished.
pub(crate) fn train(
    (name, kind): (&str, BaselineKind),
    study: &StudyDirectory,
    data: &Data,
    stages: &Stages,
    device: DeviceKind,
) -> Result<()> {
    let seed = stages.finetune.seed;
    let run = networks::directory(study, name, seed);
    if Training::is_finished(&run) {
        return Ok(());
    }
    let directory = data.train(study, stages)?;
    let config = kind.config(stages);
    let (progress, callback) = training_bar(name);
    let samples = config.training.steps * config.training.batch_size as u64;
    let speed = Training { run: &run, device, samples }.once(callback, |options| {
        // Frames are read in here, so that a process that waited for another one reads none.
        let frames = baseline_frames(&config, &directory, &|_| {})?;
        Ok(train_baseline(&config, frames, &run, options)?)
    })?;
    progress.finish_and_clear();
    if let Some(speed) = speed {
        say(format!("    {name}, seed {seed}: trained, {speed:.0} images/s"));
    }
    Ok(())
}
