//! The file that describes an experiment with bodies.

use std::path::PathBuf;

use evpose_clean::Denoise;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_nn::{BodyLossConfig, MoveEnetConfig};
use evpose_pose::body::{BODY_JOINTS, DEFAULT_SOFTENING};
use evpose_pose::filter::{BodyFilter, BodyFilterConfig};
use evpose_repr::{ErosLike, GaussianKernel};
use evpose_sim::config::{BodySource, MotionSource};
use evpose_sim::person::PeopleConfig;
use serde::{Deserialize, Serialize};

use super::augmentation::BodyAugmentation;
use super::detection::BodyDetectionConfig;
use super::resample::Interpolation;
use crate::experiment::require;
use crate::schedule::{EarlyStop, Schedule, TrainingPrecision};
use crate::{Experiment, NetworkInput, TaskError};

/// Minimum score of a joint in the published online program.
const PUBLISHED_CONFIDENCE: f32 = 0.01;

/// Total stride of the encoder, in pixels: sides of images are multiples of it.
const SIDE_STEP_PX: usize = 32;

/// Everything about an experiment with bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyConfig {
    /// `"body"`.
    pub task: String,
    /// Seed of every random stream of the experiment.
    pub seed: u64,
    /// Directory of the run, unless the command line gives another.
    pub out: PathBuf,
    /// A finished run, or a file of weights, to begin with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_from: Option<PathBuf>,
    /// Training data.
    pub data: BodyDataConfig,
    /// People before an event camera, or before one that takes photographs.
    pub simulation: PeopleConfig,
    /// Input of the network.
    pub image: BodyImageConfig,
    /// Augmentation of images and labels.
    pub augmentation: BodyAugmentation,
    /// Shape of the network.
    pub network: MoveEnetConfig,
    /// Weights of the loss.
    pub loss: BodyLossConfig,
    /// Parity of the targets with the published ones.
    pub targets: BodyTargetConfig,
    /// Decoding of the output maps.
    pub decoding: BodyDecodingConfig,
    /// When a pose is reported.
    #[serde(skip_serializing_if = "BodyDetectionConfig::is_default")]
    pub detection: BodyDetectionConfig,
    /// The filter of joints over time.
    #[serde(skip_serializing_if = "BodyFilterConfig::is_default")]
    pub filter: BodyFilterConfig,
    /// Optimiser and duration.
    pub training: BodyTrainingConfig,
    /// Held-out data.
    pub evaluation: BodyEvaluationConfig,
}

/// The source of training images.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodySourceKind {
    /// Photographs of simulated people, as edges that look like an EROS.
    Stills,
    /// The same photographs in grey.
    GreyStills,
    /// Recordings of an event camera with tables of poses: those of `evpose simulate`.
    #[default]
    Recordings,
    /// Photographs at the sample times of simulated recordings, in grey.
    GreyRecordings,
    /// Images and an annotation file: those of `evpose prepare`.
    Annotations,
}

impl BodySourceKind {
    /// Whether a directory of recordings is needed.
    pub fn is_recorded(self) -> bool {
        matches!(self, Self::Recordings | Self::GreyRecordings)
    }
}

/// The training data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyDataConfig {
    /// Source of the images.
    pub source: BodySourceKind,
    /// Number of photographs.
    pub stills: u64,
    /// Time between two samples of a recording, in milliseconds.
    pub every_ms: u32,
    /// Time of the first sample of a recording, in milliseconds: before it there are too few
    /// events.
    pub first_ms: u32,
    /// Time of a sample's label.
    pub label_at: LabelTime,
    /// Noise events per pixel before a recording begins, log-uniform: an EROS does not fade, so
    /// that of a camera that has been on for a while is full of single events but for where
    /// people have moved. Simulated recordings begin with an empty one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_history: Option<NoiseHistory>,
    /// Share of the recordings, or of the images, kept for validation.
    pub validation_share: f64,
    /// Minimum number of labelled joints of a sample.
    // The card of the shipped `body-quick` spells it so.
    #[serde(alias = "fewest_joints")]
    pub min_joints: usize,
}

/// Noise events before a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseHistory {
    /// Probability that a recording has some.
    pub probability: f32,
    /// How many per pixel, log-uniform.
    pub events_per_pixel: [f32; 2],
}

/// The time of a label.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LabelTime {
    /// The time of the image.
    #[default]
    Now,
    /// The mean time stamp of the last events, as many as a frame of fixed count has: `{ mean_of =
    /// 7500 }`.
    MeanOf(usize),
}

