//! No two comparators are alike: thresholds differ from pixel to pixel, for good.
//!
//! # Model
//! `C_on ~ N(C_on, sigma)` and `C_off ~ N(C_off, sigma)`, once per pixel, with `correlation`
//! between the two, and none below 0.01.
//!
//! # Source
//! Lichtsteiner et al. 2008, figure 11: 2.1 % contrast, one standard deviation; the lower limit is
//! that of v2e (Hu et al. 2021).

use evpose_core::StageNoise;

use super::{PixelTerm, PixelTraits};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits,
};

pub(super) const MIN_THRESHOLD: f32 = 0.01;

const SIGMA: Parameter = Parameter::Number(NumberSpec {
    name: "sigma",
    unit: "ln",
    range: (1e-4, 1.0),
    typical: Some((0.004, 0.06)),
    doc: "standard deviation of thresholds over the pixels",
    ..LOG_OFF_AT_ZERO
});

const CORRELATION: Parameter = Parameter::Number(NumberSpec {
    name: "correlation",
    range: (-1.0, 1.0),
    typical: Some((-0.5, 0.5)),
    doc: "correlation between the ON and the OFF threshold of a pixel",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "threshold_mismatch",
    domain: Domain::Detector,
    summary: "thresholds differ from pixel to pixel, for good",
    formula: "C(x, y) = max(0.01, C + sigma N(x, y))",
    params: &[SIGMA, CORRELATION],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "a fixed pattern: the same pixels have more events at every pass of the same \
                   light",
        probe: Probe::RampMap,
        strength: Strength::Rising(&["sigma"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(ThresholdMismatch {
            sigma: settings.number(&SIGMA) as f32,
            correlation: settings.number(&CORRELATION) as f32,
        })))
    },
};

#[derive(Debug)]
struct ThresholdMismatch {
    sigma: f32,
    correlation: f32,
}

impl PixelTerm for ThresholdMismatch {
    fn traits(&self) -> Traits {
        Traits { is_static: true, ..Traits::default() }
    }

    fn pattern(&self, pixel: usize, traits: &mut PixelTraits, noise: StageNoise) {
        let (on, own) = (noise.normal(pixel, 0), noise.normal(pixel, 1));
        let r = self.correlation;
        let off = r * on + (1.0 - r * r).sqrt() * own;
        traits.threshold_on = (traits.threshold_on + self.sigma * on).max(MIN_THRESHOLD);
        traits.threshold_off = (traits.threshold_off + self.sigma * off).max(MIN_THRESHOLD);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_have_the_moments_asked_for() {
        let term = ThresholdMismatch { sigma: 0.03, correlation: -0.4 };
        let noise = StageNoise::new(2, SPEC.name, 0);
        let n = 100_000;
        let deviations: Vec<(f64, f64)> = (0..n)
            .map(|pixel| {
                let mut traits = PixelTraits::alike(0.3, 0.25);
                term.pattern(pixel, &mut traits, noise);
                (f64::from(traits.threshold_on) - 0.3, f64::from(traits.threshold_off) - 0.25)
            })
            .collect();
        let mean =
            |f: &dyn Fn(&(f64, f64)) -> f64| deviations.iter().map(f).sum::<f64>() / n as f64;
        let bound = 4.0 / (n as f64).sqrt();
        assert!(mean(&|d| d.0).abs() < 0.03 * bound && mean(&|d| d.1).abs() < 0.03 * bound);
        for variance in [mean(&|d| d.0 * d.0), mean(&|d| d.1 * d.1)] {
            assert!((variance / 9e-4 - 1.0).abs() < 2.0 * bound, "{variance}");
        }
        let r = mean(&|d| d.0 * d.1) / 9e-4;
        assert!((r + 0.4).abs() < 2.0 * bound, "{r}");
    }

    #[test]
    fn no_threshold_is_below_the_least() {
        let term = ThresholdMismatch { sigma: 1.0, correlation: 0.0 };
        for pixel in 0..1000 {
            let mut traits = PixelTraits::alike(0.1, 0.1);
            term.pattern(pixel, &mut traits, StageNoise::new(2, SPEC.name, 0));
            assert!(traits.threshold_on >= 0.01 && traits.threshold_off >= 0.01);
        }
    }
}
