//! Some pixels have no events.
//!
//! # Model
//! Each pixel is dead with probability `fraction`, for good: it has no events, nor noise.
//!
//! # Source
//! A fixed mask, as recordings show it.

use evpose_core::StageNoise;

use super::{PixelTerm, PixelTraits};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (1e-6, 0.5),
    typical: Some((1e-5, 1e-3)),
    doc: "part of the pixels that are dead",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "dead_pixels",
    domain: Domain::Detector,
    summary: "some pixels have no events",
    formula: "no events where U(x, y) < fraction",
    params: &[FRACTION],
    source: Citation {
        key: "Gallego et al. 2022",
        text: "G. Gallego et al.: Event-Based Vision: A Survey, IEEE TPAMI 44(1), 2022",
    },
    signature: Signature {
        look_for: "single pixels without any event where all others have some",
        probe: Probe::RampMap,
        strength: Strength::Rising(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        let fraction = settings.number(&FRACTION) as f32;
        Ok(Stage::Term(Box::new(DeadPixels { fraction })))
    },
};

#[derive(Debug)]
struct DeadPixels {
    fraction: f32,
}

impl PixelTerm for DeadPixels {
    fn traits(&self) -> Traits {
        Traits { is_static: true, ..Traits::default() }
    }

    fn pattern(&self, pixel: usize, traits: &mut PixelTraits, noise: StageNoise) {
        traits.is_dead |= noise.uniform(pixel, 0) <= self.fraction;
    }
}
