//! The fixed pattern of one camera, or of another simulator, pixel by pixel from files.
//!
//! # Model
//! `C_on(x, y)`, `C_off(x, y)` and `rho(x, y)` are what the files say. They take the place of what
//! effects listed before this one have drawn; what no file gives stays as it is.
//!
//! # Source
//! Wang et al. 2019 for how thresholds of single pixels are measured.

use evpose_core::{SensorSize, StageNoise};

use super::threshold_mismatch::MIN_THRESHOLD;
use super::{PixelTerm, PixelTraits};
use crate::map::{MapFault, PixelMap};
use crate::stage::Stage;
use crate::{
    Citation, Domain, FileSpec, Parameter, Probe, SensorError, Settings, Signature, StageSpec,
    Strength, Traits,
};

const THRESHOLD_ON: Parameter = Parameter::File(FileSpec {
    name: "threshold_on",
    unit: "ln",
    doc: "ON threshold of every pixel, at least 0.01: .npy of shape (height, width), f4 or f8",
});

const THRESHOLD_OFF: Parameter = Parameter::File(FileSpec {
    name: "threshold_off",
    unit: "ln",
    doc: "OFF threshold of every pixel, likewise",
});

const LEAK: Parameter = Parameter::File(FileSpec {
    name: "leak_hz",
    unit: "Hz",
    doc: "ON events of every pixel at rest per second, not negative, likewise",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "fixed_pattern",
    domain: Domain::Detector,
    summary: "thresholds and leaks of every pixel as measured",
    formula: "C_on(x, y), C_off(x, y), rho(x, y) from files",
    params: &[THRESHOLD_ON, THRESHOLD_OFF, LEAK],
    source: Citation {
        key: "Wang et al. 2019",
        text: "Z. Wang, Y. Ng, P. van Goor, R. Mahony: Event Camera Calibration of Per-pixel \
               Biased Contrast Threshold, ACRA 2019",
    },
    signature: Signature {
        look_for: "the same events as from the camera that was measured, pixel by pixel, in every \
                   run and from every seed",
        probe: Probe::RampMap,
        strength: Strength::FromFiles,
        beside: &[],
    },
    build: |settings| Ok(Stage::Term(Box::new(FixedPattern::read(settings)?))),
};

#[derive(Debug)]
struct FixedPattern {
    size: Option<SensorSize>,
    threshold_on: Vec<f32>,
    threshold_off: Vec<f32>,
    leak_hz: Vec<f32>,
}

impl FixedPattern {
    fn read(settings: &Settings) -> Result<Self, SensorError> {
        let mut size = None;
        let mut values = |file: &Parameter, least| -> Result<Vec<f32>, SensorError> {
            let Some(path) = settings.file(file) else { return Ok(Vec::new()) };
            let map = PixelMap::read(path, least).and_then(|map| match size {
                Some(other) if other != map.size => Err(MapFault::OtherSize(map.size)),
                _ => Ok(map),
            });
            let (effect, key, path) = (SPEC.name, file.name(), path.to_owned());
            let map = map.map_err(|fault| SensorError::Map { effect, key, path, fault })?;
            size = Some(map.size);
            Ok(map.values)
        };
        let threshold_on = values(&THRESHOLD_ON, MIN_THRESHOLD)?;
        let threshold_off = values(&THRESHOLD_OFF, MIN_THRESHOLD)?;
        let leak_hz = values(&LEAK, 0.0)?;
        Ok(Self { size, threshold_on, threshold_off, leak_hz })
    }
}

impl PixelTerm for FixedPattern {
    fn traits(&self) -> Traits {
        Traits { made_for: self.size, ..Traits::default() }
    }

    fn pattern(&self, pixel: usize, traits: &mut PixelTraits, _noise: StageNoise) {
        let take = |values: &[f32], of: &mut f32| {
            if let Some(&value) = values.get(pixel) {
                *of = value;
            }
        };
        take(&self.threshold_on, &mut traits.threshold_on);
        take(&self.threshold_off, &mut traits.threshold_off);
        take(&self.leak_hz, &mut traits.leak_hz);
    }
}
