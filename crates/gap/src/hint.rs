//! Where to begin with numbers that a fit cannot find by going downhill: they are read off the
//! recording.

use std::f64::consts::TAU;

use evpose_core::EventStream;
use evpose_sensor::{EffectConfig, ParamSpec, STAGES, SensorConfig};

use crate::candidate::{Candidate, Trial};
use crate::parameters::Parameter;

/// What a recording shows directly of some effects.
#[derive(Debug, Clone)]
pub struct Hints {
    of: Vec<Read>,
}

impl Hints {
    /// Reads them off a recording.
    pub fn of(events: &EventStream) -> Self {
        let of = [flicker(events), tick(events), hot(events), scan(events), bus(events)];
        Self { of: of.into_iter().flatten().collect() }
    }

    /// A readout that stamps leave no doubt about, whatever else there is, beside `model`.
    pub(crate) fn sure(
        &self,
        model: &SensorConfig,
        left_out: &[String],
    ) -> Option<(&'static str, Trial)> {
        let is_sure = |(_, _, share): &&Read| *share > SURE;
        let (name, ..) = self.of.iter().rev().find(is_sure)?;
        let candidate =
            Candidate::beside(model, left_out).into_iter().find(|one| one.name() == *name)?;
        let (_, words) = USUAL.iter().find(|(effect, _)| effect == name)?;
        let has_words = |trial: &Trial| {
            words.iter().all(|(key, word)| {
                trial.effect.params.get(*key) == Some(&evpose_sensor::Value::from(*word))
            })
        };
        let mut plainest =
            candidate.trials().into_iter().filter_map(|form| form.into_iter().next());
        let trial = plainest.rfind(has_words)?;
        Some((name, self.applied(name, &trial)))
    }

    /// The trial, with the numbers that the recording shows directly set. They are no longer fitted,
    /// but for those that it shows roughly.
    pub(crate) fn applied(&self, name: &str, trial: &Trial) -> Trial {
        let mut hinted = trial.clone();
        let Some((_, read, _)) = self.of.iter().find(|(effect, ..)| *effect == name) else {
            return hinted;
        };
        hinted.effect.params.extend(read.params.clone());
        // The strength stays, so that there is something to fit.
        let head = trial.params[0];
        hinted.params.retain(|p| p.name == head.name || !read.params.contains_key(p.name));
        let spec = STAGES.iter().find(|spec| spec.name == name);
        let is_rough = |p: &&ParamSpec| p.name != head.name && ROUGH.contains(&(name, p.name));
        hinted.params.extend(spec.iter().flat_map(|spec| spec.params.iter().filter(is_rough)));
        hinted
    }

    /// What else a recording may mean by which a trial beside `model` is the best: none for most
    /// effects.
    pub(crate) fn readings(&self, name: &str, trial: &Trial, model: &SensorConfig) -> Vec<Trial> {
        let read = self.of.iter().find(|(effect, ..)| *effect == name && name == "lamp_flicker");
        let Some(turns) = read.and_then(|(_, read, _)| read.number("phase_turns")) else {
            return Vec::new();
        };
        let threshold =
            Parameter::ThresholdOn.value(model).min(Parameter::ThresholdOff.value(model));
        let mut all = Vec::new();
        for later in LATER_TURNS {
            for swing in SWINGS {
                for word in ["now", "trough"] {
                    // From (1 - depth) to (1 + depth) is the swing.
                    let depth = (0.5 * swing * threshold).tanh();
                    let at = trial.with(trial.params[0], depth);
                    let effect = at.effect.with("phase_turns", (turns + later).rem_euclid(1.0));
                    all.push(Trial { effect: effect.with("memory", word), params: at.params });
                }
            }
        }
        all
    }
}

/// Around a lamp whose swing is hardly more than a threshold: pixels answer late, up to where the light
/// turns, and much more where it is a little stronger. Turns later, and swings in thresholds.
const LATER_TURNS: [f64; 6] = [0.0, 0.04, 0.08, 0.12, 0.16, 0.2];
const SWINGS: [f64; 9] = [0.85, 1.0, 1.04, 1.09, 1.14, 1.2, 1.27, 1.36, 1.5];
/// Where so many stamps keep to a readout, it is there.
const SURE: f64 = 0.9;
/// What pixels do while they wait for it, and how it is read.
const USUAL: &[(&str, &[(&str, &str)])] = &[
    ("arbiter", &[("order", "rows"), ("waiting", "free")]),
    ("scanned_readout", &[("waiting", "latched")]),
];

