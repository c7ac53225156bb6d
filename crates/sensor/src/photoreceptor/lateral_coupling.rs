//! Pixels see their neighbours: a surround that is subtracted, or crosstalk.
//!
//! # Model
//! `V ← V - coupling (V - V ⊛ G(radius_px)) - surround V ⊛ G(radius_px)`. Negative coupling is the
//! opposite of crosstalk: differences from the surround are enlarged, which makes events of the other
//! polarity beside an edge; positive coupling mixes neighbours. With `surround = 1` a pixel sees
//! nothing but its difference from the surround.
//!
//! # Source
//! Delbruck et al. 2022 for a centre-surround event pixel; v2e's CSDVS is the form with memory.

use evpose_core::{SensorSize, StageNoise};

use crate::blur::Gaussian;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PlaneStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const COUPLING: Parameter = Parameter::Number(NumberSpec {
    name: "coupling",
    range: (-2.0, 1.0),
    typical: Some((-0.5, 0.5)),
    doc: "part of the difference from the surround that is taken away; negative adds to it",
    ..LINEAR_OFF_AT_ZERO
});

const RADIUS: Parameter = Parameter::Number(NumberSpec {
    name: "radius_px",
    unit: "px",
    range: (0.3, 20.0),
    typical: Some((1.0, 10.0)),
    doc: "standard deviation of the surround",
    ..NumberSpec::LOG
});

const SURROUND: Parameter = Parameter::Number(NumberSpec {
    name: "surround",
    range: (0.0, 1.0),
    typical: Some((0.0, 1.0)),
    doc: "part of the surround that is subtracted",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "lateral_coupling",
    domain: Domain::Photoreceptor,
    summary: "voltage depends on that of the neighbours",
    formula: "V = V - coupling (V - V * G(radius_px)) - surround V * G(radius_px)",
    params: &[COUPLING, RADIUS, SURROUND],
    source: Citation {
        key: "Delbruck et al. 2022",
        text: "T. Delbruck, C. Li, R. Graca, B. McReynolds: Utility and Feasibility of a Center \
               Surround Event Camera, ICIP 2022",
    },
    signature: Signature {
        look_for: "negative: a halo of the other polarity beside edges, fine texture is \
                   enhanced; positive: fine texture is lost, coarse one stays",
        probe: Probe::Grating,
        strength: Strength::Rising(&["coupling", "surround"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Plane(Box::new(LateralCoupling {
            coupling: settings.number(&COUPLING) as f32,
            surround: settings.number(&SURROUND) as f32,
            kernel: Gaussian::new(settings.number(&RADIUS)),
        })))
    },
};

#[derive(Debug)]
struct LateralCoupling {
    coupling: f32,
    surround: f32,
    kernel: Gaussian,
}

impl PlaneStage for LateralCoupling {
    /// The surround, and a plane to work in.
    fn state_planes(&self) -> usize {
        2
    }

    fn step(&self, _tick: &Tick, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [surround, work] = plane.state.planes();
        surround.copy_from_slice(plane.signal);
        self.kernel.blur(size, surround, work);
        vectorize(
            #[inline(always)]
            || {
                for (v, s) in plane.signal.iter_mut().zip(surround) {
                    *v -= self.coupling * (*v - *s) + self.surround * *s;
                }
            },
        );
    }
}
