//! Background rates and hot pixels from a recording of a scene at rest.
//!
//! # Model
//! Events of pixels at rest come at a rate per pixel and polarity. A pixel is hot if no pixel of a
//! rate [`HOT`] times the mean of the others would have so many events, at a probability of 0.01
//! over the whole image (Poisson; Bonferroni). Hot pixels do not count for the rates.
//!
//! Intervals of 95 % are bootstrapped over twenty parts of time. [`Noise::unrest`] is the largest
//! of these parts over their mean: a lamp, or somebody who walks by, makes it much larger than one.

use evpose_core::stats::bootstrap::{BootstrapConfig, bootstrap};
use evpose_core::stats::interval::Interval;
use evpose_core::{EventStream, Micros, TimeWindow};
use serde::Serialize;

use crate::calibrate::CalibrateError;

/// Rate of a hot pixel, in rates of the others, from which it is called hot.
pub const HOT: f64 = 5.0;
/// Probability that at least one pixel of an image is called hot although it is not.
const CHANCE: f64 = 0.01;
/// Parts of equal length into which a recording is divided.
const PARTS: usize = 20;
/// Minimum length: in shorter recordings the parts of time hold too few events.
const MIN_LENGTH: Micros = Micros(100_000);
/// Draws of the bootstrap.
const RESAMPLES: usize = 4_000;
/// Largest number of iterations; the set of hot pixels converges after a few.
const ROUNDS: usize = 50;

/// A pixel that has many more events than others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HotPixelRate {
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// ON events per second.
    pub on_hz: f64,
    /// OFF events per second.
    pub off_hz: f64,
}

/// Background activity of a camera at rest.
#[derive(Debug, Clone, Serialize)]
pub struct Noise {
    /// ON events per pixel and second, without hot pixels.
    pub on_hz: Interval,
    /// OFF events per pixel and second, without hot pixels.
    pub off_hz: Interval,
    /// The same of the whole image, hot pixels included, events per second.
    pub all_on_hz: f64,
    /// See [`Self::all_on_hz`].
    pub all_off_hz: f64,
    /// Hot pixels, those with the most events first.
    pub hot: Vec<HotPixelRate>,
    /// The busiest twentieth of time over the mean, without hot pixels.
    pub unrest: f64,
    /// Seconds of the recording that were looked at.
    pub seconds: f64,
}

/// Looks at the events of a window, in which nothing moves; `seed` draws the intervals.
///
/// # Errors
/// A window that is too short.
pub fn noise(events: &EventStream, window: TimeWindow, seed: u64) -> Result<Noise, CalibrateError> {
    let seconds = window.length().as_seconds();
    if window.length() < MIN_LENGTH {
        return Err(CalibrateError::TooShort(seconds, MIN_LENGTH.as_seconds()));
    }
    let size = events.sensor();
    let width = usize::from(size.width);
    let range = events.range(window);
    let mut counts = vec![[0_u32; 2]; size.pixels()];
    let mut parts = [[0_u32; 2]; PARTS];
    let looked_at = || range.clone().filter_map(|i| events.get(i));
    for event in looked_at() {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        counts[pixel][usize::from(event.polarity.is_on())] += 1;
    }
    let is_hot = hot(&counts);
    // Of the other pixels, since hot ones would dominate any rate.
    for event in looked_at() {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        if !is_hot[pixel] {
            parts[part(event.t, window)][usize::from(event.polarity.is_on())] += 1;
        }
    }
    let quiet = is_hot.iter().filter(|is_hot| !**is_hot).count().max(1) as f64;
    let config = BootstrapConfig { resamples: RESAMPLES, seed };
    let rate = |polarity: usize| {
        // Parts of time are drawn whole: noise within one is correlated.
        bootstrap(PARTS, &config, |drawn| {
            let events: u64 = drawn.iter().map(|i| u64::from(parts[*i][polarity])).sum();
            events as f64 / (seconds * quiet)
        })
    };
    let both: Vec<f64> = parts.iter().map(|[off, on]| f64::from(off + on)).collect();
    let mean = both.iter().sum::<f64>() / PARTS as f64;
    let all = |polarity: usize| {
        counts.iter().map(|pixel| u64::from(pixel[polarity])).sum::<u64>() as f64 / seconds
    };
    let mut hot: Vec<HotPixelRate> = (0..counts.len())
        .filter(|pixel| is_hot[*pixel])
        .map(|pixel| HotPixelRate {
            x: (pixel % width) as u16,
            y: (pixel / width) as u16,
            on_hz: f64::from(counts[pixel][1]) / seconds,
            off_hz: f64::from(counts[pixel][0]) / seconds,
        })
        .collect();
    hot.sort_by(|a, b| (b.on_hz + b.off_hz).total_cmp(&(a.on_hz + a.off_hz)));
    Ok(Noise {
        on_hz: rate(1),
        off_hz: rate(0),
        all_on_hz: all(1),
        all_off_hz: all(0),
        hot,
        unrest: both.iter().copied().fold(0.0, f64::max) / mean.max(f64::MIN_POSITIVE),
        seconds,
    })
}

