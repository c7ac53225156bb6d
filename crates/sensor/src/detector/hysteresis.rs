//! A pixel is slower to take back what it said: the threshold of the other sign is larger.
//!
//! # Model
//! After an ON event `C_off ← C_off (1 + fraction)` until the next event, and after an OFF event
//! the same for `C_on`. Noise about a level then makes fewer pairs of ON and OFF.
//!
//! # Source
//! Hysteresis of comparators; a bias of the Prophesee sensors (Finateu et al. 2020) separates the
//! two thresholds in the same way.

use evpose_core::{Polarity, StageNoise};

use super::{PixelTerm, PixelTraits};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (0.001, 5.0),
    typical: Some((0.01, 0.5)),
    doc: "how much larger the threshold of the other sign is, as a part of it",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "hysteresis",
    domain: Domain::Detector,
    summary: "after an event the threshold of the other sign is larger",
    formula: "C_other = C_other (1 + fraction) until the next event",
    params: &[FRACTION],
    source: Citation::FINATEU_2020,
    signature: Signature {
        look_for: "fewer pairs of ON and OFF: after an event of one sign, the first one of the \
                   other comes later",
        probe: Probe::Trace,
        strength: Strength::Rising(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        let factor = 1.0 + settings.number(&FRACTION) as f32;
        Ok(Stage::Term(Box::new(Hysteresis { factor })))
    },
};

#[derive(Debug)]
struct Hysteresis {
    factor: f32,
}

impl PixelTerm for Hysteresis {
    fn traits(&self) -> Traits {
        Traits { renews: true, ..Traits::default() }
    }

    fn renew(
        &self,
        _pixel: usize,
        _count: u32,
        last: Option<Polarity>,
        traits: &mut PixelTraits,
        _noise: StageNoise,
    ) {
        match last {
            Some(Polarity::On) => traits.threshold_off *= self.factor,
            Some(Polarity::Off) => traits.threshold_on *= self.factor,
            None => {}
        }
    }
}
