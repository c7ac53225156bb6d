//! The file that describes an experiment with a baseline.

use std::path::PathBuf;

use evpose_clean::Denoise;
use evpose_nn::{BaselineNetworkConfig, Dhp19CnnConfig};
use serde::{Deserialize, Serialize};

use crate::body::{
    BodyConfig, BodyDataConfig, BodyImageConfig, BodySourceKind, BodyTrainingConfig, BodyViewKind,
    Interpolation,
};
use crate::experiment::require;
use crate::{Experiment, NetworkInput, TaskError};

/// Events of an image, as published.
pub(super) const EVENTS: usize = 7_500;

/// Everything about an experiment with a baseline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineConfig {
    /// `"baseline"`.
    pub task: String,
    /// Seed of every random stream of the experiment.
    pub seed: u64,
    /// Directory of the run, unless the command line gives another.
    pub out: PathBuf,
    /// A finished run, or a file of weights, to begin with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_from: Option<PathBuf>,
    /// Training data: recordings.
    pub data: BodyDataConfig,
    /// Input of the network.
    pub image: BaselineImageConfig,
    /// Kind and shape of the network.
    pub network: BaselineNetworkConfig,
    /// The target heatmaps.
    pub loss: BaselineLossConfig,
    /// Decoding of the heatmaps.
    pub decoding: BaselineDecodingConfig,
    /// Optimiser and duration. The optimiser is Adam; DHP19's authors took RMSprop.
    pub training: BodyTrainingConfig,
}

/// The input of the network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineImageConfig {
    /// A name from the registry of representations, with its parameters.
    pub representation: String,
    /// The events that the representation is made of.
    pub view: BodyViewKind,
    /// Filter of those events; none keeps them all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoise: Option<Denoise>,
    /// Interpolation of resizing.
    pub interpolation: Interpolation,
    /// Columns of the network's input.
    pub width_px: usize,
    /// Rows of the network's input.
    pub height_px: usize,
}

/// The target heatmaps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineLossConfig {
    /// Standard deviation of a joint on the heatmaps, in pixels of the input for `dhp19-cnn`, in
    /// cells of the maps for `lift-mono`.
    pub sigma_px: f32,
}

/// Decoding of the heatmaps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineDecodingConfig {
    /// Of `dhp19-cnn`: a joint of a lower score stays where it was found last.
    pub confidence: f32,
}

impl BaselineConfig {
    /// The same at another size of the input. The heatmaps of `dhp19-cnn` keep their size relative
    /// to it.
    #[must_use]
    pub fn with_size(mut self, width_px: usize, height_px: usize) -> Self {
        if matches!(self.network, BaselineNetworkConfig::Dhp19Cnn(_)) {
            // Its sigma is in pixels of the input; that of
            // `lift-mono` is in cells, which scale along.
            self.loss.sigma_px *= height_px as f32 / self.image.height_px as f32;
        }
        self.image = BaselineImageConfig { width_px, height_px, ..self.image };
        self
    }

    /// The same with the seed, the recordings, and the length of the training of an experiment with
    /// MoveEnet, for comparisons.
    #[must_use]
    pub fn of_experiment(self, experiment: &BodyConfig) -> Self {
        let training = &experiment.training;
        Self {
            seed: experiment.seed,
            data: BodyDataConfig {
                source: BodySourceKind::Recordings,
                // The time of a label depends on the representation, which is that of the baseline.
                label_at: self.data.label_at,
                // A frame of fixed count forgets old noise, which only an EROS accumulates.
                noise_history: None,
                ..experiment.data.clone()
            },
            training: BodyTrainingConfig {
                batch_size: training.batch_size,
                steps: training.steps,
                steps_per_validation: training.steps_per_validation,
                validation_samples: training.validation_samples,
                early_stop: training.early_stop,
                ..self.training
            },
            ..self
        }
    }

    /// The recordings of this experiment as those of an experiment with MoveEnet.
    pub fn body(&self) -> BodyConfig {
        let BaselineImageConfig { representation, view, denoise, interpolation, .. } = &self.image;
        BodyConfig {
            seed: self.seed,
            data: self.data.clone(),
            image: BodyImageConfig {
                representation: representation.clone(),
                // The blur belongs to the EROS of MoveEnet, not to frames of fixed count.
                blur: None,
                interpolation: *interpolation,
                view: *view,
                denoise: *denoise,
                ..BodyImageConfig::default()
            },
            ..BodyConfig::default()
        }
    }
}

