//! The buffer behind the photoreceptor: a second pole that light does not move.
//!
//! # Model
//! `τ dV/dt = V_in - V`, `τ = 1 / (2 π cutoff_hz)`, exact for inputs that run in a line within a
//! step.
//!
//! # Source
//! Lichtsteiner et al. 2008: the source follower isolates the photoreceptor from the switching
//! behind it. It limits bandwidth in bright light.

use std::f64::consts::TAU;

use evpose_core::StageNoise;

use super::pole::Pole;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const CUTOFF: Parameter = Parameter::Number(NumberSpec {
    name: "cutoff_hz",
    unit: "Hz",
    range: (0.01, 1e7),
    typical: Some((100.0, 10_000.0)),
    default: Some(f64::INFINITY),
    doc: "cut-off frequency",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "source_follower",
    domain: Domain::Photoreceptor,
    summary: "a second pole behind the photoreceptor, at any light",
    formula: "dV/dt = 2 pi cutoff_hz (V_in - V)",
    params: &[CUTOFF],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "an exponential response that is the same in bright and in dark light",
        probe: Probe::StepResponse,
        strength: Strength::Falling(&["cutoff_hz"]),
        beside: &[],
    },
    build: |settings| {
        let cutoff_hz = settings.number(&CUTOFF);
        Ok(Stage::Pixel(Box::new(SourceFollower { cutoff_hz })))
    },
};

#[derive(Debug)]
struct SourceFollower {
    cutoff_hz: f64,
}

impl PixelStage for SourceFollower {
    fn time_constant_s(&self) -> Option<f64> {
        Some(1.0 / (TAU * self.cutoff_hz))
    }

    /// Output and input at the end of the step before.
    fn state_planes(&self) -> usize {
        2
    }

    fn init(&self, block: &mut Block<'_>, _noise: StageNoise) {
        for plane in block.state.planes::<2>() {
            plane.copy_from_slice(block.signal);
        }
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let [output, input] = block.state.planes();
        let pole = Pole::from_step((TAU * self.cutoff_hz * tick.dt_s()) as f32);
        vectorize(
            #[inline(always)]
            || {
                for ((v, y), x) in block.signal.iter_mut().zip(output).zip(input) {
                    *y = pole.low(*y, *x, *v);
                    (*x, *v) = (*v, *y);
                }
            },
        );
    }
}
