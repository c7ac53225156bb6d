//! Less light reaches the corners.
//!
//! # Model
//! `I ← I cos⁴ θ`, with `tan θ` growing in proportion to the distance from the centre, up to
//! `corner_deg` in the corner. The logarithm makes it a constant: no event is lost, but noise and
//! bandwidth change towards the corners.
//!
//! # Source
//! The cosine-fourth law; Born and Wolf 1999, section 4.8.

use evpose_core::{SensorSize, StageNoise};

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PlaneStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};
use evpose_cpu::vectorize;

const CORNER: Parameter = Parameter::Number(NumberSpec {
    name: "corner_deg",
    unit: "deg",
    range: (0.1, 80.0),
    typical: Some((5.0, 40.0)),
    doc: "angle between the optical axis and the ray to a corner",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "vignetting",
    domain: Domain::Optics,
    summary: "light falls off towards the corners",
    formula: "I = I cos(theta)^4, tan(theta) = tan(corner_deg) r / r_corner",
    params: &[CORNER],
    source: Citation {
        key: "Born and Wolf 1999",
        text: "M. Born, E. Wolf: Principles of Optics, 7th ed., section 4.8, 1999",
    },
    signature: Signature {
        look_for: "no edge loses events, because a factor is a constant of the logarithm; what \
                   depends on light changes towards the corners: bandwidth, and with it the \
                   rate of noise",
        probe: Probe::RateByRadius,
        strength: Strength::Rising(&["corner_deg"]),
        beside: &["photoreceptor_noise"],
    },
    build: |settings| {
        let corner_tan = settings.number(&CORNER).to_radians().tan();
        Ok(Stage::Plane(Box::new(Vignetting { corner_tan })))
    },
};

#[derive(Debug)]
struct Vignetting {
    corner_tan: f64,
}

impl PlaneStage for Vignetting {
    fn traits(&self) -> Traits {
        Traits { is_linear: true, ..Traits::default() }
    }

    /// The factor of every pixel.
    fn state_planes(&self) -> usize {
        1
    }

    fn init(&self, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [gains] = plane.state.planes();
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let corner = 0.5 * (width - 1.0).hypot(height - 1.0);
        for (i, gain) in gains.iter_mut().enumerate() {
            let (column, row) = (i % usize::from(size.width), i / usize::from(size.width));
            let (x, y) = (column as f64 - 0.5 * (width - 1.0), row as f64 - 0.5 * (height - 1.0));
            // A sensor of one pixel is all centre.
            let tan = self.corner_tan * x.hypot(y) / corner.max(f64::MIN_POSITIVE);
            *gain = (1.0 + tan * tan).powi(-2) as f32;
        }
    }

    fn step(&self, _tick: &Tick, _size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [gains] = plane.state.planes();
        vectorize(
            #[inline(always)]
            || plane.signal.iter_mut().zip(gains).for_each(|(y, gain)| *y *= *gain),
        );
    }
}
