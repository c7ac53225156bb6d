//! The registry entry of a stage: enough to parse it, list it, document it and fit it.

use std::fmt;

use crate::{
    EffectConfig, NumberSpec, Parameter, SensorError, Setting, Settings, Signature, Stage, Strength,
};

/// The place of a stage in the camera, in the order of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Domain {
    /// Luminance to irradiance: what the lens does.
    Optics,
    /// Irradiance to photocurrent.
    Photodiode,
    /// Photocurrent to log voltage.
    Photoreceptor,
    /// Log voltage to requests for an event.
    Detector,
    /// Requests that no change of light has caused.
    Background,
    /// Requests to events: who is served, and when.
    Readout,
    /// Event times to timestamps.
    Clock,
}

impl Domain {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Optics => "optics",
            Self::Photodiode => "photodiode",
            Self::Photoreceptor => "photoreceptor",
            Self::Detector => "detector",
            Self::Background => "background",
            Self::Readout => "readout",
            Self::Clock => "clock",
        }
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The entry of one stage in the registry.
pub struct StageSpec {
    /// The name in configurations and reports, and the key of the stage's noise.
    pub name: &'static str,
    /// Place in the signal path.
    pub domain: Domain,
    /// Effect of the stage, in one sentence.
    pub summary: &'static str,
    /// Effect on its signal, in the names of its parameters.
    pub formula: &'static str,
    /// Physical quantities that it depends on, choices among variants of the stage, and files of
    /// measurements that it reads, in this order.
    pub params: &'static [Parameter],
    /// Source of the model.
    pub source: Citation,
    /// How the effect shows in events or in a measurement.
    pub signature: Signature,
    /// Makes the stage from checked settings.
    pub build: fn(&Settings) -> Result<Stage, SensorError>,
}

impl StageSpec {
    /// The keys that the stage takes in a configuration.
    pub fn keys(&self) -> Vec<&'static str> {
        self.params.iter().map(Parameter::name).collect()
    }

    /// Its physical quantities.
    pub fn number_params(&self) -> impl Iterator<Item = &'static NumberSpec> + use<> {
        self.params.iter().filter_map(Parameter::as_number)
    }

    /// The parameters of `effect`, checked and complete.
    ///
    /// # Errors
    /// Keys that the stage does not have, values that they cannot take, and a missing quantity that
    /// has no neutral value.
    pub fn settings(&self, effect: &EffectConfig) -> Result<Settings, SensorError> {
        let given: Vec<_> =
            effect.params.iter().map(|(key, value)| (key.as_str(), value.given())).collect();
        let refused = |error| SensorError::Parameter { effect: self.name, error };
        let settings = Settings::resolve(self.params, &given).map_err(refused)?;
        settings.complete(self.params).map_err(refused)
    }

    /// Whether these settings make the stage the identity, so that the chain leaves it out: what makes
    /// the effect stronger has the value without effect, and so has what acts alone. A stage in a place
    /// of which a sensor has one cannot be left out.
    pub(crate) fn is_neutral(&self, settings: &Settings) -> bool {
        let names = match self.signature.strength {
            Strength::Rising(names) | Strength::Falling(names) => Some(names),
            Strength::RisingAlone(_) => None,
            Strength::Unchanging => return false,
            // Values and words only complete what files and texts say.
            Strength::FromFiles => {
                let says =
                    |setting: &Setting| matches!(setting, Setting::File(..) | Setting::Text(..));
                return !settings.iter().any(|(_, setting)| says(setting));
            }
        };
        let counts = |number: &&NumberSpec| {
            number.acts_alone || names.is_none_or(|names| names.contains(&number.name))
        };
        let is_off = |number: &NumberSpec| number.default == Some(settings.number(number.name));
        self.number_params().filter(counts).all(is_off)
    }

    /// The stage with the values that are typical of cameras.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn typical_stage(&self) -> Result<Stage, SensorError> {
        (self.build)(&self.settings(&self.typical())?)
    }
}

impl fmt::Debug for StageSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StageSpec").field("name", &self.name).finish_non_exhaustive()
    }
}

/// A quantity on a logarithmic scale that has no effect at zero, its default.
pub(crate) const LOG_OFF_AT_ZERO: NumberSpec = NumberSpec { default: Some(0.0), ..NumberSpec::LOG };
/// A quantity on a linear scale that has no effect at zero, its default.
pub(crate) const LINEAR_OFF_AT_ZERO: NumberSpec =
    NumberSpec { default: Some(0.0), ..NumberSpec::LINEAR };

/// A publication.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Citation {
    /// Authors and year, for tables.
    pub key: &'static str,
    /// Enough to find it.
    pub text: &'static str,
}

/// Publications that several effects are from.
impl Citation {
    pub(crate) const FINATEU_2020: Self = Self {
        key: "Finateu et al. 2020",
        text: "T. Finateu et al.: A 1280x720 Back-Illuminated Stacked Temporal Contrast Event-Based \
               Vision Sensor, ISSCC 2020",
    };
    pub(crate) const HU_2021: Self = Self {
        key: "Hu et al. 2021",
        text: "Y. Hu, S.-C. Liu, T. Delbruck: v2e: From Video Frames to Realistic DVS Events, CVPR \
               Workshops 2021",
    };
    pub(crate) const JOUBERT_2021: Self = Self {
        key: "Joubert et al. 2021",
        text: "D. Joubert et al.: Event Camera Simulator Improvements via Characterized Parameters, \
               Frontiers in Neuroscience 15, 2021",
    };
    pub(crate) const LICHTSTEINER_2008: Self = Self {
        key: "Lichtsteiner et al. 2008",
        text: "P. Lichtsteiner, C. Posch, T. Delbruck: A 128x128 120 dB 15 us Latency Asynchronous \
               Temporal Contrast Vision Sensor, IEEE JSSC 43(2), 2008",
    };
    pub(crate) const NOZAKI_2017: Self = Self {
        key: "Nozaki and Delbruck 2017",
        text: "Y. Nozaki, T. Delbruck: Temperature and Parasitic Photocurrent Effects in Dynamic \
               Vision Sensors, IEEE TED 64(8), 2017",
    };
    pub(crate) const REBECQ_2018: Self = Self {
        key: "Rebecq et al. 2018",
        text: "H. Rebecq, D. Gehrig, D. Scaramuzza: ESIM: an Open Event Camera Simulator, CoRL 2018",
    };
    pub(crate) const RUDNEV_2021: Self = Self {
        key: "Rudnev et al. 2021",
        text: "V. Rudnev et al.: EventHands: Real-Time Neural 3D Hand Pose Estimation from an Event \
               Stream, ICCV 2021, supplement",
    };
}
