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
//! The rate is a height over that line, drawn layer by layer, and a sensor has the events below its
//! own: two that differ a little share nearly all of them, so that a fit sees which way to turn.
//!
//! # Source
//! Hu et al. 2021 (v2e): `light_slope` 0.75.

use evpose_core::{Polarity, SensorSize, StageNoise};
use evpose_cpu::prefetch;

use super::{exponential, uniform};
use crate::detector::leak_on::SPREAD;
use crate::detector::{NoiseEvent, PixelTerm, PixelTraits, TermTable};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{
    Citation, Domain, LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO, NumberSpec, Origin, Parameter,
    StageSpec, WordSpec,
};

const RATE: Parameter = Parameter::Number(NumberSpec {
    name: "rate_hz",
    unit: "Hz",
    range: (1e-5, 1e3),
    typical: Some((0.01, 10.0)),
    doc: "noise events of a dark pixel per second, both polarities together",
    ..LOG_OFF_AT_ZERO
});

const LIGHT_SLOPE: Parameter = Parameter::Number(NumberSpec {
    name: "light_slope",
    unit: "/white",
    range: (0.01, 1.0),
    typical: Some((0.5, 0.9)),
    doc: "part of the rate that the light of white takes away",
    ..LINEAR_OFF_AT_ZERO
});

