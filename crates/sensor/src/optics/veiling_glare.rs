//! Light that goes astray in the lens veils the whole image.
//!
//! # Model
//! `I ← (1 - g) I + g ⟨I⟩`, with the mean over the image: contrast is lost where it is dark.
//!
//! # Source
//! ISO 9358:1994, veiling glare index.

use evpose_core::{SensorSize, StageNoise};

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PlaneStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};
use evpose_cpu::vectorize;

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (1e-4, 1.0),
    typical: Some((0.01, 0.1)),
    doc: "part of the light that goes everywhere",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "veiling_glare",
    domain: Domain::Optics,
    summary: "a part of the light is spread evenly over the image",
    formula: "I = (1 - fraction) I + fraction mean(I)",
    params: &[FRACTION],
    source: Citation {
        key: "ISO 9358:1994",
        text: "ISO 9358: Optics and optical instruments, Veiling glare of image forming systems, \
               1994",
    },
    signature: Signature {
        look_for: "contrast is lost in the dark parts of the image only, the more the brighter \
                   the rest is",
        probe: Probe::Contrast,
        strength: Strength::Rising(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        let fraction = settings.number(&FRACTION) as f32;
        Ok(Stage::Plane(Box::new(VeilingGlare { fraction })))
    },
};

#[derive(Debug)]
struct VeilingGlare {
    fraction: f32,
}

/// The mean of an image, in double precision: eight sums side by side, which vectors can hold.
fn mean(image: &[f32]) -> f64 {
    let sums = vectorize(
        #[inline(always)]
        || {
            let mut sums = [0.0_f64; 8];
            let (rows, rest) = image.as_chunks::<8>();
            // One sum would be a chain of additions, each waiting for the one before.
            for row in rows {
                for (sum, y) in sums.iter_mut().zip(row) {
                    *sum += f64::from(*y);
                }
            }
            for (sum, y) in sums.iter_mut().zip(rest) {
                *sum += f64::from(*y);
            }
            sums
        },
    );
    sums.iter().sum::<f64>() / image.len().max(1) as f64
}

impl PlaneStage for VeilingGlare {
    fn traits(&self) -> Traits {
        Traits { is_linear: true, ..Traits::default() }
    }

    fn step(&self, _tick: &Tick, _size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let mean = mean(plane.signal);
        let veil = (f64::from(self.fraction) * mean) as f32;
        let kept = 1.0 - self.fraction;
        vectorize(
            #[inline(always)]
            || plane.signal.iter_mut().for_each(|y| *y = kept * *y + veil),
        );
    }
}
