//! The file that describes a hand experiment from the scene to the metric.

use std::path::PathBuf;

use evpose_camera::Calibration;
use evpose_clean::Denoise;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::{Micros, SensorSize};
use evpose_nn::{
    HandHead, HandLossConfig, HandRegressorConfig, JointLossConfig, JointNet, backbone_by_name,
};
use evpose_pose::filter::{BodyFilterConfig, HandFilterConfig, StillnessConfig};
use evpose_repr::{ChannelOrder, WindowAugmentation};
use evpose_sim::SimulationConfig;
use serde::{Deserialize, Serialize};

use super::camera_turns::CameraTurnConfig;
use super::detection::HandDetectionConfig;
use super::slow_motion::SlowMotionConfig;
use super::two_pass::TwoPassConfig;
use super::view::canonical_view;
use crate::experiment::require;
use crate::schedule::{Schedule, TrainingPrecision};
use crate::{Experiment, NetworkInput, TaskError};

/// Rows of a fine view for each of a usual one.
const FINER_VIEW: f32 = 2.0;

/// The filter of joints: of one noise for all. With noises by score, joints of one hand lag by different times, and hands
/// of others were further off in space than without a filter.
const JOINT_FILTER: BodyFilterConfig =
    BodyFilterConfig { cutoff_hz: 6.0, score_exponent: 0.0, max_gap_s: 0.5 };

fn is_joint_filter(filter: &BodyFilterConfig) -> bool {
    *filter == JOINT_FILTER
}

/// Everything about a hand experiment. `Default` is the published setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandConfig {
    /// `"hand"`.
    pub task: String,
    /// Seed of every random stream of the experiment.
    pub seed: u64,
    /// A finished run, or a file of weights, to begin with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_from: Option<PathBuf>,
    /// Scene, motion and camera, and the amount of recordings.
    pub simulation: SimulationConfig,
    /// Input of the network.
    pub representation: RepresentationConfig,
    /// Augmentation of training windows.
    pub augmentation: WindowAugmentation,
    /// Turns of the camera of training windows.
    #[serde(skip_serializing_if = "CameraTurnConfig::is_none")]
    pub camera_turns: CameraTurnConfig,
    /// A second pass on a crop about the hand; none shows the network the whole view as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_pass: Option<TwoPassConfig>,
    /// Shape of the network.
    pub network: HandRegressorConfig,
    /// Scales of the loss.
    pub loss: HandLossConfig,
    /// Weights of the loss of a network of joints.
    #[serde(skip_serializing_if = "JointLossConfig::is_default")]
    pub joint_loss: JointLossConfig,
    /// Optimiser and duration.
    pub training: TrainingConfig,
    /// Windows with fewer events than this repeat the last pose; none infers them all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold: Option<StillnessConfig>,
    /// When a pose is reported.
    #[serde(skip_serializing_if = "HandDetectionConfig::is_default")]
    pub detection: HandDetectionConfig,
    /// Temporal filter of predictions.
    pub filter: HandFilterConfig,
    /// Temporal filter of the joints of a network of joints.
    #[serde(skip_serializing_if = "is_joint_filter")]
    pub joint_filter: BodyFilterConfig,
    /// The slow-motion mode.
    pub slow_motion: SlowMotionConfig,
    /// Held-out data.
    pub evaluation: EvaluationConfig,
}

/// The input of the network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RepresentationConfig {
    /// A name from the registry of representations.
    pub name: String,
    /// Length of the window at evaluation, in milliseconds. Training varies it.
    pub window_ms: u32,
    /// The polarity of channel 0.
    pub channel_order: ChannelOrder,
    /// Filter of the events; none keeps them all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoise: Option<Denoise>,
}

impl RepresentationConfig {
    /// Length of the window at evaluation.
    pub fn window(&self) -> Micros {
        Micros(1_000 * i64::from(self.window_ms))
    }
}

