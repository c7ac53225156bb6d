//! Frames whose values are not proportional to light.
//!
//! Not a property of a photodiode but of a source of frames: video is stored with a curve that a
//! simulation may forget to undo.
//!
//! # Model
//! `power`: `I ← I^gamma`. `toe`: `I ← (1 + a) I^gamma - a` with `a = 0.055`, and below the point
//! where its tangent goes through the origin that tangent: sRGB at `gamma = 1 / 2.4`. A power alone
//! is equivalent to thresholds divided by `gamma`.
//!
//! # Source
//! IEC 61966-2-1:1999 (sRGB).

use evpose_core::StageNoise;

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec, Traits, WordSpec};

const GAMMA: Parameter = Parameter::Number(NumberSpec {
    name: "gamma",
    range: (0.1, 10.0),
    typical: Some((0.4, 2.4)),
    default: Some(1.0),
    doc: "exponent",
    ..NumberSpec::LOG
});

const CURVE: Parameter = Parameter::Word(WordSpec {
    name: "curve",
    allowed: &["power", "toe"],
    default: Some("power"),
    doc: "whether the dark end is a straight line, as in sRGB",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "tone_curve",
    domain: Domain::Photodiode,
    summary: "values are a power of light",
    formula: "I = I^gamma, or with a linear toe as sRGB",
    params: &[GAMMA, CURVE],
    source: Citation {
        key: "IEC 61966-2-1:1999",
        text: "IEC 61966-2-1: Multimedia systems and equipment, Colour measurement and management, \
               Default RGB colour space sRGB, 1999",
    },
    signature: Signature {
        look_for: "thresholds seem divided by gamma at every light; with a toe the dark end \
                   loses counts as well",
        probe: Probe::Contrast,
        strength: Strength::Rising(&["gamma"]),
        beside: &[],
    },
    build: |settings| {
        let (gamma, has_toe) = (settings.number(&GAMMA), settings.word(&CURVE) == Some("toe"));
        Ok(Stage::Pixel(Box::new(ToneCurve::new(gamma, has_toe))))
    },
};

/// The offset of sRGB.
const TOE: f64 = 0.055;

/// A power, perhaps with a straight start.
#[derive(Debug)]
struct ToneCurve {
    gamma: f32,
    offset: f32,
    /// Upper end of the linear segment, and its slope.
    knee: f32,
    slope: f32,
}

impl ToneCurve {
    fn new(gamma: f64, has_toe: bool) -> Self {
        // An exponent of one or more has no tangent through the origin but at it.
        if !has_toe || gamma >= 1.0 {
            return Self { gamma: gamma as f32, offset: 0.0, knee: 0.0, slope: 0.0 };
        }
        let power = TOE / ((1.0 + TOE) * (1.0 - gamma));
        let knee = power.powf(1.0 / gamma);
        let slope = ((1.0 + TOE) * power - TOE) / knee;
        Self { gamma: gamma as f32, offset: TOE as f32, knee: knee as f32, slope: slope as f32 }
    }

    fn at(&self, light: f32) -> f32 {
        if light < self.knee {
            return self.slope * light;
        }
        (1.0 + self.offset) * light.powf(self.gamma) - self.offset
    }
}

impl PixelStage for ToneCurve {
    fn traits(&self) -> Traits {
        Traits { is_static: true, ..Traits::default() }
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        for i in block.signal.iter_mut() {
            *i = self.at(*i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_toe_is_that_of_srgb_at_its_exponent() {
        let curve = ToneCurve::new(1.0 / 2.4, true);
        for k in 0..=1000 {
            let light = k as f32 / 1000.0;
            let srgb = if light <= 0.003_130_8 {
                12.92 * light
            } else {
                1.055 * light.powf(1.0 / 2.4) - 0.055
            };
            // The standard rounds its slope and knee.
            assert!((curve.at(light) - srgb).abs() < 2e-4, "{light}");
        }
    }

    #[test]
    fn a_power_is_a_power() {
        let curve = ToneCurve::new(2.0, true);
        assert_eq!([0.0, 0.5, 1.0].map(|i| curve.at(i)), [0.0, 0.25, 1.0]);
    }
}
