//! The photoreceptor takes time, the more the less light there is.
//!
//! # Model
//! `τ(I) dV/dt = V_in - V`, `τ = 1 / (2 π f)`, `f = cutoff_hz (I + dark_light)`, with the light at
//! the end of the step; `light = "none"` takes `f = cutoff_hz`. `V_in` runs in a line within a step
//! and the filter follows it exactly: second order in the step for constant light.
//! That is a circuit near its working point. `signal = "large"` is the whole of it: a photocurrent
//! charges a node whose own current grows exponentially with its voltage,
//! `τ(I) dV/dt = 1 - exp(V - V_in)`, so that light that comes is followed faster than light that
//! goes. `w = exp(-V)` makes it linear, `τ dw/dt = exp(-V_in) - w`, and it is followed exactly for
//! light that is constant over a step; bandwidth is that of the mean of both its ends.
//! `step = "euler"` is v2e's form: `V += min(1, dt / τ) (V_in - V)`, first order.
//!
//! # Source
//! Lichtsteiner et al. 2008, figure 9, for bandwidth in proportion to light; Hu et al. 2021 (v2e);
//! Graca, Delbruck 2025 for large signals.

use std::f64::consts::TAU;

use evpose_core::StageNoise;

use super::pole::Pole;
use crate::exponential::exp_m1;
use crate::natural_log::ln;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, WordSpec};
use evpose_cpu::vectorize;

const CUTOFF: Parameter = Parameter::Number(NumberSpec {
    name: "cutoff_hz",
    unit: "Hz",
    range: (0.01, 1e7),
    typical: Some((30.0, 3000.0)),
    default: Some(f64::INFINITY),
    doc: "cut-off frequency at the light of white",
    ..NumberSpec::LOG
});

pub(super) const DARK_LIGHT: Parameter = Parameter::Number(NumberSpec {
    name: "dark_light",
    unit: "white",
    range: (1e-6, 1.0),
    typical: Some((1e-3, 0.1)),
    doc: "light that the bandwidth in the dark amounts to",
    ..LOG_OFF_AT_ZERO
});

const LIGHT: Parameter = Parameter::Word(WordSpec {
    name: "light",
    allowed: &["proportional", "none"],
    default: Some("proportional"),
    doc: "whether bandwidth grows with light",
});

const STEP: Parameter = Parameter::Word(WordSpec {
    name: "step",
    allowed: &["exact", "euler"],
    default: Some("exact"),
    doc: "exact for inputs that run in a line, or v2e's explicit step",
});

const SIGNAL: Parameter = Parameter::Word(WordSpec {
    name: "signal",
    allowed: &["small", "large"],
    default: Some("small"),
    doc: "the same speed up and down, or faster towards light than away from it (with bandwidth \
          in proportion to light and exact steps)",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "photoreceptor_lowpass",
    domain: Domain::Photoreceptor,
    summary: "voltage follows light with a delay, by the light",
    formula: "dV/dt = 2 pi cutoff_hz (I + dark_light) (V_in - V)",
    params: &[CUTOFF, DARK_LIGHT, LIGHT, STEP, SIGNAL],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "events trail behind a fast edge and fewer of them come; the response is \
                   exponential and slower in the dark, in proportion to 1 / light",
        probe: Probe::StepResponse,
        strength: Strength::Falling(&["cutoff_hz"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Pixel(Box::new(PhotoreceptorLowpass {
            cutoff_hz: settings.number(&CUTOFF),
            dark_light: settings.number(&DARK_LIGHT) as f32,
            depends_on_light: settings.word(&LIGHT) == Some("proportional"),
            is_euler: settings.word(&STEP) == Some("euler"),
            is_large: settings.word(&SIGNAL) == Some("large"),
        })))
    },
};

#[derive(Debug)]
struct PhotoreceptorLowpass {
    cutoff_hz: f64,
    dark_light: f32,
    depends_on_light: bool,
    is_euler: bool,
    is_large: bool,
}

/// `exp(-x)`.
#[inline(always)]
fn reciprocal(x: f32) -> f32 {
    exp_m1(-x) + 1.0
}

impl PhotoreceptorLowpass {
    fn follows_circuit(&self) -> bool {
        self.is_large && self.depends_on_light && !self.is_euler
    }

    /// Time constants in a step, at the light of white.
    fn turns(&self, tick: &Tick) -> f32 {
        (TAU * self.cutoff_hz * tick.dt_s()) as f32
    }
}

impl PixelStage for PhotoreceptorLowpass {
    fn time_constant_s(&self) -> Option<f64> {
        let light = if self.depends_on_light { 1.0 + f64::from(self.dark_light) } else { 1.0 };
        Some(1.0 / (TAU * self.cutoff_hz * light))
    }

    /// Output and input at the end of the step before.
    fn state_planes(&self) -> usize {
        2
    }

    fn init(&self, block: &mut Block<'_>, _noise: StageNoise) {
        for plane in block.state.planes::<2>() {
            plane.copy_from_slice(block.signal);
            if self.follows_circuit() {
                plane.iter_mut().for_each(|x| *x = reciprocal(*x));
            }
        }
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let [output, input] = block.state.planes();
        let turns = self.turns(tick);
        let signal = &mut *block.signal;
        // All forms have a loop of their own: a choice per pixel would not become vectors.
        if !self.depends_on_light && !self.is_euler {
            let pole = Pole::from_step(turns);
            vectorize(
                #[inline(always)]
                || {
                    for ((v, y), x) in signal.iter_mut().zip(output).zip(input) {
                        *y = pole.low(*y, *x, *v);
                        (*x, *v) = (*v, *y);
                    }
                },
            );
            return;
        }
        let (scale, base) =
            if self.depends_on_light { (turns, turns * self.dark_light) } else { (0.0, turns) };
        let light = block.photocurrent;
        if self.is_euler {
            vectorize(
                #[inline(always)]
                || {
                    for ((v, y), i) in signal.iter_mut().zip(output).zip(light) {
                        let a = scale * i + base;
                        // An Euler step of more than one time constant would overshoot; the
                        // published one is limited too.
                        let share = if a < 1.0 { a } else { 1.0 };
                        *y = (1.0 - share) * *y + share * *v;
                        *v = *y;
                    }
                },
            );
            return;
        }
        if self.follows_circuit() {
            vectorize(
                #[inline(always)]
                || {
                    for (((v, y), x), i) in signal.iter_mut().zip(output).zip(input).zip(light) {
                        let now = reciprocal(*v);
                        // The light within the step, to second order: the mean of its two ends.
                        let mean = 0.5 * (i + 1.0 / *x);
                        *y = Pole::from_step(scale * mean + base).low(*y, *x, now);
                        (*x, *v) = (now, -ln(*y));
                    }
                },
            );
            return;
        }
        vectorize(
            #[inline(always)]
            || {
                for (((v, y), x), i) in signal.iter_mut().zip(output).zip(input).zip(light) {
                    *y = Pole::from_step(scale * i + base).low(*y, *x, *v);
                    (*x, *v) = (*v, *y);
                }
            },
        );
    }
}