impl Experiment for BaselineConfig {
    const TASK: &'static str = "baseline";

    fn seed(&self) -> u64 {
        self.seed
    }

    fn input(&self) -> Option<NetworkInput<'_>> {
        Some(NetworkInput {
            representation: ("image.representation", &self.image.representation),
            denoise: ("image.denoise", self.image.denoise),
            channels: (1, "must have one channel"),
        })
    }

    fn validate_own(&self) -> Result<(), TaskError> {
        self.data.validate(self.network.joints())?;
        let step = match &self.network {
            BaselineNetworkConfig::Dhp19Cnn(_) => Dhp19CnnConfig::SIDE_STEP_PX,
            BaselineNetworkConfig::LiftMono(_) => 1,
        };
        let sides = [self.image.width_px, self.image.height_px];
        let are_whole = sides.iter().all(|side| *side >= 16 && side.is_multiple_of(step));
        let size = "width_px and height_px must be at least 16, and multiples of 4 for dhp19-cnn";
        let is_share = (0.0..=1.0).contains(&self.decoding.confidence);
        let is_recorded = self.data.source == BodySourceKind::Recordings;
        require(&[
            (is_recorded, "data.source", "must be \"recordings\""),
            (are_whole, "image", size),
            (self.loss.sigma_px > 0.0, "loss.sigma_px", "must be above 0"),
            (is_share, "decoding.confidence", "must be 0 to 1"),
        ])
    }

    fn validate_training(&self) -> Result<(), TaskError> {
        self.training.validate()?;
        let is_plain = !self.training.calibrate_confidence;
        require(&[
            (is_plain, "training.calibrate_confidence", "is for networks of MoveEnet"),
            (self.training.precision.is_default(), "training.precision", "must be \"f32\""),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::LabelTime;

    #[test]
    fn published_settings_make_sense_and_come_back_from_text() {
        for config in [
            BaselineConfig::dhp19_cnn(),
            BaselineConfig::lift_mono(),
            BaselineConfig::lift_mono().with_size(96, 72),
        ] {
            config.validate().unwrap();
            let text = config.to_toml().unwrap();
            assert_eq!(BaselineConfig::parse(&text, &[]).unwrap(), config);
        }
    }

    #[test]
    fn heatmaps_of_smaller_inputs_are_smaller() {
        let config = BaselineConfig::dhp19_cnn().with_size(172, 130);
        assert_eq!(config.loss.sigma_px, 2.0);
        assert_eq!(BaselineConfig::lift_mono().with_size(128, 96).loss.sigma_px, 1.0);
    }

    #[test]
    fn faults_are_named_by_their_field() {
        let fault = |set: &str| {
            let message = BaselineConfig::parse("task = \"baseline\"", &[set.to_owned()])
                .unwrap_err()
                .to_string();
            message.split('`').nth(1).unwrap_or(&message).to_owned()
        };
        assert_eq!(fault("image.width_px=345"), "image");
        assert_eq!(fault("loss.sigma_px=0"), "loss.sigma_px");
        assert_eq!(fault("decoding.confidence=2"), "decoding.confidence");
        assert_eq!(fault("data.source=\"stills\""), "data.source");
        assert_eq!(fault("training.batch_size=0"), "training.batch_size");
        assert_eq!(fault("training.precision=f16"), "training.precision");
        let text = "task = \"baseline\"\n[network]\nkind = \"dhp19-cnn\"\nstages = 3";
        let message = BaselineConfig::parse(text, &[]).unwrap_err().to_string();
        assert!(message.contains("stages"), "{message}");
    }

    #[test]
    fn an_experiment_gives_its_data_and_its_length_but_not_its_labels() {
        let mut experiment = BodyConfig { seed: 7, ..BodyConfig::default() };
        (experiment.training.steps, experiment.data.every_ms) = (30, 20);
        let config = BaselineConfig::lift_mono().of_experiment(&experiment);
        assert_eq!((config.seed, config.training.steps, config.data.every_ms), (7, 30, 20));
        assert_eq!(config.data.label_at, LabelTime::MeanOf(EVENTS));
        assert_eq!(config.training.learning_rate, 3e-4);
        config.validate().unwrap();
    }
}