fn part(t: Micros, window: TimeWindow) -> usize {
    let share = (t - window.start).0 as f64 / window.length().0 as f64;
    ((share * PARTS as f64) as usize).min(PARTS - 1)
}

/// Detects hot pixels. They raise the mean that others are compared with, so the detection
/// iterates.
fn hot(counts: &[[u32; 2]]) -> Vec<bool> {
    let both: Vec<u32> = counts.iter().map(|[off, on]| off + on).collect();
    let mut is_hot = vec![false; both.len()];
    for _ in 0..ROUNDS {
        let cold = || both.iter().zip(&is_hot).filter(|(_, is_hot)| !**is_hot).map(|(n, _)| *n);
        let mean = cold().map(f64::from).sum::<f64>() / cold().count().max(1) as f64;
        // Divided by the number of pixels: `CHANCE` is that of the whole image.
        let limit = poisson_quantile(HOT * mean, CHANCE / both.len() as f64);
        let now: Vec<bool> = both.iter().map(|n| *n > limit).collect();
        if now == is_hot {
            break;
        }
        is_hot = now;
    }
    is_hot
}

/// Quantile of the Poisson distribution: the least number that is exceeded with a probability of at
/// most `chance`.
fn poisson_quantile(mean: f64, chance: f64) -> u32 {
    // From the largest down, tails add up without loss of digits.
    let highest = (mean + 12.0 * mean.sqrt() + 40.0).ceil() as u32;
    let (mut tail, mut log_factorial) = (0.0, 0.0);
    let logs: Vec<f64> = (0..=highest)
        .map(|n| {
            log_factorial += f64::from(n.max(1)).ln();
            f64::from(n) * mean.max(f64::MIN_POSITIVE).ln() - mean - log_factorial
        })
        .collect();
    for n in (0..=highest).rev() {
        tail += logs[n as usize].exp();
        if tail > chance {
            return n;
        }
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_poisson_limit_is_where_the_tail_is_small_enough() {
        // P(N > 3) of mean 1 is 0.01899, P(N > 4) is 0.00366.
        assert_eq!(poisson_quantile(1.0, 0.02), 3);
        assert_eq!(poisson_quantile(1.0, 0.018), 4);
        assert_eq!(poisson_quantile(0.0, 0.01), 0);
        // Of mean 5, 6.9e-5 above 15 and 2.3e-4 above 14; of mean 100, 2.9e-6 above 148 and 4.1e-6
        // above 147; of mean 0.05, 2.5e-7 above 3 and 2.0e-5 above 2.
        assert_eq!(poisson_quantile(5.0, 1e-4), 15);
        assert_eq!([0.05, 100.0].map(|mean| poisson_quantile(mean, 0.01 / 3_072.0)), [3, 148]);
        // 100 + 2.326 * 10 and a little skew.
        assert_eq!(poisson_quantile(100.0, 0.01), 124);
    }
}
