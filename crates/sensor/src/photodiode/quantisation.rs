//! Light in steps: the input came from an 8-bit image or frame buffer.
//!
//! Not a property of a photodiode but of a simulated scene: it makes dark gradients climb in
//! coarse steps of log intensity, which is where such simulations differ most from a camera.
//!
//! # Model
//! `Y ← round(n · clamp(Y, 0, 1)) / n`, halves to even.
//!
//! # Source
//! The published EventHands simulator renders to an 8-bit frame buffer in linear light.

use evpose_core::StageNoise;

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec, Traits};
use evpose_cpu::vectorize;

const LEVELS: Parameter = Parameter::Number(NumberSpec {
    name: "levels",
    unit: "steps",
    range: (1.0, 65_535.0),
    default: Some(f64::INFINITY),
    doc: "steps between black and white; 255 for 8 bits",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "quantisation",
    domain: Domain::Photodiode,
    summary: "light comes in equal steps between black and white",
    formula: "Y = round(levels * clamp(Y, 0, 1)) / levels",
    params: &[LEVELS],
    source: Citation::RUDNEV_2021,
    signature: Signature {
        look_for: "in the dark, light climbs in coarse steps: bursts of events at once and none \
                   in between; dark gradients show contour lines",
        probe: Probe::Contrast,
        strength: Strength::Falling(&["levels"]),
        beside: &[],
    },
    build: |settings| Ok(Stage::Pixel(Box::new(Quantisation::new(settings.number(&LEVELS))))),
};

/// Adding and taking away 1.5 · 2²³ leaves an `f32` without fraction: rounding that every
/// processor can do on vectors.
const ROUNDER: f32 = 12_582_912.0;

#[derive(Debug)]
struct Quantisation {
    levels: f32,
}

impl Quantisation {
    fn new(levels: f64) -> Self {
        Self { levels: levels as f32 }
    }
}

impl PixelStage for Quantisation {
    fn traits(&self) -> Traits {
        Traits { is_static: true, ..Traits::default() }
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let step = 1.0 / self.levels;
        vectorize(
            #[inline(always)]
            || {
                for y in block.signal.iter_mut() {
                    let code = y.clamp(0.0, 1.0) * self.levels;
                    *y = ((code + ROUNDER) - ROUNDER) * step;
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::State;

    fn quantised(levels: f64, mut values: Vec<f32>) -> Vec<f32> {
        let pixels = 0..values.len();
        let state = State::new(&mut [], pixels.clone());
        let mut block = Block { pixels, photocurrent: &[], signal: &mut values, state };
        let tick = Tick { start_s: 0.0, end_s: 0.0, index: 0 };
        Quantisation::new(levels).step(&tick, &mut block, StageNoise::new(0, "quantisation", 0));
        drop(block);
        values
    }

    #[test]
    fn every_code_value_is_where_it_belongs() {
        for code in 0..=255u8 {
            let y = f32::from(code) / 255.0;
            let around = quantised(255.0, vec![y, y - 0.001, y + 0.001]);
            assert!(around.iter().all(|q| (q * 255.0 - f32::from(code)).abs() < 1e-4), "{code}");
        }
    }

    #[test]
    fn light_beyond_white_is_white() {
        assert_eq!(quantised(255.0, vec![1.5, 7.0, 1.0]), vec![1.0; 3]);
    }

    #[test]
    fn one_step_knows_black_and_white_only() {
        assert_eq!(quantised(1.0, vec![0.2, 0.49, 0.51]), vec![0.0, 0.0, 1.0]);
    }
}
