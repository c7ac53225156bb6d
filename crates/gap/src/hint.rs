//! Where to begin with numbers that a fit cannot find by going downhill: they are read off the
//! recording.

use std::f64::consts::TAU;

use evpose_core::EventStream;
use evpose_sensor::EffectConfig;

use crate::candidate::Trial;

/// What a recording shows directly of some effects.
#[derive(Debug, Clone)]
pub struct Hints {
    of: Vec<(&'static str, EffectConfig)>,
}

impl Hints {
    /// Reads them off a recording.
    pub fn of(events: &EventStream) -> Self {
        let of = [flicker(events), tick(events), hot(events), scan(events)];
        Self { of: of.into_iter().flatten().map(|effect| (effect.0, effect.1)).collect() }
    }

    /// The trial, with the numbers that the recording shows directly set and no longer fitted.
    pub(crate) fn applied(&self, name: &str, trial: &Trial) -> Trial {
        let mut hinted = trial.clone();
        let Some((_, read)) = self.of.iter().find(|(effect, _)| *effect == name) else {
            return hinted;
        };
        hinted.effect.params.extend(read.params.clone());
        // The strength stays, so that there is something to fit.
        let head = trial.params[0];
        hinted.params.retain(|p| p.name == head.name || !read.params.contains_key(p.name));
        hinted
    }
}

/// An effect with what was read of it.
type Read = (&'static str, EffectConfig);

/// Rates are sampled this often.
const BIN_US: i64 = 500;
/// Where lamps, pulsed or fed by mains, are looked for.
const FLICKER_HZ: (f64, f64) = (30.0, 900.0);

/// Frequency and phase of the strongest line of the ON rate less the OFF rate: light that goes up
/// and down makes them alternate.
fn flicker(events: &EventStream) -> Option<Read> {
    let end = events.t().last()?.0;
    let mut rate = vec![0.0_f64; (end / BIN_US) as usize + 1];
    for event in events.iter() {
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
    Some(("lamp_flicker", read.with("phase_turns", phase_turns.rem_euclid(1.0))))
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
    (tick > 1).then(|| (name, EffectConfig::new(name).with("period_us", tick as f64)))
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
    Some(("hot_pixels", read.with("median_hz", (median / seconds).max(0.1))))
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
    Some(("scanned_readout", read))
}