/// How several devices work together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DeviceStrategy {
    /// Distributed data parallel: a replica on each device, gradients averaged among them.
    #[default]
    Ddp,
    /// Gradients summed on the first device, which optimises for all.
    MainDevice,
}

/// Optimiser and duration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingConfig {
    /// Windows per optimiser step, of all devices together.
    pub batch_size: usize,
    /// Number of devices that share the windows of every step.
    pub devices: usize,
    /// How several devices work together.
    pub strategy: DeviceStrategy,
    /// Initial learning rate of Adam.
    pub learning_rate: f64,
    /// Schedule of the learning rate; constant as published.
    pub schedule: Schedule,
    /// Number format of the convolutions.
    #[serde(skip_serializing_if = "TrainingPrecision::is_default")]
    pub precision: TrainingPrecision,
    /// Optimiser steps of the whole run. With 0, only what follows a training is done, with the network that it starts
    /// from.
    pub steps: u64,
    /// Optimiser steps between validations, each of which writes a checkpoint.
    pub steps_per_validation: u64,
    /// Length of the start of every sequence that is held out for validation, in seconds.
    pub validation_s: f64,
    /// Maximum number of windows of a validation.
    pub validation_samples: u64,
    /// Images that the presence of a network of joints is fitted to when its training is over; 0 leaves it as it was
    /// trained.
    #[serde(skip_serializing_if = "is_zero")]
    pub presence_samples: u64,
    /// Whether the noise of the filters is estimated from the validation residuals of the best
    /// network, instead of taken from the config.
    pub estimate_filter: bool,
}

/// Held-out data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluationConfig {
    /// Number of sequences.
    pub sequences: usize,
    /// Length of each, in seconds.
    pub seconds: f64,
    /// Time of the first evaluated pose, in milliseconds from the start: before it no window is
    /// full.
    pub first_ms: u32,
    /// Bootstrap of the confidence intervals.
    pub bootstrap: BootstrapConfig,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Default for HandConfig {
    fn default() -> Self {
        Self {
            task: Self::TASK.to_owned(),
            seed: 1,
            start_from: None,
            simulation: SimulationConfig::default(),
            representation: RepresentationConfig::default(),
            augmentation: WindowAugmentation::default(),
            camera_turns: CameraTurnConfig::default(),
            two_pass: None,
            network: HandRegressorConfig::default(),
            loss: HandLossConfig::default(),
            joint_loss: JointLossConfig::default(),
            training: TrainingConfig::default(),
            hold: None,
            detection: HandDetectionConfig::default(),
            filter: HandFilterConfig::default(),
            joint_filter: JOINT_FILTER,
            slow_motion: SlowMotionConfig::default(),
            evaluation: EvaluationConfig::default(),
        }
    }
}

impl Default for RepresentationConfig {
    fn default() -> Self {
        Self {
            name: "lnes".to_owned(),
            window_ms: 100,
            channel_order: ChannelOrder::OffFirst,
            denoise: None,
        }
    }
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self {
            batch_size: 64,
            devices: 1,
            strategy: DeviceStrategy::default(),
            learning_rate: 1e-3,
            schedule: Schedule::constant(),
            precision: TrainingPrecision::default(),
            // Not published; one pass over the 159 million published training windows.
            steps: 2_484_375,
            steps_per_validation: 15_000,
            validation_s: 250.0,
            validation_samples: 20_000,
            presence_samples: 0,
            estimate_filter: false,
        }
    }
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self { sequences: 1, seconds: 1200.0, first_ms: 100, bootstrap: BootstrapConfig::default() }
    }
}

impl HandConfig {
    /// The experiment's held-out recordings: their number and length, and a seed nothing else uses.
    #[must_use]
    pub fn held_out(&self) -> Self {
        let mut config = self.clone();
        // Without the highest bit: whole numbers of TOML have a sign.
        config.seed = evpose_core::seed_for(self.seed, "held out", 0) >> 1;
        config.simulation.sequences = self.evaluation.sequences;
        config.simulation.seconds = self.evaluation.seconds;
        config
    }

