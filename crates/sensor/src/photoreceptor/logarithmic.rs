//! The logarithmic photoreceptor.
//!
//! # Model
//! `V = ln(I + dark_offset)`, with `I` and the offset relative to the photocurrent of white. The
//! offset is the photodiode's dark current, or the constant that simulators add to keep the
//! logarithm finite: contrast fades where the light is not much above it.
//!
//! # Source
//! Lichtsteiner et al. 2008 for the logarithm; EventHands' supplement takes
//! `ln(255 Y + 1)`, an offset of one code value.

use super::Photoreceptor;
use crate::natural_log::ln;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const DARK_OFFSET: Parameter = Parameter::Number(NumberSpec {
    name: "dark_offset",
    unit: "white",
    range: (1e-6, 1.0),
    typical: Some((1e-4, 1e-2)),
    doc: "current without light, relative to the photocurrent of white",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "logarithmic",
    domain: Domain::Photoreceptor,
    summary: "voltage is the logarithm of photocurrent plus dark current",
    formula: "V = ln(I + dark_offset)",
    params: &[DARK_OFFSET],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "equal ratios of light give equal counts, down to a knee at the offset",
        probe: Probe::Contrast,
        strength: Strength::Rising(&["dark_offset"]),
        beside: &[],
    },
    build: |settings| {
        let dark_offset = settings.number(&DARK_OFFSET) as f32;
        Ok(Stage::Photoreceptor(Box::new(Logarithmic { dark_offset })))
    },
};

/// `ln(I + dark_offset)`.
#[derive(Debug)]
struct Logarithmic {
    dark_offset: f32,
}

impl Photoreceptor for Logarithmic {
    fn respond(&self, photocurrent: &[f32], voltage: &mut [f32]) {
        vectorize(
            #[inline(always)]
            || {
                for (v, i) in voltage.iter_mut().zip(photocurrent) {
                    *v = ln(i + self.dark_offset);
                }
            },
        );
    }

    fn dark_light(&self) -> f32 {
        self.dark_offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voltages_are_those_of_eventhands_up_to_a_constant() {
        let codes: Vec<f32> = (0..=255u8).map(f32::from).collect();
        let light: Vec<f32> = codes.iter().map(|code| code / 255.0).collect();
        let mut voltage = vec![0.0; 256];
        Logarithmic { dark_offset: 1.0 / 255.0 }.respond(&light, &mut voltage);
        for (code, v) in codes.iter().zip(&voltage) {
            let published = f64::from(code + 1.0).ln();
            assert!((f64::from(*v) + 255f64.ln() - published).abs() < 2e-6, "{code}");
        }
    }
}
