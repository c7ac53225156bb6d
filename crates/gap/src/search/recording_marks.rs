//! Marks that lamps, clocks, hot pixels and readouts leave in the time stamps and places of events,
//! and the parameters estimated from them.

use std::f64::consts::TAU;

use evpose_core::EventStream;
use evpose_sensor::{StageSpec, Value};

use super::light_steps::light_steps;
use super::rate_ceiling::rate_ceiling;
use crate::recording_mark::RecordingMark;
use crate::search_spec::with_mark;
use crate::{Expected, LightSequence};

#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub(super) spec: &'static StageSpec,
    pub(super) mark: RecordingMark,
    pub(super) reading: Reading,
}

#[derive(Debug, Clone)]
pub(super) struct Reading {
    /// Estimates of parameters and choices, by their keys.
    pub(super) params: Vec<(&'static str, Value)>,
    /// Fraction of the time stamps that are consistent with them; zero where that is not known.
    pub(super) consistent: f64,
}

impl Reading {
    pub(super) fn new(
        params: impl IntoIterator<Item = (&'static str, Value)>,
        consistent: f64,
    ) -> Self {
        Self { params: params.into_iter().collect(), consistent }
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        self.params.iter().find(|(known, _)| *known == key).and_then(|(_, value)| match value {
            Value::Number(number) => Some(*number),
            Value::Word(_) => None,
        })
    }
}

/// Reads a mark in a recording; none if it is not there.
type Read = fn(&Recording<'_>) -> Option<Reading>;

/// Events in which marks are looked for, and what is known of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recording<'a> {
    pub(super) events: &'a EventStream,
    /// Those that the scene lets expect.
    pub(super) expected: &'a Expected,
    /// The light, if it is known.
    pub(super) scene: Option<&'a LightSequence>,
}

/// Marks that are read without a simulation. What the time stamps prove is added in the
/// reverse order.
const READINGS: [(RecordingMark, Read); 8] = [
    (RecordingMark::RateCeiling, |recording| rate_ceiling(recording.events)),
    (RecordingMark::Lamp, |recording| flicker(recording.events, recording.expected)),
    (RecordingMark::TimeGrid, |recording| tick(recording.events)),
    (RecordingMark::SilentPixels, |recording| silent_pixels(recording.events, recording.expected)),
    (RecordingMark::HotPixels, |recording| hot_pixels(recording.events)),
    (RecordingMark::Scan, |recording| scan(recording.events)),
    (RecordingMark::Bus, |recording| bus(recording.events)),
    (RecordingMark::LightSteps, |recording| {
        light_steps(recording.events, recording.expected, recording.scene?)
    }),
];

pub(super) fn all_estimates(recording: &Recording<'_>) -> Vec<Estimate> {
    let mut estimates = Vec::new();
    for (mark, read) in READINGS {
        let mut specs = with_mark(mark).peekable();
        // A mark that no effect of the catalogue leaves is not worth reading.
        let Some(reading) = specs.peek().and_then(|_| read(recording)) else { continue };
        estimates.extend(specs.map(|spec| Estimate { spec, mark, reading: reading.clone() }));
    }
    estimates
}

/// Bin length of the rate that lamps are searched in.
const FLICKER_BIN_US: i64 = 500;
/// Frequencies of lamps, pulsed or on mains.
const FLICKER_HZ: (f64, f64) = (30.0, 900.0);

/// Frequencies of lamps on mains of 50 and 60 Hz.
const MAINS_HZ: [f64; 4] = [50.0, 60.0, 100.0, 120.0];

/// Frequency and phase of the strongest spectral line of the ON rate minus the OFF rate: light that
/// rises and falls makes them alternate. What the scene lets expect is subtracted.
fn flicker(events: &EventStream, expected: &Expected) -> Option<Reading> {
    let end = events.t().last()?.0;
    let mut rate = vec![0.0_f64; (end / FLICKER_BIN_US) as usize + 1];
    let mut add = |t_us: i64, is_on: bool, count: f64| {
        let bin = usize::try_from(t_us.div_euclid(FLICKER_BIN_US)).ok();
        if let Some(rate) = bin.and_then(|bin| rate.get_mut(bin)) {
            *rate += if is_on { count } else { -count };
        }
    };
    events.iter().for_each(|event| add(event.t.0, event.polarity.is_on(), 1.0));
    for pixel in 0..events.sensor().pixels() {
        for is_on in [false, true] {
            expected.times(pixel, is_on).iter().for_each(|t_us| add(*t_us, is_on, -1.0));
        }
    }
    let seconds = 1e-6 * end as f64;
    let transform = |hz: f64| -> (f64, f64) {
        let turn = TAU * hz * 1e-6 * FLICKER_BIN_US as f64;
        // On average, stamps lie in the middle of their bins.
        let phase = |k: usize| turn * (k as f64 + 0.5);
        rate.iter().enumerate().fold((0.0, 0.0), |(c, s), (k, n)| {
            let (sin, cos) = phase(k).sin_cos();
            (c + n * cos, s + n * sin)
        })
    };
    let power = |hz: f64| {
        let (c, s) = transform(hz);
        c * c + s * s
    };
    let step_hz = 0.5 / seconds;
    let steps = ((FLICKER_HZ.1 - FLICKER_HZ.0) / step_hz) as usize;
    let coarse = (0..steps).map(|i| FLICKER_HZ.0 + step_hz * i as f64);
    let best = coarse.max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
    let fine = (-10..=10).map(|i| best + 0.1 * step_hz * f64::from(i));
    let hz = fine.max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
    // Most lamps are on the mains: a scene that moves shifts the line by less than its width.
    let mains = MAINS_HZ.into_iter().find(|mains| (hz - mains).abs() < step_hz);
    let hz = mains.unwrap_or(hz);
    let (c, s) = transform(hz);
    // Light 1 + m sin(2 pi f t + phi) changes as cos(2 pi f t + phi), whose transform this is.
    let phase_turns = (-s).atan2(c) / TAU;
    let phase_turns = phase_turns.rem_euclid(1.0);
    Some(Reading::new([("frequency_hz", hz.into()), ("phase_turns", phase_turns.into())], 0.0))
}

/// Time stamps whose common divisor is no accident.
const MIN_STAMPS: usize = 200;
/// Period from which a clock hides other differences, and is taken as proven by the stamps. A
/// shorter one may be the lines of a readout, and is fitted as any other effect.
const COARSE_US: i64 = 20;

/// The greatest common divisor of the differences of all time stamps, microseconds; zero if they
/// do not differ.
pub(crate) fn common_period_us(events: &EventStream) -> i64 {
    let gcd = |mut a: i64, mut b: i64| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let first = events.t().first().map_or(0, |t| t.0);
    // Differences: a clock may have any offset.
    events.t().iter().fold(0, |period, t| gcd(period, t.0 - first))
}

/// Period of the time stamps; none if that is a microsecond.
fn tick(events: &EventStream) -> Option<Reading> {
    let tick = common_period_us(events);
    // Few stamps have a common divisor by chance; of many, it is a fact.
    let is_proof = events.len() >= MIN_STAMPS && tick >= COARSE_US;
    let consistent = if is_proof { 1.0 } else { 0.0 };
    (tick > 1).then(|| Reading::new([("period_us", (tick as f64).into())], consistent))
}

/// Expected events of a pixel, from which one that has none is dead.
const CERTAIN_EVENTS: usize = 8;
/// Minimum number of such pixels for a count of dead ones.
const MIN_CERTAIN: usize = 300;
/// Fraction that stands for none.
const MIN_FRACTION: f64 = 1e-6;

/// Fraction of pixels without events where the scene lets expect many, from pairs of neighbours of
/// which one is silent: pixels die one by one, while what takes the events of a place or a moment
/// leaves areas without any. A pair differs with a probability of `2 f (1 - f)`.
fn silent_pixels(events: &EventStream, expected: &Expected) -> Option<Reading> {
    let size = events.sensor();
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let mut has_events = vec![false; size.pixels()];
    for event in events.iter() {
        has_events[usize::from(event.y) * width + usize::from(event.x)] = true;
    }
    let count =
        |pixel: usize| expected.times(pixel, false).len() + expected.times(pixel, true).len();
    // A pixel of which few events are expected is silent by chance: exp(-8) at the limit.
    let is_certain: Vec<bool> =
        (0..size.pixels()).map(|pixel| count(pixel) >= CERTAIN_EVENTS).collect();
    let neighbours = (0..size.pixels()).flat_map(|pixel| {
        let right = (pixel % width + 1 < width).then_some((pixel, pixel + 1));
        let below = (pixel / width + 1 < height).then_some((pixel, pixel + width));
        [right, below].into_iter().flatten()
    });
    let pairs: Vec<bool> = neighbours
        .filter(|(one, other)| is_certain[*one] && is_certain[*other])
        .map(|(one, other)| has_events[one] != has_events[other])
        .collect();
    let differing = pairs.iter().filter(|differs| **differs).count();
    let part = differing as f64 / pairs.len().max(1) as f64;
    // The smaller root of part = 2 f (1 - f).
    let fraction = 0.5 * (1.0 - (1.0 - 2.0 * part).max(0.0).sqrt());
    let is_known = is_certain.iter().filter(|certain| **certain).count() >= MIN_CERTAIN;
    is_known.then(|| Reading::new([("fraction", fraction.max(MIN_FRACTION).into())], 0.0))
}

/// Events by which, and factor by which, a hot pixel exceeds the median of its neighbours.
const HOT_EXCESS: f64 = 8.0;
const HOT_FACTOR: f64 = 4.0;

/// Fraction of pixels far above their eight neighbours, and the median of their rates.
fn hot_pixels(events: &EventStream) -> Option<Reading> {
    let size = events.sensor();
    let (width, height) = (usize::from(size.width), usize::from(size.height));
    let seconds = 1e-6 * events.t().last()?.0 as f64;
    let mut counts = vec![0.0_f64; size.pixels()];
    for event in events.iter() {
        counts[usize::from(event.y) * width + usize::from(event.x)] += 1.0;
    }
    let mut excesses = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let mut near = Vec::with_capacity(8);
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    if (u, v) != (x, y) {
                        near.push(counts[v * width + u]);
                    }
                }
            }
            near.sort_by(f64::total_cmp);
            let (median, max) = (near[near.len() / 2], near[near.len() - 1]);
            let count = counts[y * width + x];
            // Twice the largest neighbour as well: an edge that rests raises half of the
            // neighbours.
            if count > HOT_FACTOR * median + HOT_EXCESS && count > 2.0 * max {
                excesses.push(count - median);
            }
        }
    }
    excesses.sort_by(f64::total_cmp);
    let median = excesses.get(excesses.len() / 2)?;
    let fraction = (excesses.len() as f64 / size.pixels() as f64).clamp(1e-6, 0.5);
    let median_hz = (median / seconds).clamp(0.1, 1e4);
    Some(Reading::new([("fraction", fraction.into()), ("median_hz", median_hz.into())], 0.0))
}