/// The input of the network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyImageConfig {
    /// A name from the registry of representations, with its parameters.
    pub representation: String,
    /// Blur of the representation's image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blur: Option<GaussianKernel>,
    /// The conversion of photographs to edges.
    pub eros_like: ErosLike,
    /// Rows and columns of the network's input.
    pub side_px: usize,
    /// Interpolation of resizing, in training that of the augmentation.
    pub interpolation: Interpolation,
    /// The events that the representation is made of.
    pub view: BodyViewKind,
    /// Filter of those events; none keeps them all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoise: Option<Denoise>,
}

/// The events that a representation is made of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyViewKind {
    /// Those of the canonical view of bodies, which is about the same for every sensor: see
    /// [`evpose_camera::CanonicalView::for_bodies`].
    #[default]
    Canonical,
    /// Those of the sensor, whatever its size: as the published programs do.
    Sensor,
}

/// Parity of the targets with the published ones.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyTargetConfig {
    /// Whether targets are as published: see `BodyGrid` of the training.
    pub parity: bool,
}

/// Decoding of the output maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyDecodingConfig {
    /// Joints of a lower score are not found: they are not in view.
    pub confidence: f32,
    /// Offset of distances, in cells: see [`evpose_pose::body::BodyDecoder::softened_by`].
    pub softening_cells: f64,
    /// A second pass on a crop about the person that the first one found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_pass: Option<SecondPass>,
}

/// A second pass of the network, on a crop about the person.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecondPass {
    /// Side of the crop, relative to the longer side of the bounding box of the joints found.
    pub side: f32,
    /// The smallest side, relative to the image.
    pub min_side: f32,
    /// Whether crops of 5/4 and 4/5 of the side, and the mirror images of all, are seen as well: each
    /// joint is then where those of the highest total score lie together.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub consensus: bool,
}

/// Optimiser and duration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyTrainingConfig {
    /// Images per optimiser step.
    pub batch_size: usize,
    /// Initial learning rate of Adam.
    pub learning_rate: f64,
    /// Schedule of the learning rate.
    pub schedule: Schedule,
    /// Weight decay, added to gradients (L2).
    pub weight_decay: f32,
    /// Number format of the convolutions.
    #[serde(skip_serializing_if = "TrainingPrecision::is_default")]
    pub precision: TrainingPrecision,
    /// Optimiser steps of the whole run. With 0, only what follows a training is done, with the network that it starts
    /// from.
    pub steps: u64,
    /// Optimiser steps between validations, each of which writes a checkpoint.
    pub steps_per_validation: u64,
    /// Maximum number of images of a validation.
    pub validation_samples: u64,
    /// Early stopping.
    pub early_stop: EarlyStop,
    /// Whether `decoding.confidence`, `detection.min_score` and, of recordings, `filter` of the best network
    /// are calibrated on the validation images.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub calibrate_confidence: bool,
}

/// Held-out data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyEvaluationConfig {
    /// Number of sequences.
    pub sequences: usize,
    /// Length of each, in seconds.
    pub seconds: f64,
    /// Activities in them; empty for those of the simulation.
    pub activities: Vec<String>,
    /// Share of them in which the camera is held by hand; none for that of the simulation.
    pub moving_cameras: Option<f32>,
    /// Time between two predictions, in milliseconds.
    pub every_ms: u32,
    /// Bootstrap of the confidence intervals.
    pub bootstrap: BootstrapConfig,
}

impl Default for BodyConfig {
    /// Fine-tuning at the published size.
    fn default() -> Self {
        Self {
            task: Self::TASK.to_owned(),
            seed: 1,
            out: PathBuf::from("runs/body/finetune"),
            start_from: None,
            data: BodyDataConfig::default(),
            simulation: PeopleConfig::default(),
            image: BodyImageConfig::default(),
            augmentation: BodyAugmentation::default(),
            network: MoveEnetConfig::default(),
            loss: BodyLossConfig::default(),
            targets: BodyTargetConfig::default(),
            decoding: BodyDecodingConfig::default(),
            detection: BodyDetectionConfig::default(),
            filter: BodyFilterConfig::default(),
            training: BodyTrainingConfig::default(),
            evaluation: BodyEvaluationConfig::default(),
        }
    }
}

impl Default for BodyDataConfig {
    fn default() -> Self {
        Self {
            source: BodySourceKind::default(),
            stills: 6_000,
            every_ms: 50,
            first_ms: 500,
            label_at: LabelTime::Now,
            noise_history: None,
            validation_share: 0.1,
            min_joints: 8,
        }
    }
}

impl Default for BodyImageConfig {
    fn default() -> Self {
        Self {
            representation: "eros".to_owned(),
            blur: Some(GaussianKernel::Five),
            eros_like: ErosLike::default(),
            side_px: 192,
            interpolation: Interpolation::Area,
            view: BodyViewKind::default(),
            denoise: None,
        }
    }
}

