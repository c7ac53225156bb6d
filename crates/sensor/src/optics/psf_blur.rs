//! The lens spreads every point: a Gaussian point spread function.
//!
//! # Model
//! `E = Y ⊛ G(σ)`, the Gaussian sampled at pixel centres out to 3 σ and normalised, applied along
//! rows and then along columns; the border pixel goes on outside the image.
//!
//! # Source
//! The Gaussian is the usual approximation of the Airy disc (Born and Wolf, *Principles of Optics*,
//! section 8.5) and of small defocus.

use evpose_core::{SensorSize, StageNoise};

use crate::blur::Gaussian;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PlaneStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits};

const SIGMA: Parameter = Parameter::Number(NumberSpec {
    name: "sigma_px",
    unit: "px",
    range: (0.1, 10.0),
    typical: Some((0.3, 2.0)),
    doc: "standard deviation of the point spread function",
    ..LOG_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "psf_blur",
    domain: Domain::Optics,
    summary: "the lens spreads a point of light over neighbouring pixels",
    formula: "E = Y * G(sigma_px)",
    params: &[SIGMA],
    source: Citation {
        key: "Born and Wolf 1999",
        text: "M. Born, E. Wolf: Principles of Optics, 7th ed., section 8.5, 1999",
    },
    signature: Signature {
        look_for: "fine texture loses events and edges get wider, at any speed: the response to \
                   a grating falls as exp(-2 (pi sigma / period)^2)",
        probe: Probe::Grating,
        strength: Strength::Rising(&["sigma_px"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Plane(Box::new(PsfBlur { spread: Gaussian::new(settings.number(&SIGMA)) })))
    },
};

#[derive(Debug)]
struct PsfBlur {
    spread: Gaussian,
}

impl PlaneStage for PsfBlur {
    fn traits(&self) -> Traits {
        Traits { is_linear: true, ..Traits::default() }
    }

    /// One plane to work in: the image after its rows are done.
    fn state_planes(&self) -> usize {
        1
    }

    fn step(&self, _tick: &Tick, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let [work] = plane.state.planes();
        self.spread.blur(size, plane.signal, work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::State;

    const SIZE: SensorSize = SensorSize { width: 31, height: 25 };

    fn blurred(sigma_px: f64, mut image: Vec<f32>) -> Vec<f32> {
        let mut plane = vec![0.0; SIZE.pixels()];
        let mut state = [plane.as_mut_slice()];
        let mut block = Block {
            pixels: 0..SIZE.pixels(),
            photocurrent: &[],
            signal: &mut image,
            state: State::new(&mut state, 0..SIZE.pixels()),
        };
        let tick = Tick { start_s: 0.0, end_s: 0.0, index: 0 };
        PsfBlur { spread: Gaussian::new(sigma_px) }.step(
            &tick,
            SIZE,
            &mut block,
            StageNoise::new(0, "psf_blur", 0),
        );
        drop(block);
        image
    }

    #[test]
    fn a_point_becomes_a_gaussian_of_the_given_width() {
        let mut point = vec![0.0; SIZE.pixels()];
        point[12 * 31 + 15] = 1.0;
        let spread = blurred(2.0, point);
        let moment = |power: i32| -> f64 {
            let pixel =
                |(i, &w): (usize, &f32)| f64::from(w) * ((i % 31) as f64 - 15.0).powi(power);
            spread.iter().enumerate().map(pixel).sum()
        };
        assert!((moment(0) - 1.0).abs() < 1e-6, "light is neither made nor lost");
        assert!(moment(1).abs() < 1e-6);
        // Cutting at 3 σ takes 2.7 % off the variance of a Gaussian; sampling changes it little.
        assert!((moment(2) / 4.0 - 1.0).abs() < 0.04, "{}", moment(2));
    }

    #[test]
    fn an_even_image_stays_even_up_to_the_border() {
        assert!(blurred(1.5, vec![0.4; SIZE.pixels()]).iter().all(|v| (v - 0.4).abs() < 1e-6));
    }
}
