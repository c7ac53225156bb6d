//! The refractory period: a pixel makes no events for a while after each one.
//!
//! # Model
//! Events of a pixel are at least `period_us` apart. In between
//! - `hold`: the reset switch stays closed, and the memory is the voltage at the end: what changed
//!   in the meantime is lost;
//! - `defer`: the memory stays, and an event that is due comes at the end: late, not lost;
//! - `drop`: the memory goes on stepping, and its events are lost: ESIM's form.
//!
//! # Source
//! Lichtsteiner et al. 2008 for the circuit; Rebecq et al. 2018 (ESIM) for `drop`; Hu et al. 2021
//! (v2e) for `defer`, which with frames means until the next one.

use super::{PixelTerm, Recovery};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits, WordSpec,
};

const PERIOD: Parameter = Parameter::Number(NumberSpec {
    name: "period_us",
    unit: "us",
    range: (1.0, 1e6),
    typical: Some((10.0, 4e4)),
    doc: "the shortest time between two events of a pixel",
    ..LOG_OFF_AT_ZERO
});

const MODE: Parameter = Parameter::Word(WordSpec {
    name: "mode",
    allowed: &["hold", "defer", "drop"],
    default: Some("hold"),
    doc: "whether the memory follows the voltage, waits, or goes on without saying so",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "refractory",
    domain: Domain::Detector,
    summary: "a pixel makes no events for a refractory period",
    formula: "no event before t + period_us; hold: M = V(t + period_us)",
    params: &[PERIOD, MODE],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "no intervals below the period, and a pile-up just above it; fast and strong \
                   changes lose events",
        probe: Probe::BusyIntervals,
        strength: Strength::Rising(&["period_us"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(Refractory {
            period_s: settings.number(&PERIOD) / 1e6,
            holds: settings.word(&MODE) == Some("hold"),
            drops: settings.word(&MODE) == Some("drop"),
        })))
    },
};

#[derive(Debug)]
struct Refractory {
    period_s: f64,
    holds: bool,
    drops: bool,
}

impl PixelTerm for Refractory {
    fn traits(&self) -> Traits {
        let follows_s = if self.holds { self.period_s } else { 0.0 };
        let recovery = Recovery { refractory_s: self.period_s, follows_s, ..Recovery::default() };
        Traits { recovery, steps_while_refractory: self.drops, ..Traits::default() }
    }
}