impl Default for BodyDecodingConfig {
    /// As published.
    fn default() -> Self {
        Self {
            confidence: PUBLISHED_CONFIDENCE,
            softening_cells: DEFAULT_SOFTENING,
            second_pass: None,
        }
    }
}

impl Default for BodyTrainingConfig {
    fn default() -> Self {
        Self {
            batch_size: 64,
            learning_rate: 1e-3,
            schedule: Schedule::default(),
            precision: TrainingPrecision::default(),
            weight_decay: 1e-3,
            steps: 30_000,
            steps_per_validation: 500,
            validation_samples: 2_000,
            early_stop: EarlyStop::default(),
            calibrate_confidence: false,
        }
    }
}

impl Default for BodyEvaluationConfig {
    fn default() -> Self {
        Self {
            sequences: 40,
            seconds: 5.0,
            activities: Vec::new(),
            moving_cameras: None,
            every_ms: 20,
            bootstrap: BootstrapConfig::default(),
        }
    }
}

impl Experiment for BodyConfig {
    const TASK: &'static str = "body";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn input(&self) -> Option<NetworkInput<'_>> {
        Some(NetworkInput {
            representation: ("image.representation", &self.image.representation),
            denoise: ("image.denoise", self.image.denoise),
            channels: (1, "must have one channel: the network is shown a grey image"),
        })
    }

    fn validate_own(&self) -> Result<(), TaskError> {
        self.simulation.validate()?;
        // Held-out recordings are simulated later, but their faults must be reported now.
        self.held_out().simulation.validate()?;
        self.augmentation.validate(self.network.joints)?;
        BodyFilter::new(self.filter)?;
        self.data.validate(self.network.joints)?;
        let is_whole = self.image.side_px.is_multiple_of(SIDE_STEP_PX);
        let BodyDecodingConfig { softening_cells, second_pass, .. } = self.decoding;
        let is_crop_valid = second_pass.is_none_or(|SecondPass { side, min_side, .. }| {
            (1.0..=8.0).contains(&side) && (0.05..=1.0).contains(&min_side)
        });
        let detection =
            "min_score must be 0 to 1, memory_ms 0 to 60000, min_events_per_pixel 0 to 100";
        require(&[
            (is_whole, "image.side_px", "must be a multiple of 32"),
            (softening_cells > 0.0, "decoding.softening_cells", "must be above 0"),
            (self.detection.is_valid(), "detection", detection),
            (is_crop_valid, "decoding.second_pass", "side must be 1 to 8, min_side 0.05 to 1"),
        ])
    }

    fn validate_training(&self) -> Result<(), TaskError> {
        self.training.validate()
    }
}

impl BodyDataConfig {
    pub(crate) fn validate(&self, joints: usize) -> Result<(), TaskError> {
        let is_noise_valid = self.noise_history.is_none_or(|noise| {
            // Draws are log-uniform, and zero has no logarithm.
            let [low, high] = noise.events_per_pixel;
            (0.0..=1.0).contains(&noise.probability) && 0.0 < low && low <= high && high <= 100.0
        });
        let noise = "probability must be 0 to 1, events_per_pixel a range above 0 and up to 100";
        let is_share = (0.0..1.0).contains(&self.validation_share);
        require(&[
            (is_noise_valid, "data.noise_history", noise),
            (joints == BODY_JOINTS, "network.joints", "labels have 13 joints"),
            (is_share, "data.validation_share", "must be at least 0 and below 1"),
            (self.min_joints <= joints, "data.min_joints", "must be at most `network.joints`"),
        ])
    }
}

impl BodyTrainingConfig {
    pub(crate) fn validate(&self) -> Result<(), TaskError> {
        let is_valid = self.weight_decay >= 0.0;
        require(&[(is_valid, "training.weight_decay", "must not be negative")])?;
        self.schedule.validate()
    }
}

impl BodyConfig {
    /// The experiment's held-out recordings: other people, other places, a seed nothing else uses,
    /// and what the evaluation says that is done. Their bodies and motions are the program's own:
    /// folders of others have the motions of the training, and may be missing elsewhere.
    #[must_use]
    pub fn held_out(&self) -> Self {
        let mut config = self.clone();
        // Without the highest bit: whole numbers of TOML have a sign.
        config.seed = evpose_core::seed_for(self.seed, "held-out people", 0) >> 1;
        config.simulation.sequences = self.evaluation.sequences;
        config.simulation.seconds = self.evaluation.seconds;
        if !self.evaluation.activities.is_empty() {
            config.simulation.activities = self.evaluation.activities.clone();
        }
        if let Some(share) = self.evaluation.moving_cameras {
            config.simulation.moving_cameras = share;
        }
        config.simulation.motion = MotionSource::Activities;
        if matches!(config.simulation.body, BodySource::MakeHuman(_)) {
            config.simulation.body = BodySource::Procedural;
        }
        config
    }
}
