//! Spectrum of event rates: flicker is a line, with ON and OFF in antiphase.
//!
//! # Model
//! ON and OFF events are counted in bins of half a millisecond. For independent events the power
//! `|F|^2` at every frequency is the number of events; powers are relative to that. The line
//! statistic is Fisher's (1929): the largest ordinate between 30 and 950 Hz as a fraction of their
//! sum.

use crate::fourier::Fourier;
use crate::probe::MAX_BINS;
use crate::probe::interface::StatisticProbe;
use crate::{Entry, StatisticBlock, View};

/// Power in bands, the strongest line and the agreement of its polarities, for all pixels and for
/// those at rest.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "spectrum", entries, measure };

const BIN_US: i64 = 500;
const BANDS: usize = 12;
const LOW_HZ: f64 = 4.0;
const HIGH_HZ: f64 = 1_000.0;
/// Frequency range of lines: above most motion, below the Nyquist frequency of the bins.
const LINE_HZ: (f64, f64) = (30.0, 950.0);
/// Prior count that shrinks powers of few events towards those of independent events.
const SETTLED: f64 = 10.0;
const GROUPS: [&str; 2] = ["all pixels", "pixels at rest"];

fn band(hz: f64) -> Option<usize> {
    let place = (hz / LOW_HZ).ln() / (HIGH_HZ / LOW_HZ).ln() * BANDS as f64;
    (0.0..BANDS as f64).contains(&place).then_some(place as usize)
}

/// ON rate in the real part and OFF rate in the imaginary part, without their means.
struct Rates {
    counts: Fourier,
    bins: usize,
    events: f64,
}

impl Rates {
    fn new(bins: usize) -> Self {
        Self { counts: Fourier::zeros(bins), bins, events: 0.0 }
    }

    fn add(&mut self, bin: usize, is_on: bool) {
        let side = if is_on { &mut self.counts.re } else { &mut self.counts.im };
        side[bin] += 1.0;
        self.events += 1.0;
    }

    fn measure(mut self, out: &mut Vec<f64>) {
        // The mean would leak into the lowest frequencies.
        for side in [&mut self.counts.re, &mut self.counts.im] {
            let mean = side.iter().sum::<f32>() / self.bins as f32;
            side[..self.bins].iter_mut().for_each(|n| *n -= mean);
        }
        self.counts.transform();
        let length = self.counts.length();
        let step_hz = 1e6 / (BIN_US as f64 * length as f64);
        let mut powers = [(0.0, 0.0); BANDS];
        let (mut strongest, mut all, mut opposed) = (0.0_f64, 0.0, 0.0);
        for k in 1..length / 2 {
            let hz = k as f64 * step_hz;
            // Spectra of two real signals from one complex transform.
            let [ar, ai] = self.counts.at(k).map(f64::from);
            let [br, bi] = self.counts.at(length - k).map(f64::from);
            let (on_re, on_im) = (0.5 * (ar + br), 0.5 * (ai - bi));
            let (off_re, off_im) = (0.5 * (ai + bi), 0.5 * (br - ar));
            let on = on_re * on_re + on_im * on_im;
            let off = off_re * off_re + off_im * off_im;
            if let Some(band) = band(hz) {
                powers[band].0 += on + off;
                powers[band].1 += 1.0;
            }
            if (LINE_HZ.0..LINE_HZ.1).contains(&hz) {
                all += on + off;
                if on + off > strongest {
                    strongest = on + off;
                    // The cosine of their phase: -1 in antiphase.
                    let product = on_re * off_re + on_im * off_im;
                    opposed = product / (on * off).sqrt().max(f64::MIN_POSITIVE);
                }
            }
        }
        out.extend(powers.iter().map(|(power, ordinates)| {
            // A band without ordinates counts as one of independent events.
            let mean = if *ordinates > 0.0 { power / ordinates } else { self.events };
            ((mean + SETTLED) / (self.events + SETTLED)).log10()
        }));
        // Zero padding spreads a line over neighbouring ordinates, which is no weaker line.
        let spread = length as f64 / self.bins as f64;
        let line = if all > 0.0 { (spread * strongest / all).min(1.0) } else { 0.0 };
        let line = line * self.events / (self.events + SETTLED);
        out.extend([line, line * opposed]);
    }
}

