//! A few pixels have events all the time.
//!
//! # Model
//! Each pixel is hot with probability `fraction`, for good, and then has events at Poisson times
//! of rate `median_hz 10^(spread_decades N)`, a part `on_share` of them ON. An event takes the
//! memory to the voltage there is.
//!
//! # Source
//! Background activity of recordings: a small part of the pixels holds most of it (Khodamoradi and
//! Kastner 2018 filter it).

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::exponential;
use crate::detector::{NoiseEvent, PixelTerm, PixelTraits, TermTable};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Origin, Parameter, StageSpec};

const FRACTION: Parameter = Parameter::Number(NumberSpec {
    name: "fraction",
    range: (1e-6, 0.5),
    typical: Some((1e-4, 1e-2)),
    doc: "part of the pixels that are hot",
    ..LOG_OFF_AT_ZERO
});

const MEDIAN: Parameter = Parameter::Number(NumberSpec {
    name: "median_hz",
    unit: "Hz",
    range: (0.1, 1e4),
    typical: Some((1.0, 5000.0)),
    doc: "events of a hot pixel per second, the median",
    ..NumberSpec::LOG
});

const SPREAD: Parameter = Parameter::Number(NumberSpec {
    name: "spread_decades",
    unit: "decades",
    range: (0.01, 1.0),
    typical: Some((0.2, 1.0)),
    doc: "standard deviation of the logarithm of the rate over hot pixels",
    ..LOG_OFF_AT_ZERO
});

const ON_SHARE: Parameter = Parameter::Number(NumberSpec {
    name: "on_share",
    range: (0.0, 1.0),
    typical: Some((0.3, 1.0)),
    doc: "part of their events that are ON",
    ..NumberSpec::LINEAR
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "hot_pixels",
    domain: Domain::Background,
    summary: "a few pixels have events all the time",
    formula: "Poisson(median_hz 10^(spread_decades N(x, y)) dt) where U(x, y) < fraction",
    params: &[FRACTION, MEDIAN, SPREAD, ON_SHARE],
    source: Citation {
        key: "Khodamoradi and Kastner 2018",
        text: "A. Khodamoradi, R. Kastner: O(N)-Space Spatiotemporal Filter for Reducing Noise in \
               Neuromorphic Vision Sensors, IEEE TETC 9(1), 2021",
    },
    signature: Signature {
        look_for: "a few single pixels hold most of the events of a scene at rest",
        probe: Probe::RestMap,
        strength: Strength::Rising(&["fraction"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(HotPixels {
            fraction: settings.number(&FRACTION) as f32,
            median_hz: settings.number(&MEDIAN),
            spread_decades: settings.number(&SPREAD),
            on_share: settings.number(&ON_SHARE) as f32,
        })))
    },
};

#[derive(Debug)]
struct HotPixels {
    fraction: f32,
    median_hz: f64,
    spread_decades: f64,
    on_share: f32,
}

/// Offset of the draw indices of polarities.
const POLARITIES: u32 = 1 << 31;

impl PixelTerm for HotPixels {
    /// Hot pixels and their rates, two by two.
    fn table(&self, traits: &[PixelTraits], noise: StageNoise) -> TermTable {
        let is_hot =
            |&pixel: &usize| !traits[pixel].is_dead && noise.uniform(pixel, 0) <= self.fraction;
        // A list of the few hot ones: a rate for every pixel would have to be searched at each
        // tick.
        let hot = (0..traits.len()).filter(is_hot);
        let pairs = hot.flat_map(|pixel| {
            let draw = f64::from(noise.normal(pixel, 1));
            let rate =
                self.median_hz * (std::f64::consts::LN_10 * self.spread_decades * draw).exp();
            [pixel as f64, rate]
        });
        TermTable { sums: pairs.collect(), values: Vec::new() }
    }

    fn noise_events(
        &self,
        _part: usize,
        tick: &Tick,
        _size: SensorSize,
        table: &TermTable,
        noise: StageNoise,
        noise_events: &mut Vec<NoiseEvent>,
    ) {
        let (pairs, _) = table.sums.as_chunks::<2>();
        for &[pixel, rate_hz] in pairs {
            // Without memory from tick to tick: gaps are exponential, so that starting anew changes
            // nothing.
            let mut t_s = tick.start_s;
            for draw in 0..POLARITIES {
                t_s += exponential(noise, pixel as usize, draw) / rate_hz;
                if t_s > tick.end_s {
                    break;
                }
                let is_on = noise.uniform(pixel as usize, POLARITIES | draw) <= self.on_share;
                noise_events.push(NoiseEvent {
                    t_s,
                    pixel: pixel as u32,
                    polarity: Polarity::from_on(is_on),
                    origin: Origin::Hot,
                    chance: 0.0,
                    term: 0,
                });
            }
        }
    }
}
