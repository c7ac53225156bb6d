//! Frames that were exposed for a while: what moved is blurred along its way.
//!
//! Not a property of a pixel, which has no shutter, but of frames that a camera took or a renderer
//! integrated.
//!
//! # Model
//! The mean of the light over the last `fraction` of the step, in which it runs in a line:
//! `I ← I - fraction / 2 (I - I_before)`.
//!
//! # Source
//! Hu et al. 2021 (v2e) on motion blur of source frames.

use evpose_core::StageNoise;

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (0.001, 1.0),
    typical: Some((0.1, 1.0)),
    doc: "part of the time between frames in which the shutter is open",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "exposure_blur",
    domain: Domain::Optics,
    summary: "frames are means over the time in which a shutter was open",
    formula: "I = I - fraction / 2 (I - I_before)",
    params: &[FRACTION],
    source: Citation::HU_2021,
    signature: Signature {
        look_for: "what moves is smeared along its way: fine moving texture loses events, and \
                   contours are late by half the exposure",
        probe: Probe::Grating,
        strength: Strength::Rising(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        let half = 0.5 * settings.number(&FRACTION) as f32;
        Ok(Stage::Pixel(Box::new(ExposureBlur { half })))
    },
};

/// A mean over the end of a step.
#[derive(Debug)]
struct ExposureBlur {
    half: f32,
}

impl PixelStage for ExposureBlur {
    /// The light of the exposure before.
    fn state_planes(&self) -> usize {
        1
    }

    fn init(&self, block: &mut Block<'_>, _noise: StageNoise) {
        let [before] = block.state.planes();
        before.copy_from_slice(block.signal);
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let [before] = block.state.planes();
        vectorize(
            #[inline(always)]
            || {
                for (y, before) in block.signal.iter_mut().zip(before) {
                    let now = *y;
                    *y = now - self.half * (now - *before);
                    *before = now;
                }
            },
        );
    }
}
