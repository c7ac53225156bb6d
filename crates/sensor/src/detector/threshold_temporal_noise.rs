//! The comparator is noisy: a threshold is another one at every event.
//!
//! # Model
//! After each event of a pixel, and at the start, `C_on` and `C_off` are the pixel's own plus
//! `sigma N`, none below 0.01. Event times then scatter by `sigma / |dV/dt|`, without a fixed
//! pattern.
//!
//! # Source
//! Joubert et al. 2021 (IEBCS) redraw thresholds in this way.

use evpose_core::{Polarity, StageNoise};

use super::threshold_mismatch::MIN_THRESHOLD;
use super::{PixelTerm, PixelTraits};
use crate::search_spec::SearchSpec;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, ParamSpec, Prior, Scale, StageSpec};

const SIGMA: ParamSpec = ParamSpec {
    name: "sigma",
    unit: "ln",
    range: (1e-4, 1.0),
    scale: Scale::Log,
    prior: Prior::Typical(0.01, 0.1),
    neutral: Some(0.0),
    doc: "standard deviation of a threshold from event to event",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "threshold_temporal_noise",
    domain: Domain::Detector,
    summary: "thresholds are redrawn after every event",
    formula: "C = max(0.01, C + sigma N(event))",
    params: &[SIGMA],
    choices: &[],
    files: &[],
    source: Citation {
        key: "Joubert et al. 2021",
        text: "D. Joubert et al.: Event Camera Simulator Improvements via Characterized Parameters, \
               Frontiers in Neuroscience 15, 2021",
    },
    signature: Signature {
        look_for: "times of crossings scatter about those of the ideal sensor, by the change of \
                   threshold over the slope; no fixed pattern",
        probe: Probe::StampError,
        strength: Strength::Rising(&["sigma"]),
        beside: &[],
    },
    search: SearchSpec { dither: &[("sigma", 0.004)], ..SearchSpec::PLAIN },
    build: |settings| {
        let sigma = settings.number(&SIGMA) as f32;
        Ok(Stage::Term(Box::new(ThresholdTemporalNoise { sigma })))
    },
};

/// Fresh thresholds for every event.
#[derive(Debug)]
struct ThresholdTemporalNoise {
    sigma: f32,
}

impl PixelTerm for ThresholdTemporalNoise {
    fn is_neutral(&self) -> bool {
        self.sigma <= 0.0
    }

    fn renews(&self) -> bool {
        true
    }

    fn renew(
        &self,
        pixel: usize,
        count: u32,
        _last: Option<Polarity>,
        traits: &mut PixelTraits,
        noise: StageNoise,
    ) {
        // Draw indices wrap around after a billion events of one pixel.
        let draw = count.wrapping_mul(2) & 0x3fff_ffff;
        let redraw = |threshold: f32, draw: u32| {
            (threshold + self.sigma * noise.normal(pixel, draw)).max(MIN_THRESHOLD)
        };
        traits.threshold_on = redraw(traits.threshold_on, draw);
        traits.threshold_off = redraw(traits.threshold_off, draw + 1);
    }
}
