//! A photodiode conducts a little without light.
//!
//! # Model
//! `I ← I + current`, relative to the photocurrent of white: counts fall below a knee of
//! brightness, both polarities alike, at any speed.
//!
//! # Source
//! Nozaki and Delbruck 2017.

use evpose_core::StageNoise;

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const CURRENT: Parameter = Parameter::Number(NumberSpec {
    name: "current",
    unit: "white",
    range: (1e-7, 1.0),
    typical: Some((1e-4, 1e-2)),
    doc: "current without light, relative to the photocurrent of white",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "dark_current",
    domain: Domain::Photodiode,
    summary: "a constant is added to the photocurrent",
    formula: "I = I + current",
    params: &[CURRENT],
    source: Citation::NOZAKI_2017,
    signature: Signature {
        look_for: "counts fall below a knee of brightness, both polarities alike and at any \
                   speed",
        probe: Probe::Contrast,
        strength: Strength::Rising(&["current"]),
        beside: &[],
    },
    build: |settings| {
        let current = settings.number(&CURRENT) as f32;
        Ok(Stage::Pixel(Box::new(DarkCurrent { current })))
    },
};

#[derive(Debug)]
struct DarkCurrent {
    current: f32,
}

impl PixelStage for DarkCurrent {
    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        vectorize(
            #[inline(always)]
            || block.signal.iter_mut().for_each(|i| *i += self.current),
        );
    }
}