fn entries() -> Vec<Entry> {
    let value = |name, tolerance| Entry::value(StatisticBlock::Spectrum, name, tolerance);
    let group = |group: &'static str| {
        let bands =
            (0..BANDS).map(move |band| value(format!("log10 power of {group}, band {band}"), 0.1));
        let line = value(format!("strongest line of {group}"), 0.02);
        let phase = value(format!("agreement of ON and OFF in the line of {group}"), 0.02);
        bands.chain([line, phase])
    };
    GROUPS.iter().flat_map(|name| group(name)).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let bins = (view.window.length().0 / BIN_US).clamp(1, MAX_BINS as i64) as usize;
    let (mut all, mut quiet) = (Rates::new(bins), Rates::new(bins));
    for event in view.events() {
        let bin = (view.since_start_us(event.t_us) / BIN_US) as usize;
        if bin >= bins {
            // An incomplete last bin, or beyond the longest transform.
            break;
        }
        all.add(bin, event.is_on);
        if event.cell.is_quiet() {
            quiet.add(bin, event.is_on);
        }
    }
    all.measure(out);
    quiet.measure(out);
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros, Polarity};

    use super::*;
    use crate::probe::testing;

    /// Flicker of pixels at rest: ON and OFF half a period apart, or together.
    fn flicker(opposed: bool) -> EventStream {
        let noise = testing::noise(6_000, 3).into_iter();
        let bound = noise.filter(|event| event.x >= testing::REST_FROM).map(|event| {
            let period_us = 1e6 / 120.0;
            let cycle = (event.t.0 as f64 / period_us).floor().min(70.0);
            let late = if opposed && event.polarity == Polarity::On { 0.5 } else { 0.0 };
            Event { t: Micros(((cycle + late) * period_us) as i64), ..event }
        });
        testing::stream(bound.chain(testing::events().iter()))
    }

    #[test]
    fn flicker_is_a_line_with_on_and_off_in_antiphase() {
        let even = testing::noise(2_000, 3).into_iter().chain(testing::events().iter());
        let even = testing::stream(even);
        let value = |events: &EventStream, name: &str| testing::value(&PROBE, events, name);
        let line = "strongest line of pixels at rest";
        let phase = "agreement of ON and OFF in the line of pixels at rest";
        assert!(value(&even, line) < 0.05, "{}", value(&even, line));
        // Pulses have harmonics, seven of them below the limit.
        assert!(value(&flicker(true), line) > 0.1, "{}", value(&flicker(true), line));
        assert!(value(&flicker(false), phase) > 0.9 * value(&flicker(false), line));
    }

    #[test]
    fn the_phase_of_the_first_harmonic_distinguishes_opposed_from_common() {
        let mut rates = Rates::new(1_200);
        for bin in 0..1_200 {
            // 100 Hz: twenty bins a cycle, ten of ON and then ten of OFF.
            rates.add(bin, bin % 20 < 10);
        }
        let mut values = Vec::new();
        rates.measure(&mut values);
        let [.., line, agreement] = values[..] else { panic!("no line") };
        // Harmonics of the pulses and the place between two ordinates take the rest.
        assert!(line > 0.6 && agreement < -0.95 * line, "{line} {agreement}");
    }

    #[test]
    fn the_power_of_independent_events_is_their_count() {
        let mut rates = Rates::new(1_200);
        for event in testing::noise(20_000, 4) {
            rates.add((event.t.0 / BIN_US) as usize, event.polarity.is_on());
        }
        let mut values = Vec::new();
        rates.measure(&mut values);
        // The upper bands have tens of ordinates.
        for power in &values[6..BANDS] {
            assert!(power.abs() < 0.2, "{power}");
        }
    }
}