const THRESHOLD: Parameter = Parameter::Word(WordSpec {
    name: "threshold",
    allowed: &["ignored", "inverse"],
    default: Some("ignored"),
    doc: "whether pixels of low threshold are noisier",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "shot_noise_poisson",
    domain: Domain::Background,
    summary: "noise events of both polarities, most in the dark, that reset their pixel",
    formula: "ON, OFF ~ Poisson(rate_hz 10^(spread_decades N(x, y)) (1 - light_slope I) dt / 2)",
    params: &[RATE, SPREAD, LIGHT_SLOPE, THRESHOLD],
    source: Citation::HU_2021,
    signature: Signature {
        look_for: "ON and OFF alike, exponential intervals, most in the dark: the rate falls \
                   along a line with light",
        probe: Probe::RateByLight,
        strength: Strength::Rising(&["rate_hz"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Term(Box::new(ShotNoisePoisson {
            rate_hz: settings.number(&RATE),
            spread_decades: settings.number(&SPREAD),
            light_slope: settings.number(&LIGHT_SLOPE) as f32,
            is_inverse: settings.word(&THRESHOLD) == Some("inverse"),
        })))
    },
};

#[derive(Debug)]
struct ShotNoisePoisson {
    rate_hz: f64,
    spread_decades: f64,
    light_slope: f32,
    is_inverse: bool,
}

/// The sequences of draws of one layer of one tick. They take the place of a pixel in
/// [`StageNoise`].
const GAPS: usize = 0;
const CHANCES: usize = 1;
const HEIGHTS: usize = 2;
const SEQUENCES: usize = 3;

/// The rate that the lowest layer ends at, Hz; every further one ends at twice that of the one
/// below.
const LOWEST_HZ: f64 = 1.0 / 256.0;

#[derive(Debug, Clone, Copy)]
struct Layer {
    index: usize,
    low_hz: f64,
    high_hz: f64,
}

impl Layer {
    fn new(index: usize) -> Self {
        let high_hz = LOWEST_HZ * (index as f64).exp2();
        Self { index, low_hz: if index == 0 { 0.0 } else { 0.5 * high_hz }, high_hz }
    }
}

/// The largest part of a step by which a noise event comes before its end: it lies within the step.
const LAST_SHARE: f32 = 1.0 - f32::EPSILON;

/// Pixels per group, whose ends are compared all at once.
const GROUP: usize = 16;

impl PixelTerm for ShotNoisePoisson {
    /// On the line: where each group of pixels begins, and at last its length. Per pixel: where it
    /// ends in its group, and how long its ON part is.
    fn table(&self, traits: &[PixelTraits], noise: StageNoise) -> TermTable {
        let mean = |threshold: fn(&PixelTraits) -> f32| {
            traits.iter().map(|t| f64::from(threshold(t))).sum::<f64>() / traits.len() as f64
        };
        let (mean_on, mean_off) = (mean(|t| t.threshold_on), mean(|t| t.threshold_off));
        // A dead pixel has no length, so that no draw lands on it.
        let lengths = traits.iter().enumerate().map(|(pixel, own)| {
            if own.is_dead {
                return [0.0, 0.0];
            }
            let draw = f64::from(noise.normal(pixel, 0));
            let rate = (std::f64::consts::LN_10 * self.spread_decades * draw).exp();
            let of = |mean: f64, own: f32| {
                if self.is_inverse { rate * mean / f64::from(own) } else { rate }
            };
            [of(mean_on, own.threshold_on), of(mean_off, own.threshold_off)]
        });
        let lengths: Vec<[f64; 2]> = lengths.collect();
        let (mut start, mut table) = (0.0, TermTable::default());
        // Sums start again in each group: single precision is enough for the ends within one.
        for group in lengths.chunks(GROUP) {
            table.sums.push(start);
            let mut end = 0.0;
            for [on, off] in group {
                end += on + off;
                table.values.push(end as f32);
            }
            start += end;
        }
        table.sums.push(start);
        table.values.extend(lengths.iter().map(|[on, _]| *on as f32));
        table
    }

    /// Layers that begin below the rate.
    fn noise_parts(&self) -> usize {
        (0..).take_while(|&index| Layer::new(index).low_hz < self.rate_hz).count()
    }

    fn noise_events(
        &self,
        part: usize,
        tick: &Tick,
        size: SensorSize,
        table: &TermTable,
        noise: StageNoise,
        noise_events: &mut Vec<NoiseEvent>,
    ) {
        self.layer_events(tick, size, table, noise, Layer::new(part), noise_events);
    }

    fn acceptance(&self, light: f32) -> f32 {
        1.0 - self.light_slope * light
    }
}

impl ShotNoisePoisson {
    fn layer_events(
        &self,
        tick: &Tick,
        size: SensorSize,
        table: &TermTable,
        noise: StageNoise,
        layer: Layer,
        noise_events: &mut Vec<NoiseEvent>,
    ) {
        let pixels = size.pixels();
        let (starts, (ends, on_parts)) = (&table.sums, table.values.split_at(pixels));
        let mean = 0.5 * (layer.high_hz - layer.low_hz) * tick.dt_s();
        // The layer is drawn whole, and thinned to the part of it that is below the own rate.
        let kept = (self.rate_hz - layer.low_hz) / (layer.high_hz - layer.low_hz);
        let sequence = SEQUENCES * layer.index;
        let mut places = Vec::new();
        // A first guess for the search: groups hold about equal lengths.
        let groups_per_length = (starts.len() - 1) as f64 / starts[starts.len() - 1];
        let (mut position, mut group) = (0.0, 0);
        for draw in 0.. {
            position += exponential(noise, sequence + GAPS, draw) / mean;
            let Some(at) = group_at(starts, position, group, groups_per_length) else { break };
            group = at;
            if kept < 1.0 && uniform(noise, sequence + HEIGHTS, draw) > kept {
                continue;
            }
            // Groups lie apart in memory; those of later draws arrive while earlier ones are seen
            // to.
            let first = group * GROUP;
            for pixel in [first, first + GROUP - 1] {
                prefetch(ends, pixel);
                prefetch(on_parts, pixel);
            }
            places.push((draw, group, (position - starts[group]) as f32));
        }
        for (draw, group, rest) in places {
            let first = group * GROUP;
            let group_ends = &ends[first..(first + GROUP).min(pixels)];
            let index = group_ends.iter().map(|&end| usize::from(end <= rest)).sum::<usize>();
            // Rounding can put a noise event behind the last pixel of its group.
            let Some(&end) = group_ends.get(index) else { continue };
            let begin = if index == 0 { 0.0 } else { group_ends[index - 1] };
            let on = on_parts[first + index];
            // Where in the pixel's length the event lies says its polarity, and then its time.
            let (polarity, share) = if rest - begin < on {
                (Polarity::On, (rest - begin) / on)
            } else {
                (Polarity::Off, (rest - begin - on) / (end - begin - on))
            };
            noise_events.push(NoiseEvent {
                // Not at the step's start, where the exposure before has ended.
                t_s: tick.end_s - tick.dt_s() * f64::from(share.clamp(0.0, LAST_SHARE)),
                pixel: (first + index) as u32,
                polarity,
                origin: Origin::Shot,
                chance: uniform(noise, sequence + CHANCES, draw) as f32,
                term: 0,
            });
        }
    }
}

/// The group in which `position` lies, of groups that begin and end at `starts`; none behind the
/// last. It is not before group `from`. It is guessed from the mean count of groups on a length, and
/// sought from there: layers with few events pass over hundreds of groups between two of them.
#[inline(always)]
fn group_at(starts: &[f64], position: f64, from: usize, groups_per_length: f64) -> Option<usize> {
    let groups = starts.len() - 1;
    if starts[groups] <= position {
        return None;
    }
    // The mean count is a good guess: both loops below are short.
    let way = ((position - starts[from]) * groups_per_length) as usize;
    let mut group = from.saturating_add(way).min(groups - 1);
    while starts[group] > position {
        group -= 1;
    }
    while starts[group + 1] <= position {
        group += 1;
    }
    Some(group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_lie_in_the_groups_that_a_walk_comes_to() {
        let noise = StageNoise::new(5, SPEC.name, 0);
        // Lengths from nothing, as those of dead pixels, to a hundred times the mean.
        let lengths = (0..200).map(|k| match k % 7 {
            0 => 0.0,
            _ if k > 180 => 100.0 * f64::from(noise.uniform(k, 0)),
            _ => f64::from(noise.uniform(k, 0)),
        });
        let ends = lengths.scan(0.0, |sum, length| {
            *sum += length;
            Some(*sum)
        });
        let starts: Vec<f64> = std::iter::once(0.0).chain(ends).collect();
        let end = starts[starts.len() - 1];
        let drawn = (0..20_000).map(|k| 1.001 * end * f64::from(noise.uniform(k, 1)));
        for position in drawn.chain(starts.iter().copied()) {
            let walk = starts[1..].iter().position(|&end| position < end);
            // From the beginning, and from the group before.
            let groups_per_length = (starts.len() - 1) as f64 / end;
            for from in [0, walk.map_or(0, |walk| walk.saturating_sub(1))] {
                let group = group_at(&starts, position, from, groups_per_length);
                assert_eq!(group, walk, "{position} from {from}");
            }
        }
    }

    #[test]
    fn a_line_without_length_has_no_groups() {
        assert_eq!(group_at(&[0.0; 4], 0.0, 0, f64::INFINITY), None);
    }
}