    /// The config for events of a camera. Crops for networks of joints are taken from a view of twice the rows and
    /// columns, where the camera resolves them: pooled to the view that the networks are trained with, most of the
    /// thin edges of slow fingers are gone.
    #[must_use]
    pub fn for_camera(&self, calibration: &Calibration) -> Self {
        let mut config = self.clone();
        let is_cropped = self.network.head == HandHead::Joints && self.two_pass.is_some();
        let focal_px = calibration.camera.focal_px.min_element();
        let view_px = f64::from(canonical_view(self).pinhole.focal_px);
        if is_cropped && focal_px >= f64::from(FINER_VIEW) * view_px {
            config.simulation.image_scale *= FINER_VIEW;
        }
        config
    }

    /// Size of the network's images: of the canonical view, or of crops of it.
    pub fn network_size(&self) -> SensorSize {
        self.two_pass.map_or(self.simulation.image_size(), |two_pass| two_pass.size)
    }
}

impl Experiment for HandConfig {
    const TASK: &'static str = "hand";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn input(&self) -> Option<NetworkInput<'_>> {
        Some(NetworkInput {
            representation: ("representation.name", &self.representation.name),
            denoise: ("representation.denoise", self.representation.denoise),
            channels: (2, "has more channels than the network, which takes 2"),
        })
    }

    fn validate_own(&self) -> Result<(), TaskError> {
        self.simulation.validate()?;
        let CameraTurnConfig { roll_deg, tilt_deg } = self.camera_turns;
        let are_turns_valid = (0.0..=180.0).contains(&roll_deg) && (0.0..=45.0).contains(&tilt_deg);
        let (image, backbone) = (self.network_size(), backbone_by_name(&self.network.backbone)?);
        // The strides of a backbone leave nothing of smaller images.
        let is_large = usize::from(image.width.min(image.height)) >= backbone.smallest_px;
        let too_small = format!(
            "{} takes images of at least {} pixels a side, these are {image}: choose another, or a \
             larger simulation.image_scale or two_pass.size",
            backbone.name, backbone.smallest_px
        );
        let is_of_joints = self.network.head == HandHead::Joints;
        let has_pyramid = self.network.backbone == HandHead::BACKBONE;
        let multiple = |side: u16| usize::from(side).is_multiple_of(JointNet::SIDE_MULTIPLE);
        let are_multiples = multiple(image.width) && multiple(image.height);
        let not_multiples = format!(
            "joints takes images whose sides are multiples of {}, these are {image}: choose another \
             two_pass.size, such as 128 x 96",
            JointNet::SIDE_MULTIPLE
        );
        require(&[
            (!is_of_joints || has_pyramid, "network.backbone", "of joints is resnet18"),
            (!is_of_joints || are_multiples, "network.head", not_multiples.as_str()),
            (
                self.joint_loss.is_valid(),
                "joint_loss",
                "weights must be at least 0, a deviation above",
            ),
            (are_turns_valid, "camera_turns", "roll_deg must be 0 to 180, tilt_deg 0 to 45"),
            (
                self.detection.is_valid(),
                "detection",
                "min_active, min_presence and min_score are shares: 0 to 1",
            ),
            (is_large, "network.backbone", too_small.as_str()),
        ])
    }

