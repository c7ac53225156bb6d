//! Every event is stamped a fixed time after it happened.
//!
//! # Model
//! `t ← t + delay_us`. The part of a camera's latency that depends on light is that of its
//! filters, not of this stage.
//!
//! # Source
//! Lichtsteiner et al. 2008: 15 us at 1 klux.

use super::ClockStage;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};

const DELAY: Parameter = Parameter::Number(NumberSpec {
    name: "delay_us",
    unit: "us",
    range: (1.0, 1e6),
    typical: Some((10.0, 5000.0)),
    doc: "time from an event to its stamp",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "pixel_latency",
    domain: Domain::Clock,
    summary: "events are stamped a fixed time late",
    formula: "t = t + delay_us",
    params: &[DELAY],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "every stamp late by the same time",
        probe: Probe::StampError,
        strength: Strength::Rising(&["delay_us"]),
        beside: &[],
    },
    build: |settings| {
        let delay_s = settings.number(&DELAY) * 1e-6;
        Ok(Stage::Clock(Box::new(PixelLatency { delay_s })))
    },
};

#[derive(Debug)]
struct PixelLatency {
    delay_s: f64,
}

impl ClockStage for PixelLatency {
    fn shown(&self, t_s: f64) -> f64 {
        t_s + self.delay_s
    }
}
