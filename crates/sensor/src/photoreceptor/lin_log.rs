//! Linear in the dark, logarithmic in the light: the front of v2e.
//!
//! # Model
//! With code values `x = 255 I`: `V = x ln(knee) / knee` up to the knee, `V = ln x` above. One code
//! value more in the dark is then no large step of voltage.
//!
//! # Source
//! Hu et al. 2021 (v2e), knee at 20; Katz et al. 2012.

use super::Photoreceptor;
use crate::natural_log::ln;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const KNEE: Parameter = Parameter::Number(NumberSpec {
    name: "knee",
    unit: "codes",
    range: (2.0, 200.0),
    doc: "code value of 0 to 255 at which the line goes over into the logarithm",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "lin_log",
    domain: Domain::Photoreceptor,
    summary: "voltage is linear in the dark and logarithmic in the light",
    formula: "x = 255 I; V = x ln(knee) / knee where x <= knee, ln(x) elsewhere",
    params: &[KNEE],
    source: Citation::HU_2021,
    signature: Signature {
        look_for: "far below the knee counts fall in proportion to light; just below it they \
                   are higher, because the slope of the line is ln(knee) times that of the \
                   logarithm there",
        probe: Probe::Contrast,
        strength: Strength::Rising(&["knee"]),
        beside: &[],
    },
    build: |settings| {
        let knee = settings.number(&KNEE);
        let slope = (knee.ln() / knee) as f32;
        Ok(Stage::Photoreceptor(Box::new(LinLog { knee: knee as f32, slope })))
    },
};

const WHITE_CODE: f32 = 255.0;

#[derive(Debug)]
struct LinLog {
    knee: f32,
    slope: f32,
}

impl Photoreceptor for LinLog {
    fn respond(&self, photocurrent: &[f32], voltage: &mut [f32]) {
        vectorize(
            #[inline(always)]
            || {
                for (v, i) in voltage.iter_mut().zip(photocurrent) {
                    let x = WHITE_CODE * i;
                    // The logarithm is kept from what it does not know. Which of the two it is, is
                    // a matter of bits: a branch would take the pixels one by one.
                    let (linear, log) = (x * self.slope, ln(if x > 1.0 { x } else { 1.0 }));
                    let is_linear = u32::from(x <= self.knee).wrapping_neg();
                    let bits = (linear.to_bits() & is_linear) | (log.to_bits() & !is_linear);
                    *v = f32::from_bits(bits);
                }
            },
        );
    }

    fn dark_light(&self) -> f32 {
        1.0 / WHITE_CODE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voltages_are_those_of_v2e() {
        let codes: Vec<f32> = (0..=255u8).map(f32::from).collect();
        let light: Vec<f32> = codes.iter().map(|code| code / 255.0).collect();
        let mut voltage = vec![0.0; 256];
        LinLog { knee: 20.0, slope: 20f32.ln() / 20.0 }.respond(&light, &mut voltage);
        for (code, v) in codes.iter().zip(&voltage) {
            let x = f64::from(*code);
            let published = if x <= 20.0 { x * 20f64.ln() / 20.0 } else { x.ln() };
            assert!((f64::from(*v) - published).abs() < 2e-6, "{code}");
        }
    }
}
