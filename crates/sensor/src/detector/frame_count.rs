//! The change detector of v2e: whole thresholds between a frame and the memory, spread in time.
//!
//! # Model
//! With `d = V - M`: `n = ⌊d / C_on⌋` ON or `n = ⌊-d / C_off⌋` OFF events, `M += ± n C`. With `N`
//! the largest count of any pixel in this step, event `i = 0 .. n - 1` of a pixel is at
//! `t_start + (i + 1) dt / N`: a pixel with few events has them early.
//!
//! A refractory period ([`refractory`](super::refractory), `defer`) is looked at and remembered in
//! those steps only in which it is longer than `dt / N`, and noise leaves none behind.
//!
//! `rounding = "published"` works in single precision where the published emulator does:
//! - Refractory periods are measured on seconds so rounded: where one is a multiple of `dt / N`,
//!   rounding decides whether an event is lost.
//! - Unless a stage acts on the voltage behind the photoreceptor, which makes it one of double
//!   precision there, `d` and `M` are rounded after every operation, and what leaks in a step is
//!   taken off `M` at once: `M -= (dt ρ) C_on`. A small leak is then larger or smaller, in every
//!   step by the same: by up to 1 % at 0.1 Hz and 1000 frames per second.
//!
//! # Source
//! Hu, Liu, Delbruck 2021 (v2e) and its published emulator.

use evpose_core::{Polarity, StageNoise};

use super::{Change, ChangeDetector, PixelStep, THRESHOLD_OFF, THRESHOLD_ON};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Compares, Domain, Parameter, StageSpec, Traits, WordSpec};

const ROUNDING: Parameter = Parameter::Word(WordSpec {
    name: "rounding",
    allowed: &["exact", "published"],
    default: Some("exact"),
    doc: "whether refractory periods and leaks are exact, or rounded to single precision as published",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "frame_count",
    domain: Domain::Detector,
    summary: "whole thresholds between frame and memory, spread evenly over the step",
    formula: "n = floor(|V - M| / threshold); M += n threshold; t = start + (i + 1) dt / max n",
    params: &[THRESHOLD_ON, THRESHOLD_OFF, ROUNDING],
    source: Citation::HU_2021,
    signature: Signature {
        look_for: "events of a step at a few even times, those of pixels with few events early",
        probe: Probe::Trace,
        strength: Strength::Rising(&["threshold_on", "threshold_off"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Detector(Box::new(FrameCount {
            thresholds: [&THRESHOLD_ON, &THRESHOLD_OFF].map(|p| settings.number(p) as f32),
            rounds_as_published: settings.word(&ROUNDING) == Some("published"),
        })))
    },
};

#[derive(Debug)]
struct FrameCount {
    thresholds: [f32; 2],
    rounds_as_published: bool,
}

impl ChangeDetector for FrameCount {
    fn thresholds(&self) -> [f32; 2] {
        self.thresholds
    }

    fn traits(&self) -> Traits {
        Traits {
            compares: Compares::Frames,
            spreads: true,
            rounds_as_published: self.rounds_as_published,
            ..Traits::default()
        }
    }

    fn next(&self, pixel: &PixelStep, _from_s: f64, _noise: StageNoise) -> Option<Change> {
        let d = pixel.difference();
        let (polarity, threshold) = if d > 0.0 {
            (Polarity::On, pixel.threshold_on)
        } else {
            (Polarity::Off, pixel.threshold_off)
        };
        // Truncation is the floor of a positive number; a dead pixel has an infinite threshold.
        let count = (d.abs() / threshold) as u32;
        let memory = pixel.memory_behind(polarity, count);
        (count > 0).then_some(Change { t_s: pixel.end_s, polarity, count, memory })
    }
}