/// Numbers that are read off roughly: events come late in the wave of a lamp, stamps of a bus are
/// whole microseconds.
const ROUGH: &[(&str, &str)] =
    &[("lamp_flicker", "phase_turns"), ("arbiter", "rate_hz"), ("arbiter", "row_ns")];

/// An effect with what was read of it, and the share of stamps that keep to it.
type Read = (&'static str, EffectConfig, f64);

/// Rates are sampled this often.
const BIN_US: i64 = 500;
/// Where lamps, pulsed or fed by mains, are looked for.
const FLICKER_HZ: (f64, f64) = (30.0, 900.0);

/// Frequency and phase of the strongest line of the ON rate less the OFF rate: light that goes up
/// and down makes them alternate.
fn flicker(events: &EventStream) -> Option<Read> {
    let end = events.t().last()?.0;
    let mut rate = vec![0.0_f64; (end / BIN_US) as usize + 1];
    for event in events.iter().filter(|event| event.t.0 >= 0) {
        let sign = if event.polarity.is_on() { 1.0 } else { -1.0 };
        rate[(event.t.0 / BIN_US) as usize] += sign;
    }
    let seconds = 1e-6 * end as f64;
    let transform = |hz: f64| -> (f64, f64) {
        let turn = TAU * hz * 1e-6 * BIN_US as f64;
        // Stamps lie in the middle of their bins.
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
    let (c, s) = transform(hz);
    // Light 1 + m sin(2 pi f t + phi) changes as cos(2 pi f t + phi), whose transform this is.
    let phase_turns = (-s).atan2(c) / TAU;
    let read = EffectConfig::new("lamp_flicker").with("frequency_hz", hz);
    Some(("lamp_flicker", read.with("phase_turns", phase_turns.rem_euclid(1.0)), 0.0))
}

/// The longest period that all stamps keep to; none where that is the microsecond.
fn tick(events: &EventStream) -> Option<Read> {
    let gcd = |mut a: i64, mut b: i64| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let first = events.t().first()?.0;
    let tick = events.t().iter().fold(0, |tick, t| gcd(tick, t.0 - first));
    let name = "timestamp_quantisation";
    (tick > 1).then(|| (name, EffectConfig::new(name).with("period_us", tick as f64), 0.0))
}

/// A hot pixel has so many events more than the median of its neighbours, and so many times more.
const EXCESS: f64 = 8.0;
const TIMES: f64 = 4.0;

/// Share and median rate of pixels that are far above their neighbours.
fn hot(events: &EventStream) -> Option<Read> {
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
            let (median, most) = (near[near.len() / 2], near[near.len() - 1]);
            let count = counts[y * width + x];
            if count > TIMES * median + EXCESS && count > 2.0 * most {
                excesses.push(count - median);
            }
        }
    }
    excesses.sort_by(f64::total_cmp);
    let median = excesses.get(excesses.len() / 2)?;
    let fraction = (excesses.len() as f64 / size.pixels() as f64).clamp(1e-6, 0.5);
    let read = EffectConfig::new("hot_pixels").with("fraction", fraction);
    Some(("hot_pixels", read.with("median_hz", (median / seconds).max(0.1)), 0.0))
}

/// A readout is believed where this share of all stamps is locked to it.
const LOCKED: f64 = 0.2;

/// Axis and direction of a readout that visits lines in turn, and its period where most stamps keep
/// to it.
fn scan(events: &EventStream) -> Option<Read> {
    let found = crate::probe::scan_of(events)?;
    let read = EffectConfig::new("scanned_readout")
        .with("axis", if found.is_by_row { "rows" } else { "columns" })
        .with("direction", if found.is_backward { "backward" } else { "forward" });
    let is_locked = found.locked > LOCKED;
    let read = if is_locked { read.with("period_us", found.period_us) } else { read };
    Some(("scanned_readout", read, found.locked))
}

/// Longest time between two events of a busy bus, microseconds.
const BUSY_US: usize = 1_000;
/// Times between events that a bus sets are this share of all, or more.
const PACED: f64 = 0.25;

