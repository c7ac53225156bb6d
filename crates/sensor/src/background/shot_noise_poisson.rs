//! Shot noise, as events: a Poisson process per pixel that is strongest in the dark.
//!
//! # Model
//! `R / 2 (1 - light_slope I)` ON and as many OFF events per second, `R = rate_hz
//! 10^(spread_decades N)` fixed per pixel; with `threshold = "inverse"` also in proportion to the
//! mean threshold over the pixel's own. An event takes the memory to the voltage there is.
//!
//! Nothing is drawn per pixel: along a line on which every pixel holds a length in proportion to
//! its rate, the gaps between events are exponential. Light then takes some away.
//!
//! # Source
//! Hu et al. 2021 (v2e): `light_slope` 0.75.

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::{exponential, uniform};
use crate::detector::{Hit, PixelTerm, PixelTraits};
use crate::stage::{Stage, Tick};
use crate::{ChoiceSpec, Citation, Domain, Origin, ParamSpec, Prior, Scale, StageSpec};

const RATE: ParamSpec = ParamSpec {
    name: "rate_hz",
    unit: "Hz",
    range: (1e-5, 1e3),
    scale: Scale::Log,
    prior: Prior::Typical(0.01, 10.0),
    neutral: Some(0.0),
    doc: "noise events of a dark pixel per second, both polarities together",
};

const SPREAD: ParamSpec = ParamSpec {
    name: "spread_decades",
    unit: "decades",
    range: (0.001, 1.0),
    scale: Scale::Log,
    prior: Prior::Typical(0.1, 0.25),
    neutral: Some(0.0),
    doc: "standard deviation of the logarithm of the rate over the pixels",
};

const LIGHT_SLOPE: ParamSpec = ParamSpec {
    name: "light_slope",
    unit: "/white",
    range: (0.01, 1.0),
    scale: Scale::Linear,
    prior: Prior::Typical(0.5, 0.9),
    neutral: Some(0.0),
    doc: "part of the rate that the light of white takes away",
};

const THRESHOLD: ChoiceSpec = ChoiceSpec {
    name: "threshold",
    allowed: &["ignored", "inverse"],
    doc: "whether pixels of low threshold are noisier",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "shot_noise_poisson",
    domain: Domain::Background,
    summary: "noise events of both polarities, most in the dark, that reset their pixel",
    formula: "ON, OFF ~ Poisson(rate_hz 10^(spread_decades N(x, y)) (1 - light_slope I) dt / 2)",
    params: &[RATE, SPREAD, LIGHT_SLOPE],
    choices: &[THRESHOLD],
    source: Citation {
        key: "Hu et al. 2021",
        text: "Y. Hu, S.-C. Liu, T. Delbruck: v2e: From Video Frames to Realistic DVS Events, CVPR \
               Workshops 2021",
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(ShotNoisePoisson {
            rate_hz: settings.number(&RATE),
            spread_decades: settings.number(&SPREAD),
            light_slope: settings.number(&LIGHT_SLOPE) as f32,
            is_inverse: settings.word(&THRESHOLD) == "inverse",
        })))
    },
};

/// Rates per pixel.
#[derive(Debug)]
struct ShotNoisePoisson {
    rate_hz: f64,
    spread_decades: f64,
    light_slope: f32,
    is_inverse: bool,
}

/// The sequences of draws of one tick. They take the place of a pixel in [`StageNoise`].
const GAPS: usize = 0;
const CHANCES: usize = 1;

/// Pixels per entry of the coarse table, which is then small enough to stay in the cache.
const COARSE: usize = 16;

/// Lengths on the line: ON and OFF of a pixel, side by side.
fn lengths(weights: [f64; 2]) -> f64 {
    weights[0] + weights[1]
}

impl PixelTerm for ShotNoisePoisson {
    fn is_neutral(&self) -> bool {
        self.rate_hz <= 0.0
    }

    /// ON and OFF weights of every pixel, two by two, and behind them where on the line each
    /// group of pixels begins; at last its length.
    fn table(&self, traits: &[PixelTraits], noise: StageNoise) -> Vec<f64> {
        let mean = |threshold: fn(&PixelTraits) -> f32| {
            traits.iter().map(|t| f64::from(threshold(t))).sum::<f64>() / traits.len() as f64
        };
        let (mean_on, mean_off) = (mean(|t| t.threshold_on), mean(|t| t.threshold_off));
        let mut table = Vec::new();
        for (pixel, own) in traits.iter().enumerate() {
            if own.is_dead {
                table.extend([0.0, 0.0]);
                continue;
            }
            let draw = f64::from(noise.normal(pixel, 0));
            let rate = (std::f64::consts::LN_10 * self.spread_decades * draw).exp();
            let of = |mean: f64, own: f32| {
                if self.is_inverse { rate * mean / f64::from(own) } else { rate }
            };
            table.extend([of(mean_on, own.threshold_on), of(mean_off, own.threshold_off)]);
        }
        let mut sum = 0.0;
        let mut starts = Vec::new();
        for group in table.chunks(2 * COARSE) {
            starts.push(sum);
            sum += group.iter().sum::<f64>();
        }
        starts.push(sum);
        table.extend(starts);
        table
    }

    fn strike(
        &self,
        tick: &Tick,
        size: SensorSize,
        table: &[f64],
        noise: StageNoise,
        hits: &mut Vec<Hit>,
    ) {
        let (weights, starts) = table.split_at((2 * size.pixels()).min(table.len()));
        let mean = 0.5 * self.rate_hz * tick.dt_s();
        let (pairs, _) = weights.as_chunks::<2>();
        let Some(&end) = starts.last() else { return };
        let (mut position, mut group) = (0.0, 0);
        for draw in 0.. {
            position += exponential(noise, GAPS, draw) / mean;
            if position >= end {
                return;
            }
            while starts[group + 1] <= position {
                group += 1;
            }
            let mut rest = position - starts[group];
            let first = group * COARSE;
            let last = (first + COARSE).min(pairs.len()) - 1;
            let mut pixel = first;
            // Rounding of sums can leave a rest behind the last pixel of the group.
            while pixel < last && rest >= lengths(pairs[pixel]) {
                rest -= lengths(pairs[pixel]);
                pixel += 1;
            }
            let [on, off] = pairs[pixel];
            if on + off <= 0.0 {
                continue;
            }
            let (polarity, share) = if rest < on {
                (Polarity::On, rest / on)
            } else {
                (Polarity::Off, ((rest - on) / off).min(1.0))
            };
            hits.push(Hit {
                t_s: tick.end_s - tick.dt_s() * share.min(1.0 - f64::EPSILON),
                pixel: pixel as u32,
                polarity,
                origin: Origin::Shot,
                chance: uniform(noise, CHANCES, draw) as f32,
                term: 0,
            });
        }
    }

    fn acceptance(&self, light: f32) -> f32 {
        1.0 - self.light_slope * light
    }
}
