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

use crate::stage::{Block, PlaneStage, Stage, Tick};
use crate::{Citation, Domain, ParamSpec, Prior, Scale, StageSpec};

const SIGMA: ParamSpec = ParamSpec {
    name: "sigma_px",
    unit: "px",
    range: (0.1, 10.0),
    scale: Scale::Log,
    prior: Prior::Typical(0.3, 2.0),
    neutral: Some(0.0),
    doc: "standard deviation of the point spread function",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "psf_blur",
    domain: Domain::Optics,
    summary: "the lens spreads a point of light over neighbouring pixels",
    formula: "E = Y * G(sigma_px)",
    params: &[SIGMA],
    choices: &[],
    source: Citation {
        key: "Born and Wolf 1999",
        text: "M. Born, E. Wolf: Principles of Optics, 7th ed., section 8.5, 1999",
    },
    build: |settings| Ok(Stage::Plane(Box::new(PsfBlur::new(settings.number(&SIGMA))))),
};

/// Convolution with a Gaussian.
#[derive(Debug)]
struct PsfBlur {
    /// Weights at distances 0, 1, 2, … pixels; both sides together sum to one.
    weights: Vec<f32>,
}

impl PsfBlur {
    fn new(sigma_px: f64) -> Self {
        let radius = (3.0 * sigma_px).ceil() as usize;
        let raw: Vec<f64> =
            (0..=radius).map(|k| (-0.5 * (k as f64 / sigma_px).powi(2)).exp()).collect();
        let sum = 2.0 * raw.iter().skip(1).sum::<f64>() + 1.0;
        // A vanishing width leaves 0/0 at the centre, whose weight is one by definition.
        let centre = std::iter::once(1.0 / sum);
        let sides = raw.iter().skip(1).map(|w| w / sum);
        Self { weights: centre.chain(sides).map(|w| w as f32).collect() }
    }

    /// Convolves lines of `length` values `stride` apart; line `i` begins at `first(i)`.
    fn along(&self, source: &[f32], target: &mut [f32], line: Line) {
        let last = line.length - 1;
        for first in line.starts {
            for k in 0..line.length {
                let at = |position: usize| source[first + position * line.stride];
                let mut sum = self.weights[0] * at(k);
                for (distance, weight) in self.weights.iter().enumerate().skip(1) {
                    sum += weight * (at(k.saturating_sub(distance)) + at((k + distance).min(last)));
                }
                target[first + k * line.stride] = sum;
            }
        }
    }
}

/// The rows or the columns of an image.
struct Line {
    starts: std::iter::StepBy<std::ops::Range<usize>>,
    stride: usize,
    length: usize,
}

impl PlaneStage for PsfBlur {
    fn is_neutral(&self) -> bool {
        self.weights.len() == 1
    }

    /// One plane to work in: the image after its rows are done.
    fn state_planes(&self) -> usize {
        1
    }

    fn step(&self, _tick: &Tick, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let (width, height) = (usize::from(size.width), usize::from(size.height));
        let [work] = plane.state.planes();
        let rows = Line { starts: (0..width * height).step_by(width), stride: 1, length: width };
        let columns = Line { starts: (0..width).step_by(1), stride: width, length: height };
        self.along(plane.signal, work, rows);
        self.along(work, plane.signal, columns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::State;

    const SIZE: SensorSize = SensorSize { width: 31, height: 25 };

    fn blurred(sigma_px: f64, mut image: Vec<f32>) -> Vec<f32> {
        let mut state = vec![vec![0.0; SIZE.pixels()]];
        let mut block = Block {
            pixels: 0..SIZE.pixels(),
            photocurrent: &[],
            signal: &mut image,
            state: State::new(&mut state, 0..SIZE.pixels()),
        };
        let tick = Tick { start_s: 0.0, end_s: 0.0, index: 0 };
        PsfBlur::new(sigma_px).step(&tick, SIZE, &mut block, StageNoise::new(0, "psf_blur", 0));
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
