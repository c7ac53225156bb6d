//! The lens bends straight lines: radial distortion.
//!
//! # Model
//! `x_d = x (1 + k1 r² + k2 r⁴)` about the image centre, in units of the focal length: what an
//! undistorted camera sees at `x` is seen at `x_d`. Each pixel samples its light at the `x` that
//! maps to it, found by iteration, by bilinear interpolation; outside, the border pixels repeat.
//!
//! # Source
//! Brown 1966.

use evpose_core::{SensorSize, StageNoise};

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PlaneStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};

const K: NumberSpec = NumberSpec {
    name: "k1",
    range: (-6.0, 6.0),
    typical: Some((-0.3, 0.1)),
    doc: "coefficient of r squared; negative for a barrel",
    ..LINEAR_OFF_AT_ZERO
};

const K1: Parameter = Parameter::Number(K);

const K2: Parameter = Parameter::Number(NumberSpec {
    name: "k2",
    typical: Some((-0.1, 0.1)),
    acts_alone: true,
    doc: "coefficient of r to the fourth",
    ..K
});

const FOCAL: Parameter = Parameter::Number(NumberSpec {
    name: "focal_px",
    unit: "px",
    range: (1.0, 1e5),
    typical: Some((100.0, 2000.0)),
    doc: "focal length",
    ..NumberSpec::LOG
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "lens_distortion",
    domain: Domain::Optics,
    summary: "the image is distorted radially about its centre",
    formula: "x_d = x (1 + k1 r^2 + k2 r^4), r in units of focal_px",
    params: &[K1, K2, FOCAL],
    source: Citation {
        key: "Brown 1966",
        text: "D. C. Brown: Decentering Distortion of Lenses, Photogrammetric Engineering 32(3), \
               1966",
    },
    signature: Signature {
        look_for: "straight lines bend, the more the farther from the centre: inwards at the \
                   ends for a barrel (negative k1), outwards for a pincushion",
        probe: Probe::Grid,
        strength: Strength::Rising(&["k1"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Plane(Box::new(LensDistortion {
            k1: settings.number(&K1),
            k2: settings.number(&K2),
            focal_px: settings.number(&FOCAL),
        })))
    },
};

/// Iterations of the inverse: the correction shrinks by the distortion itself each time.
const ITERATIONS: usize = 30;

#[derive(Debug)]
struct LensDistortion {
    k1: f64,
    k2: f64,
    focal_px: f64,
}

impl LensDistortion {
    /// Undistorted position of a distorted point, in pixels from the centre.
    fn source(&self, (x_d, y_d): (f64, f64)) -> (f64, f64) {
        let (mut x, mut y) = (x_d, y_d);
        for _ in 0..ITERATIONS {
            let r2 = (x * x + y * y) / (self.focal_px * self.focal_px);
            // A warp that folds over has no source; the nearest sensible one is taken.
            let factor = (1.0 + self.k1 * r2 + self.k2 * r2 * r2).max(0.2);
            (x, y) = (x_d / factor, y_d / factor);
        }
        (x, y)
    }
}

impl PlaneStage for LensDistortion {
    fn traits(&self) -> Traits {
        Traits { is_linear: true, ..Traits::default() }
    }

    /// Column and row of the source of every pixel, and a plane to work in.
    fn state_planes(&self) -> usize {
        3
    }

    fn init(&self, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [columns, rows, _] = plane.state.planes();
        let (right, bottom) = (f64::from(size.width) - 1.0, f64::from(size.height) - 1.0);
        for (i, (column, row)) in columns.iter_mut().zip(rows).enumerate() {
            let (x, y) =
                ((i % usize::from(size.width)) as f64, (i / usize::from(size.width)) as f64);
            // Sources are looked up once: the inverse has no closed form.
            let source = self.source((x - 0.5 * right, y - 0.5 * bottom));
            *column = (source.0 + 0.5 * right).clamp(0.0, right) as f32;
            *row = (source.1 + 0.5 * bottom).clamp(0.0, bottom) as f32;
        }
    }

    fn step(&self, _tick: &Tick, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [columns, rows, work] = plane.state.planes();
        // Pixels are sampled from a copy: later ones would read those written before.
        work.copy_from_slice(plane.signal);
        let (width, height) = (usize::from(size.width), usize::from(size.height));
        for ((y, column), row) in plane.signal.iter_mut().zip(columns).zip(rows) {
            let (left, top) = (*column as usize, *row as usize);
            let (right, bottom) = ((left + 1).min(width - 1), (top + 1).min(height - 1));
            let (across, down) = (*column - left as f32, *row - top as f32);
            let at = |x: usize, y: usize| work[y * width + x];
            let upper = at(left, top) + across * (at(right, top) - at(left, top));
            let lower = at(left, bottom) + across * (at(right, bottom) - at(left, bottom));
            *y = upper + down * (lower - upper);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_source_of_a_point_leads_back_to_it() {
        let lens = LensDistortion { k1: -0.25, k2: 0.07, focal_px: 200.0 };
        for k in 0..200 {
            let (x_d, y_d) = (f64::from(k) * 0.6 - 60.0, f64::from(k % 17) * 4.0 - 30.0);
            let (x, y) = lens.source((x_d, y_d));
            let r2 = (x * x + y * y) / 4e4;
            let factor = 1.0 - 0.25 * r2 + 0.07 * r2 * r2;
            assert!((x * factor - x_d).abs() < 1e-6 && (y * factor - y_d).abs() < 1e-6);
        }
    }
}
