//! A pixel that adapts: a high-pass filter, through which steady light does not show.
//!
//! # Model
//! `linear`: `dV/dt = dV_in/dt - V / tau_s`, exact for inputs that run in a line within a step.
//! `sinh`: `dV/dt = dV_in/dt - sinh(0.7 V) / tau_s`: large deviations are forgotten faster. The
//! input's change of a step comes first, then the decay, which is exact.
//! Slow edges lose events, and behind a fast one comes a rebound of the other polarity.
//!
//! # Source
//! Delbruck, Graca, Paluch 2021 and v2e's SCIDVS for `sinh`; the high-pass bias of the IMX636 for
//! `linear`.

use evpose_core::StageNoise;

use super::pole::Pole;
use crate::exponential::exp_m1;
use crate::natural_log::ln;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec, WordSpec};
use evpose_cpu::vectorize;

const TAU_S: Parameter = Parameter::Number(NumberSpec {
    name: "tau_s",
    unit: "s",
    range: (1e-4, 1e4),
    typical: Some((5e-3, 10.0)),
    default: Some(f64::INFINITY),
    doc: "time in which a deviation is forgotten",
    ..NumberSpec::LOG
});

const LAW: Parameter = Parameter::Word(WordSpec {
    name: "law",
    allowed: &["linear", "sinh"],
    default: Some("linear"),
    doc: "whether large deviations are forgotten faster",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "adaptive_highpass",
    domain: Domain::Photoreceptor,
    summary: "steady voltages decay: only changes pass",
    formula: "dV/dt = dV_in/dt - V / tau_s, or - sinh(0.7 V) / tau_s",
    params: &[TAU_S, LAW],
    source: Citation {
        key: "Delbruck et al. 2021",
        text: "T. Delbruck, R. Graca, M. Paluch: Feedback Control of Event Cameras, CVPR Workshops \
               2021",
    },
    signature: Signature {
        look_for: "the response decays to zero: slow edges lose events, and behind an edge \
                   comes a rebound of the other polarity",
        probe: Probe::StepResponse,
        strength: Strength::Falling(&["tau_s"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Pixel(Box::new(AdaptiveHighpass {
            tau_s: settings.number(&TAU_S),
            is_sinh: settings.word(&LAW) == Some("sinh"),
        })))
    },
};

/// Slope of the argument of the hyperbolic sine, from v2e.
const STEEPNESS: f32 = 0.7;

#[derive(Debug)]
struct AdaptiveHighpass {
    tau_s: f64,
    is_sinh: bool,
}

impl PixelStage for AdaptiveHighpass {
    fn time_constant_s(&self) -> Option<f64> {
        Some(self.tau_s)
    }

    /// Output and input at the end of the step before.
    fn state_planes(&self) -> usize {
        2
    }

    /// The pixel has adapted to what it sees first.
    fn init(&self, block: &mut Block<'_>, _noise: StageNoise) {
        let [output, input] = block.state.planes();
        output.fill(0.0);
        input.copy_from_slice(block.signal);
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let [output, input] = block.state.planes();
        let a = (tick.dt_s() / self.tau_s) as f32;
        let signal = &mut *block.signal;
        if self.is_sinh {
            // The exact decay over the step: Euler's would overshoot in a long one.
            let left = 1.0 + exp_m1(-STEEPNESS * a);
            vectorize(
                #[inline(always)]
                || {
                    for ((v, y), x) in signal.iter_mut().zip(output).zip(input) {
                        let moved = *y + (*v - *x);
                        *x = *v;
                        // tanh(k V / 2) falls exponentially.
                        let e = exp_m1(STEEPNESS * moved);
                        let tanh = left * e / (e + 2.0);
                        *y = ln((1.0 + tanh) / (1.0 - tanh)) / STEEPNESS;
                        *v = *y;
                    }
                },
            );
        } else {
            // All pixels have one time constant, so that one pole serves them.
            let pole = Pole::from_step(a);
            vectorize(
                #[inline(always)]
                || {
                    for ((v, y), x) in signal.iter_mut().zip(output).zip(input) {
                        *y = pole.high(*y, *x, *v);
                        (*x, *v) = (*v, *y);
                    }
                },
            );
        }
    }
}
