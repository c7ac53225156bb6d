//! The change detector of v2e: whole thresholds between a frame and the memory, spread in time.
//!
//! # Model
//! With `d = V - M`: `n = ⌊d / C_on⌋` ON or `n = ⌊-d / C_off⌋` OFF events, `M += ± n C`. With `N`
//! the largest count of any pixel in this step, event `i = 0 .. n - 1` of a pixel is at
//! `t_start + (i + 1) dt / N`: a pixel with few events has them early.
//!
//! A deaf time ([`refractory`](super::refractory), `defer`) is looked at and remembered in those
//! steps only in which it is longer than `dt / N`, and noise leaves none behind. `times = "single"`
//! measures it, as published, on seconds in single precision: where it is a multiple of `dt / N`,
//! rounding then decides whether an event is lost.
//!
//! # Source
//! Hu, Liu, Delbruck 2021 (v2e) and its published emulator.

use evpose_core::{Polarity, StageNoise};

use super::{Change, ChangeDetector, PixelStep, THRESHOLD_OFF, THRESHOLD_ON};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{ChoiceSpec, Citation, Domain, StageSpec};

const TIMES: ChoiceSpec = ChoiceSpec {
    name: "times",
    allowed: &["exact", "single"],
    doc: "whether deaf times are exact, or rounded to single precision as published",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "frame_count",
    domain: Domain::Detector,
    summary: "whole thresholds between frame and memory, spread evenly over the step",
    formula: "n = floor(|V - M| / threshold); M += n threshold; t = start + (i + 1) dt / max n",
    params: &[THRESHOLD_ON, THRESHOLD_OFF],
    choices: &[TIMES],
    files: &[],
    source: Citation {
        key: "Hu et al. 2021",
        text: "Y. Hu, S.-C. Liu, T. Delbruck: v2e: From Video Frames to Realistic DVS Events, CVPR \
               Workshops 2021",
    },
    signature: Signature {
        look_for: "events of a step at a few even times, those of pixels with few events early",
        probe: Probe::Trace,
        strength: Strength::Rising(&["threshold_on", "threshold_off"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(FrameCount {
            thresholds: [&THRESHOLD_ON, &THRESHOLD_OFF].map(|p| settings.number(p) as f32),
            rounds_times: settings.word(&TIMES) == "single",
        })))
    },
};

/// Thresholds in units of ln, and how times are compared.
#[derive(Debug)]
struct FrameCount {
    thresholds: [f32; 2],
    rounds_times: bool,
}

impl ChangeDetector for FrameCount {
    fn thresholds(&self) -> [f32; 2] {
        self.thresholds
    }

    fn compares_frames(&self) -> bool {
        true
    }

    fn spreads(&self) -> bool {
        true
    }

    fn rounds_times(&self) -> bool {
        self.rounds_times
    }

    fn next(&self, pixel: &PixelStep, _from_s: f64, _noise: StageNoise) -> Option<Change> {
        let d = pixel.to - pixel.memory;
        let (polarity, threshold) = if d > 0.0 {
            (Polarity::On, pixel.threshold_on)
        } else {
            (Polarity::Off, pixel.threshold_off)
        };
        // Truncation is the floor of a positive number; a dead pixel has an infinite threshold.
        let count = (d.abs() / threshold) as u32;
        let memory = pixel.memory + (f64::from(count) * threshold).copysign(d);
        (count > 0).then_some(Change { t_s: pixel.end_s, polarity, count, memory })
    }
}
