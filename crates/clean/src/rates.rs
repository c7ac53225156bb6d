//! Checks of a recording's rates: hot pixels, flicker of lamps, a full bus, gaps.
//!
//! # Model
//! Events are counted by millisecond. A lamp shows as power at 100 or 120 Hz above that of white noise, a
//! full bus as a ceiling that many milliseconds reach, lost packets as silences in the midst of events.

use evpose_core::{EventStream, Micros, SensorSize};
use serde::Serialize;

use crate::{HotRule, PixelActivity};

/// Width of a bin of time.
const BIN: Micros = Micros(1_000);
/// Bins that are kept: an hour, so that memory is bounded.
const MAX_BINS: usize = 3_600_000;
/// Fewest bins that show a frequency or a limit.
const MIN_BINS: usize = 200;
/// Frequencies of lamps on mains of 50 and 60 Hz.
const LAMPS_HZ: [f64; 2] = [100.0, 120.0];
/// Power at a lamp's frequency over that of white noise from which on it is flicker.
const FLICKER: f64 = 40.0;
/// Share of the fullest bins' count that is their plateau, and share of all bins that lie on it.
const PLATEAU: f64 = 0.97;
const SATURATED: f64 = 0.1;
/// Share of the fullest bins' count that a tenth of the bins stay below: steady rates have no ceiling.
const VARIES: f64 = 0.6;
/// Silence in the midst of events that is a gap, in bins, and the mean count around it.
const GAP_BINS: usize = 20;
const BUSY: f64 = 20.0;

/// Looks at the rates of a recording, batch by batch.
#[derive(Debug)]
pub struct RateCheck {
    activity: PixelActivity,
    bins: Vec<u32>,
    begin: Option<Micros>,
}

/// Results of the check of rates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct RateFindings {
    /// Pixels that fire far more often than their neighbours.
    pub hot_pixels: usize,
    /// Frequency of a lamp, in Hz.
    pub flicker_hz: Option<f64>,
    /// Rate of the whole sensor that is not exceeded, in events a second.
    pub saturated_at_hz: Option<f64>,
    /// Silences of 20 ms and more in the midst of many events.
    pub gaps: usize,
}

impl RateCheck {
    /// A check of a recording of `sensor`, before its first events.
    pub fn new(sensor: SensorSize) -> Self {
        Self { activity: PixelActivity::new(sensor), bins: Vec::new(), begin: None }
    }

    /// Counts a batch.
    ///
    /// # Panics
    /// If it is of a sensor of another size.
    pub fn push(&mut self, events: &EventStream) {
        self.activity.push(events);
        for t in events.t() {
            let begin = *self.begin.get_or_insert(*t);
            let bin = (t.0.saturating_sub(begin.0) / BIN.0) as usize;
            if bin < MAX_BINS {
                self.bins.resize(self.bins.len().max(bin + 1), 0);
                self.bins[bin] += 1;
            }
        }
    }

    /// The findings so far.
    pub fn findings(&self) -> RateFindings {
        RateFindings {
            hot_pixels: self.activity.hot(HotRule::default()).len(),
            flicker_hz: flicker_hz(&self.bins),
            saturated_at_hz: saturated_at_hz(&self.bins),
            gaps: gaps(&self.bins),
        }
    }
}

/// The frequency of a lamp that the counts follow, by the power at it over the mean power.
fn flicker_hz(bins: &[u32]) -> Option<f64> {
    if bins.len() < MIN_BINS {
        return None;
    }
    let n = bins.len() as f64;
    let mean = bins.iter().map(|count| f64::from(*count)).sum::<f64>() / n;
    let energy: f64 = bins.iter().map(|count| (f64::from(*count) - mean).powi(2)).sum();
    let power = |hz: f64| {
        let step = std::f64::consts::TAU * hz * BIN.as_seconds();
        let (mut re, mut im) = (0.0, 0.0);
        for (k, count) in bins.iter().enumerate() {
            let (sin, cos) = (step * k as f64).sin_cos();
            re += (f64::from(*count) - mean) * cos;
            im += (f64::from(*count) - mean) * sin;
        }
        // White noise has a mean of one.
        (re * re + im * im) / energy.max(1.0)
    };
    let found =
        LAMPS_HZ.into_iter().map(|hz| (power(hz), hz)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (found.0 > FLICKER).then_some(found.1)
}

/// The rate at which the counts have a ceiling.
fn saturated_at_hz(bins: &[u32]) -> Option<f64> {
    let most = f64::from(*bins.iter().max()?);
    let full = bins.iter().filter(|count| f64::from(**count) >= PLATEAU * most).count();
    let quiet = bins.iter().filter(|count| f64::from(**count) < VARIES * most).count();
    let share = |count: usize| count as f64 / bins.len() as f64;
    let is_saturated = bins.len() >= MIN_BINS
        && most >= BUSY
        && share(full) > SATURATED
        && share(quiet) > SATURATED;
    is_saturated.then(|| most / BIN.as_seconds())
}

/// Silences between busy times.
fn gaps(bins: &[u32]) -> usize {
    let busy = |part: &[u32]| {
        let events: f64 = part.iter().map(|count| f64::from(*count)).sum();
        part.len() == GAP_BINS && events > BUSY * GAP_BINS as f64
    };
    let (mut gaps, mut at) = (0, 0);
    while at < bins.len() {
        let silent = bins[at..].iter().take_while(|count| **count == 0).count();
        if silent >= GAP_BINS {
            let (before, behind) = (at.saturating_sub(GAP_BINS), at + silent);
            let end = bins.len().min(behind + GAP_BINS);
            // A scene at rest is silent as well: only a silence between busy times is a loss.
            gaps += usize::from(busy(&bins[before..at]) && busy(&bins[behind..end]));
        }
        at += silent.max(1);
    }
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_ceilings_and_gaps_are_found_and_steady_noise_is_none() {
        // A generator of its own: draws must stay the same in all versions.
        let mut state = 9_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            40 + (state >> 60) as u32
        };
        let steady: Vec<u32> = (0..2_000).map(|_| noise()).collect();
        assert_eq!((flicker_hz(&steady), saturated_at_hz(&steady), gaps(&steady)), (None, None, 0));
        let lamp = |hz: f64| -> Vec<u32> {
            let wave =
                |k: usize| 30.0 * (1.0 + (std::f64::consts::TAU * hz * k as f64 / 1e3).sin());
            steady.iter().enumerate().map(|(k, n)| n + wave(k) as u32).collect()
        };
        assert_eq!(flicker_hz(&lamp(100.0)), Some(100.0));
        assert_eq!(flicker_hz(&lamp(120.0)), Some(120.0));
        // Half of the milliseconds lie on a ceiling of 500 events, the others rise to it.
        let full: Vec<u32> = (0..2_000).map(|k| (k % 100 * 10).min(500)).collect();
        assert_eq!(saturated_at_hz(&full), Some(500_000.0));
        let mut cut = steady;
        cut[500..530].fill(0);
        assert_eq!(gaps(&cut), 1);
    }
}
