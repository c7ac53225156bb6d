//! The camera's clock is not that of the scene: it starts at another time and runs at another rate.
//!
//! # Model
//! `t ← t (1 + drift_ppm 1e-6) + offset_us`.
//!
//! # Source
//! Two free-running quartz clocks differ by tens of parts per million (Allan 1987).

use super::ClockStage;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};

const OFFSET: Parameter = Parameter::Number(NumberSpec {
    name: "offset_us",
    unit: "us",
    range: (-1e6, 1e6),
    typical: Some((-1e4, 1e4)),
    acts_alone: true,
    doc: "what the clock shows at time zero",
    ..LINEAR_OFF_AT_ZERO
});

const DRIFT: Parameter = Parameter::Number(NumberSpec {
    name: "drift_ppm",
    unit: "ppm",
    range: (-1e5, 1e5),
    typical: Some((-100.0, 100.0)),
    doc: "how much too fast the clock runs, in millionths",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "clock_offset_drift",
    domain: Domain::Clock,
    summary: "stamps are those of a clock with another start and another rate",
    formula: "t = t (1 + drift_ppm 1e-6) + offset_us",
    params: &[OFFSET, DRIFT],
    source: Citation {
        key: "Allan 1987",
        text: "D. W. Allan: Time and Frequency Characterization, Estimation, and Prediction of \
               Precision Clocks and Oscillators, IEEE TUFFC 34(6), 1987",
    },
    signature: Signature {
        look_for: "stamps run away from the times of the scene along a line, its slope the \
                   drift",
        probe: Probe::StampError,
        strength: Strength::Rising(&["drift_ppm"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Clock(Box::new(ClockOffsetDrift {
            offset_s: settings.number(&OFFSET) * 1e-6,
            drift: settings.number(&DRIFT) * 1e-6,
        })))
    },
};

#[derive(Debug)]
struct ClockOffsetDrift {
    offset_s: f64,
    drift: f64,
}

impl ClockStage for ClockOffsetDrift {
    fn earliest_shown(&self, t_s: f64) -> f64 {
        self.shown(t_s)
    }

    fn shown(&self, t_s: f64) -> f64 {
        t_s + t_s * self.drift + self.offset_s
    }
}
