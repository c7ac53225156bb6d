//! Light makes the memory leak: stray photons reach the junction that holds it.
//!
//! # Model
//! `dM/dt = -hz_per_white I C_on`, on top of any leak in the dark, from a phase of its own in every
//! pixel, or with `phase = "aligned"` from none.
//!
//! # Source
//! Nozaki and Delbruck 2017: at high light, leak events grow with illumination.

use evpose_core::StageNoise;

use super::leak_on::PHASE;
use super::{PixelTerm, PixelTraits};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};

const RATE: Parameter = Parameter::Number(NumberSpec {
    name: "hz_per_white",
    unit: "Hz",
    range: (1e-4, 1e3),
    typical: Some((0.01, 1.0)),
    doc: "ON events of a resting pixel per second at the light of white",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "parasitic_photo_leak",
    domain: Domain::Detector,
    summary: "light makes the memory leak, in proportion",
    formula: "dM/dt = -hz_per_white I C_on",
    params: &[RATE, PHASE],
    source: Citation::NOZAKI_2017,
    signature: Signature {
        look_for: "ON events at rest, at a rate in proportion to light",
        probe: Probe::RateByLight,
        strength: Strength::Rising(&["hz_per_white"]),
        beside: &[],
    },
    build: |settings| {
        let hz_per_white = settings.number(&RATE) as f32;
        let is_random = settings.word(&PHASE) == Some("random");
        Ok(Stage::Term(Box::new(ParasiticPhotoLeak { hz_per_white, is_random })))
    },
};

#[derive(Debug)]
struct ParasiticPhotoLeak {
    hz_per_white: f32,
    is_random: bool,
}

impl PixelTerm for ParasiticPhotoLeak {
    fn pattern(&self, _pixel: usize, traits: &mut PixelTraits, _noise: StageNoise) {
        traits.photo_leak_hz += self.hz_per_white;
    }

    /// Pixels have been leaking for long: each is somewhere in its interval.
    fn first_phase(&self, pixel: usize, noise: StageNoise) -> f32 {
        if self.is_random { 1.0 - noise.uniform(pixel, 0) } else { 0.0 }
    }
}
