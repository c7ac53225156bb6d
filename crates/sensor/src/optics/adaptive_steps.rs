//! Steps short enough for what happens in them.
//!
//! A chain without time constants is exact for any step: log voltage runs in a line and its
//! crossings are solved for. Filters answer to the line with a curve, of which the chain knows the
//! ends only. Dividing a step brings the curve back.
//!
//! # Model
//! A step is divided in `n = min(max_parts, ⌈max |ΔV| / (C / 2)⌉, ⌈dt / τ⌉)`, whichever of the two
//! is larger, with `ΔV` the change of log voltage of any pixel, `C` the smaller threshold and `τ`
//! the shortest time constant. In between, `ln(I + I_dark)` runs in a line.
//!
//! # Source
//! The criterion of Rebecq et al. 2018 (ESIM), section 3.1, on brightness change.

use super::AdaptiveSteps;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec};

pub(crate) const MAX_PARTS: Parameter = Parameter::Number(NumberSpec {
    name: "max_parts",
    range: (1.0, 1000.0),
    default: Some(1.0),
    doc: "the most parts a step is divided in",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "adaptive_steps",
    domain: Domain::Optics,
    summary: "steps are divided where light changes a lot or a time constant is short",
    formula: "n = min(max_parts, max(max |dV| / (C / 2), dt / tau))",
    params: &[MAX_PARTS],
    source: Citation::REBECQ_2018,
    signature: Signature {
        look_for: "with a filter, whole steps give a step response of straight pieces and late \
                   first events; divided ones come nearer to the exponential",
        probe: Probe::CoarseStepResponse,
        strength: Strength::Rising(&["max_parts"]),
        beside: &["photoreceptor_lowpass"],
    },
    build: |settings| {
        let max_parts = settings.number(&MAX_PARTS).round() as u32;
        Ok(Stage::Steps(AdaptiveSteps { max_parts }))
    },
};