/// Fraction of time stamps that must be locked to a scan for its period to be used.
const MIN_LOCKED: f64 = 0.2;

/// Axis and direction of a readout that scans lines in turn, and its period if it is significant.
fn scan(events: &EventStream) -> Option<Reading> {
    let scan = crate::probe::scan_of(events)?;
    let axis = if scan.is_by_row { "rows" } else { "columns" };
    let direction = if scan.is_backward { "backward" } else { "forward" };
    let period = (scan.locked > MIN_LOCKED).then(|| ("period_us", scan.period_us.into()));
    let words = [("axis", axis.into()), ("direction", direction.into())];
    Some(Reading::new(words.into_iter().chain(period), scan.locked))
}

/// Longest interval between two events of a busy bus, microseconds.
const MAX_SERVICE_US: usize = 1_000;
/// Fraction of the intervals that the most common one must have for a bus to set it.
const MIN_PACED: f64 = 0.25;

/// Service times of a bus per event and per change of row: the most common intervals between
/// successive events in one row and in two.
fn bus(events: &EventStream) -> Option<Reading> {
    let mut histograms = [vec![0_usize; MAX_SERVICE_US], vec![0_usize; MAX_SERVICE_US]];
    let all: Vec<(i64, u16)> = events.iter().map(|event| (event.t.0, event.y)).collect();
    for pair in all.windows(2) {
        let &[(before_us, row), (now_us, other)] = pair else { continue };
        // A change of row costs the bus a selection on top of the event.
        let histogram = &mut histograms[usize::from(row != other)];
        if let Some(n) = histogram.get_mut((now_us - before_us) as usize) {
            *n += 1;
        }
    }
    let service = histograms.map(|counts| {
        // Stamps are cut to whole microseconds: one interval falls into two bins.
        let at = |us: usize| counts[us] + counts[us - 1];
        let best = (2..MAX_SERVICE_US).max_by_key(|us| at(*us))?;
        let (n, m) = (counts[best] as f64, counts[best - 1] as f64);
        let all: usize = counts.iter().sum();
        let mean_us = best as f64 - m / (n + m);
        let fraction = (n + m) / all.max(1) as f64;
        (fraction > MIN_PACED).then_some((mean_us, fraction))
    });
    let [Some((event_us, of_events)), Some((row_us, of_rows))] = service else { return None };
    let row_ns = (1e3 * (row_us - event_us)).max(1.0);
    let params = [("rate_hz", (1e6 / event_us).into()), ("row_ns", row_ns.into())];
    Some(Reading::new(params, of_events.min(of_rows)))
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use super::*;
    use crate::probe::testing::on;

    fn stream(events: impl IntoIterator<Item = (f64, u16, u16)>) -> EventStream {
        let size = SensorSize { width: 20, height: 30 };
        let event = |(t_us, x, y): (f64, u16, u16)| on(t_us as i64, x, y);
        EventStream::from_events(size, events.into_iter().map(event)).unwrap()
    }

    #[test]
    fn service_times_are_the_intervals_of_a_busy_bus() {
        for (event_us, row_us) in [(4.0, 60.0), (2.7, 31.4)] {
            let mut t_us = 100.0;
            let mut busy = Vec::new();
            for sweep in 0..40_u16 {
                for y in 0..30 {
                    t_us += row_us;
                    for x in (0..20).filter(|x| (x + y + sweep) % 3 > 0) {
                        t_us += event_us;
                        busy.push((t_us, x, y));
                    }
                }
                t_us += 3_000.0;
            }
            let reading = bus(&stream(busy)).unwrap();
            assert!(reading.consistent > 0.9, "{reading:?}");
            let value = |key| reading.number(key).unwrap();
            assert!((1e6 / value("rate_hz") - event_us).abs() < 0.1, "{reading:?}");
            assert!((1e-3 * value("row_ns") - row_us).abs() < 0.6, "{reading:?}");
        }
    }

    #[test]
    fn pixels_without_expected_events_are_silent() {
        // Ten events each are expected of four hundred pixels, of which some have none.
        let without = |is_silent: fn(u16) -> bool| {
            (0..4_000_u16).filter(move |k| !is_silent(k % 400)).map(|k| {
                let pixel = k % 400;
                (f64::from(k) * 100.0, pixel % 20, pixel / 20)
            })
        };
        let expected = Expected::from_events(&stream(without(|_| false)));
        let fraction = |is_silent: fn(u16) -> bool| {
            let reading = silent_pixels(&stream(without(is_silent)), &expected);
            reading.unwrap().number("fraction").unwrap()
        };
        assert!((fraction(|pixel| pixel * 37 % 100 < 8) - 0.08).abs() < 0.01);
        assert!(fraction(|_| false) <= 1e-6);
        // Six rows are no dead pixels.
        assert!(fraction(|pixel| pixel < 120) < 0.02);
        // Too few events are expected for any to be missed.
        let few = Expected::from_events(&stream(without(|_| false).take(800)));
        assert!(silent_pixels(&stream(without(|_| false)), &few).is_none());
    }

    #[test]
    fn a_lamp_is_found_beside_a_scene_that_flashes() {
        // Seven flashes a second by the scene, far stronger than the lamp of 120 Hz.
        let flashes =
            || (0..7).flat_map(|k| (0..400).map(move |i| (1e6 / 7.0 * f64::from(k), i % 20, 5)));
        let lamp = (0..120).flat_map(|k| {
            (0..8).map(move |i| (f64::from(k) * 1e6 / 120.0 + 300.0 * f64::from(i), i, 7))
        });
        let mut events: Vec<(f64, u16, u16)> = flashes().chain(lamp).collect();
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let hz = |expected: &Expected| {
            flicker(&stream(events.clone()), expected).unwrap().number("frequency_hz").unwrap()
        };
        let nothing = Expected::from_events(&stream([]));
        assert!((hz(&nothing) - 120.0).abs() > 1.0);
        assert!((hz(&Expected::from_events(&stream(flashes()))) - 120.0).abs() < 0.2);
    }

    #[test]
    fn events_at_random_times_show_no_bus() {
        let spread = (0..9_000_u32).map(|k| {
            let place = k.wrapping_mul(2_654_435_761) >> 8;
            let late = f64::from(k.wrapping_mul(40_503) % 97);
            (100.0 * f64::from(k) + late, (place % 20) as u16, (place / 20 % 30) as u16)
        });
        assert!(bus(&stream(spread)).is_none());
    }
}
