//! Charge leaks off the memory: ON events without a change of light.
//!
//! # Model
//! `dM/dt = -rho C_on`: a pixel at rest has an ON event every `1 / rho`, with a phase of its own.
//! `rho = rate_hz 10^(spread_decades N)` is fixed per pixel; each interval is longer or shorter by
//! `jitter N`. The leak acts on moving pixels as well, exactly within every step.
//!
//! `frame_jitter` is the form of v2e: in each step all that leaks is larger by `frame_jitter N`.
//!
//! # Source
//! Nozaki and Delbruck 2017; Hu et al. 2021 (v2e) for the spread and the jitter of steps.

use std::ops::Range;

use evpose_core::{Polarity, StageNoise};

use super::{PixelTerm, PixelTraits};
use crate::gaussian::{PIECE, fill_normal};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits, WordSpec,
};
use evpose_cpu::vectorize;

const RATE: Parameter = Parameter::Number(NumberSpec {
    name: "rate_hz",
    unit: "Hz",
    range: (1e-4, 1e3),
    typical: Some((0.01, 1.0)),
    doc: "ON events of a resting pixel per second",
    ..LOG_OFF_AT_ZERO
});

pub(crate) const SPREAD: Parameter = Parameter::Number(NumberSpec {
    name: "spread_decades",
    unit: "decades",
    range: (0.001, 1.0),
    typical: Some((0.1, 0.25)),
    doc: "standard deviation of the logarithm of the rate over the pixels",
    ..LOG_OFF_AT_ZERO
});

const JITTER: Parameter = Parameter::Number(NumberSpec {
    name: "jitter",
    range: (0.001, 0.5),
    typical: Some((0.1, 0.3)),
    doc: "standard deviation of the intervals of one pixel, as a part of their mean",
    ..LOG_OFF_AT_ZERO
});

const FRAME_JITTER: Parameter = Parameter::Number(NumberSpec {
    name: "frame_jitter",
    range: (0.001, 10.0),
    doc: "standard deviation of what leaks in one step, as a part of its mean",
    ..LOG_OFF_AT_ZERO
});

pub(super) const PHASE: Parameter = Parameter::Word(WordSpec {
    name: "phase",
    allowed: &["random", "aligned"],
    default: Some("random"),
    doc: "whether pixels start somewhere in their intervals or all at the beginning",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "leak_on",
    domain: Domain::Detector,
    summary: "charge leaks off the memory and makes regular ON events",
    formula: "dM/dt = -rate_hz 10^(spread_decades N(x, y)) C_on",
    params: &[RATE, SPREAD, JITTER, FRAME_JITTER, PHASE],
    source: Citation::NOZAKI_2017,
    signature: Signature {
        look_for: "ON events only, at rest, at regular intervals that differ from pixel to \
                   pixel: a hump at 1 / rate, not an exponential",
        probe: Probe::RestIntervals,
        strength: Strength::Rising(&["rate_hz"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(LeakOn {
            rate_hz: settings.number(&RATE) as f32,
            spread_decades: settings.number(&SPREAD) as f32,
            jitter: settings.number(&JITTER) as f32,
            frame_jitter: settings.number(&FRAME_JITTER) as f32,
            is_random: settings.word(&PHASE) == Some("random"),
        })))
    },
};

/// An interval is at least this part of the mean one.
const SHORTEST: f32 = 0.05;

#[derive(Debug)]
struct LeakOn {
    rate_hz: f32,
    spread_decades: f32,
    jitter: f32,
    frame_jitter: f32,
    is_random: bool,
}

impl PixelTerm for LeakOn {
    fn pattern(&self, pixel: usize, traits: &mut PixelTraits, noise: StageNoise) {
        let spread = (std::f32::consts::LN_10 * self.spread_decades * noise.normal(pixel, 0)).exp();
        traits.leak_hz += self.rate_hz * spread;
    }

    fn first_phase(&self, pixel: usize, noise: StageNoise) -> f32 {
        // Draws 0 and 1 are in the normal one.
        if self.is_random { 1.0 - noise.uniform(pixel, 2) } else { 0.0 }
    }

    fn traits(&self) -> Traits {
        let (renews, adds_leak) = (self.jitter > 0.0, self.frame_jitter > 0.0);
        Traits { renews, adds_leak, ..Traits::default() }
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
        let interval = 1.0 + self.jitter * noise.normal(pixel, count & 0x3fff_ffff);
        traits.leak_hz /= interval.max(SHORTEST);
    }

    fn add_leak(
        &self,
        tick: &Tick,
        pixels: &Range<usize>,
        leak_per_s: &[f32],
        leaked: &mut [f32],
        noise: StageNoise,
    ) {
        let scale = self.frame_jitter * tick.dt_s() as f32;
        vectorize(
            #[inline(always)]
            || {
                let pieces = leaked.chunks_mut(PIECE).zip(leak_per_s.chunks(PIECE));
                for (piece, (leaked, leak_per_s)) in pieces.enumerate() {
                    // Noise is counted by pixel, so that pieces and bands of threads do not change
                    // it.
                    let mut draws = [0.0; PIECE];
                    fill_normal(noise, pixels.start + piece * PIECE, &mut draws);
                    for ((leaked, leak_per_s), draw) in
                        leaked.iter_mut().zip(leak_per_s).zip(&draws)
                    {
                        *leaked -= scale * leak_per_s * draw;
                    }
                }
            },
        );
    }
}