/// Times that a bus takes for an event and for another row: those most common between events that
/// follow each other, in one row and in two.
fn bus(events: &EventStream) -> Option<Read> {
    let mut times = [vec![0_usize; BUSY_US], vec![0_usize; BUSY_US]];
    let all: Vec<(i64, u16)> = events.iter().map(|event| (event.t.0, event.y)).collect();
    for pair in all.windows(2) {
        let &[(before_us, row), (now_us, other)] = pair else { continue };
        if let Some(n) = times[usize::from(row != other)].get_mut((now_us - before_us) as usize) {
            *n += 1;
        }
    }
    let paced = times.map(|times| {
        // Stamps are cut to whole microseconds: a time goes to two bins.
        let at = |us: usize| times[us] + times[us - 1];
        let best = (2..BUSY_US).max_by_key(|us| at(*us))?;
        let (n, m) = (times[best] as f64, times[best - 1] as f64);
        let all: usize = times.iter().sum();
        let mean_us = best as f64 - m / (n + m);
        let share = (n + m) / all.max(1) as f64;
        (share > PACED).then_some((mean_us, share))
    });
    let [Some((event_us, of_events)), Some((row_us, of_rows))] = paced else { return None };
    let row_ns = (1e3 * (row_us - event_us)).max(1.0);
    let read = EffectConfig::new("arbiter").with("rate_hz", 1e6 / event_us);
    Some(("arbiter", read.with("row_ns", row_ns), of_events.min(of_rows)))
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity, SensorSize};

    use super::*;

    fn stream(events: impl IntoIterator<Item = (f64, u16, u16)>) -> EventStream {
        let size = SensorSize { width: 20, height: 30 };
        let event = |(t_us, x, y): (f64, u16, u16)| Event {
            t: Micros(t_us as i64),
            x,
            y,
            polarity: Polarity::On,
        };
        EventStream::from_events(size, events.into_iter().map(event)).unwrap()
    }

    #[test]
    fn a_lamp_may_be_late_and_its_swing_just_above_the_threshold() {
        // ON events of a lamp of 100 Hz, for four of ten milliseconds, a sixth of a turn behind its
        // steepest rise on the whole.
        let pulse = |k: i32| (-4..=4).map(move |i| (1e4 * (f64::from(k) + 1.0 / 6.0), i));
        let events = (1..100).flat_map(pulse).map(|(t_us, i)| (t_us + 500.0 * f64::from(i), 3, 4));
        let hints = Hints::of(&stream(events));
        let mut model = SensorConfig::from_toml("").unwrap();
        Parameter::ThresholdOn.set(&mut model, 0.25);
        Parameter::ThresholdOff.set(&mut model, 0.3);
        let of = |name: &str| {
            let candidates = Candidate::beside(&model, &[]);
            let candidate = candidates.into_iter().find(|one| one.name() == name).unwrap();
            hints.readings(name, &candidate.trials()[0][0], &model)
        };
        let read = of("lamp_flicker");
        let is_near = |trial: &Trial| {
            let number = |name| trial.effect.number(name).unwrap();
            let turns = (number("phase_turns") + 0.5).rem_euclid(1.0) - 0.5;
            let swing = 2.0 * number("depth").atanh();
            turns.abs() < 0.025 && (swing / (1.1 * 0.25) - 1.0).abs() < 0.05
        };
        assert!(read.iter().any(is_near), "none of {}", read.len());
        assert!(of("refractory").is_empty());
    }

    #[test]
    fn times_of_a_bus_are_read_off_what_it_is_busy_with() {
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
            let (_, read, share) = bus(&stream(busy)).unwrap();
            assert!(share > 0.9, "{share}");
            let found = |key| read.number(key).unwrap();
            assert!((1e6 / found("rate_hz") - event_us).abs() < 0.1, "{read:?}");
            assert!((1e-3 * found("row_ns") - row_us).abs() < 0.6, "{read:?}");
        }
    }

    #[test]
    fn events_that_nothing_paces_show_no_bus() {
        let spread = (0..9_000_u32).map(|k| {
            let place = k.wrapping_mul(2_654_435_761) >> 8;
            let late = f64::from(k.wrapping_mul(40_503) % 97);
            (100.0 * f64::from(k) + late, (place % 20) as u16, (place / 20 % 30) as u16)
        });
        assert!(bus(&stream(spread)).is_none());
    }
}
