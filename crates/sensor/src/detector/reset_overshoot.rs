//! A reset does not end where the event was: the memory takes a little time, or goes a little far.
//!
//! # Model
//! `M = V(t + delay_us)`: what changes while the switch is closed is lost. Without delay,
//! `M = M ± C (1 - fraction)`: the switch injects charge that takes back a part of the step, or
//! adds to it where the fraction is negative. `to_exposure` is a delay of that fraction of the time
//! to the exposure behind the event: at 1 a pixel has one event per frame at most, and its memory
//! is the voltage of that frame, as in simulators that reset to the present voltage.
//!
//! # Source
//! Lichtsteiner et al. 2008 on charge injection at reset; Joubert et al. 2021 (IEBCS) for a reset
//! to the voltage of the frame.

use super::{PixelTerm, Recovery};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits,
};

const DELAY: Parameter = Parameter::Number(NumberSpec {
    name: "delay_us",
    unit: "us",
    range: (0.1, 1e4),
    typical: Some((1.0, 100.0)),
    doc: "how long the reset switch stays closed",
    ..LOG_OFF_AT_ZERO
});

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (-0.9, 0.9),
    typical: Some((-0.2, 0.2)),
    doc: "part of the step that the reset takes back",
    ..LINEAR_OFF_AT_ZERO
});

const TO_EXPOSURE: Parameter = Parameter::Number(NumberSpec {
    name: "to_exposure",
    range: (0.0, 1.0),
    typical: Some((0.0, 1.0)),
    doc: "fraction of the time to the next exposure for which the switch stays closed",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "reset_overshoot",
    domain: Domain::Detector,
    summary: "after an event the memory is not exactly at the level crossed",
    formula: "M = V(t + delay_us), M +- C (1 - fraction), or M = V(exposure)",
    params: &[DELAY, FRACTION, TO_EXPOSURE],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "after an event the signal does not start from zero: a positive fraction \
                   makes the next event come sooner, a negative one later",
        probe: Probe::Trace,
        strength: Strength::RisingAlone(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(ResetOvershoot {
            delay_s: settings.number(&DELAY) * 1e-6,
            fraction: settings.number(&FRACTION),
            to_exposure: settings.number(&TO_EXPOSURE),
        })))
    },
};

#[derive(Debug)]
struct ResetOvershoot {
    delay_s: f64,
    fraction: f64,
    to_exposure: f64,
}

impl PixelTerm for ResetOvershoot {
    fn traits(&self) -> Traits {
        let recovery = Recovery {
            refractory_s: self.delay_s,
            follows_s: self.delay_s,
            to_exposure: self.to_exposure,
            short_fraction: self.fraction,
        };
        Traits { recovery, ..Traits::default() }
    }
}