    /// Checks crops as well: recordings need not be of the network's view, and are brought to it.
    fn validate_training(&self) -> Result<(), TaskError> {
        let TrainingConfig { batch_size, devices, validation_s, .. } = self.training;
        self.training.schedule.validate()?;
        let view = self.simulation.image_size();
        let are_crops_valid = self.two_pass.is_none_or(|two_pass| two_pass.is_valid(view));
        let crops = "size must be of the view's proportions and no larger, distance_m above 0, \
                     max_zoom at least 1, and shares 0 to 1";
        let are_shared = batch_size.is_multiple_of(devices);
        let shared = "must divide training.batch_size, whose windows they share";
        let is_whole = validation_s * 1e3 >= f64::from(self.representation.window_ms);
        let part = "holds no whole window: must be at least representation.window_ms";
        let is_rest = validation_s < self.simulation.seconds;
        let nothing = "leaves nothing to train on: must be shorter than simulation.seconds";
        require(&[
            (are_crops_valid, "two_pass", crops),
            (are_shared, "training.devices", shared),
            (is_whole, "training.validation_s", part),
            (is_rest, "training.validation_s", nothing),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HAND: &str = "task = \"hand\"\n";

    #[test]
    fn an_override_changes_one_field() {
        let overrides = ["training.steps=7".to_owned(), "representation.name=eoi".to_owned()];
        let config = HandConfig::parse(&format!("{HAND}seed = 4"), &overrides).unwrap();
        assert_eq!((config.seed, config.training.steps), (4, 7));
        assert_eq!(config.representation.name, "eoi");
    }

    #[test]
    fn an_unknown_field_is_named() {
        let text = format!("{HAND}[training]\nstepz = 3");
        let error = HandConfig::parse(&text, &[]).unwrap_err().to_string();
        assert!(error.contains("stepz"), "{error}");
    }

    #[test]
    fn views_are_finer_before_cameras_of_many_pixels_for_networks_of_joints_alone() {
        let view = |config: &HandConfig, width, height| {
            let sensor = SensorSize { width, height };
            let calibration = Calibration::from_vertical_fov(sensor, 45.0);
            canonical_view(&config.for_camera(&calibration)).sensor
        };
        let text = "task = \"hand\"";
        let size = "two_pass.size={ width = 128, height = 96 }";
        let joints = ["network.head=joints".to_owned(), size.to_owned()];
        let joints = HandConfig::parse(text, &joints).unwrap();
        let regressor = HandConfig::parse(text, &["two_pass={}".to_owned()]).unwrap();
        let usual = joints.simulation.image_size();
        let finer = SensorSize { width: 2 * usual.width, height: 2 * usual.height };
        assert_eq!(view(&joints, usual.width, usual.height), usual);
        assert_eq!(view(&joints, 1280, 960), finer);
        assert_eq!(view(&regressor, 1280, 960), usual);
    }

    #[test]
    fn an_image_too_small_for_the_backbone_is_refused() {
        let with = |scale: &str| {
            let overrides = ["network.backbone=vgg11_bn".to_owned(), scale.to_owned()];
            HandConfig::parse(HAND, &overrides)
        };
        assert!(with("simulation.image_scale=0.25").is_ok());
        let error = with("simulation.image_scale=0.15").unwrap_err().to_string();
        assert!(error.contains("network.backbone") && error.contains("32 pixels"), "{error}");
    }

    #[test]
    fn a_simulation_may_be_of_another_shape_than_the_crops_of_the_network() {
        let overrides = [
            "two_pass={ size = { width = 96, height = 72 } }",
            "simulation.sensor_size={ width = 1280, height = 720 }",
        ];
        let overrides = overrides.map(str::to_owned);
        let error = HandConfig::parse(HAND, &overrides).unwrap_err().to_string();
        assert!(error.contains("two_pass"), "{error}");
        let config = HandConfig::unchecked(HAND, &overrides).unwrap();
        config.validate_simulation().unwrap();
        assert_eq!(config.two_pass.map(|two_pass| two_pass.size.width), Some(96));
    }

    #[test]
    fn a_simulation_may_be_shorter_than_a_training_needs() {
        let short = ["simulation.seconds=2".to_owned()];
        HandConfig::unchecked(HAND, &short).unwrap().validate_simulation().unwrap();
        let error = HandConfig::parse(HAND, &short).unwrap_err().to_string();
        assert!(error.contains("training.validation_s"), "{error}");
        let wrong = ["simulation.seconds=-2".to_owned()];
        assert!(HandConfig::unchecked(HAND, &wrong).unwrap().validate_simulation().is_err());
    }
}
