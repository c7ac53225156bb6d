//! Background rates and hot pixels from a recording of a scene at rest.
//!
//! # Model
//! Events of pixels at rest come at a rate per pixel and polarity. A pixel is hot if no pixel of a
//! rate [`HOT`] times the mean of the others would have so many events, at a probability of 0.01
//! over the whole image (Poisson; Bonferroni). Hot pixels do not count for the rates.
//!
//! Intervals of 95 % are bootstrapped over twenty parts of time. [`Noise::unrest`] is the largest
//! of these parts over their mean: a lamp, or somebody who walks by, makes it much larger than one.
//! [`Noise::motion`] is where and when a tile of the image had far more events than at its own rest, which is the
//! mean of its quieter parts of time: something moved there, even if the whole image shows little of it.

use evpose_core::stats::bootstrap::{BootstrapConfig, bootstrap};
use evpose_core::stats::interval::Interval;
use evpose_core::{EventStream, Micros, TimeWindow};
use serde::Serialize;
use statrs::distribution::{DiscreteCDF as _, Poisson};

use crate::calibrate::CalibrateError;

/// Rate of a hot pixel, in rates of the others, from which it is called hot.
pub const HOT: f64 = 5.0;
/// Probability that at least one pixel of an image is called hot although it is not.
const CHANCE: f64 = 0.01;
/// Parts of equal length into which a recording is divided.
const PARTS: usize = 20;
/// Minimum length: in shorter recordings the parts of time hold too few events.
const MIN_LENGTH: Micros = Micros(100_000);
/// Columns and rows of tiles.
const TILES: [usize; 2] = [8, 6];
/// Parts of time that a tile's rest is the mean of: the quieter ones.
const QUIET_PARTS: usize = 15;
/// Events of a tile in a part of time, relative to its rest, from which something moved.
const MOVED: f64 = 3.0;
/// Largest share of one pixel in these events: above it, the pixel is in a burst and nothing moved.
const MAX_OF_A_PIXEL: f64 = 0.5;
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

/// A place and a time of much more events than before and behind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motion {
    /// Begin and end, in seconds from the begin of the window.
    pub seconds: [f64; 2],
    /// First and last column.
    pub columns: [u16; 2],
    /// First and last row.
    pub rows: [u16; 2],
    /// Events there and then, over those of the place at rest.
    pub times: f64,
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
    /// The place and time at which most clearly something moved; none if all was at rest.
    pub motion: Option<Motion>,
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
    // At least one: of a sensor that is hot all over, rates are 0, not NaN.
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
        motion: motion(events, window, &is_hot),
        unrest: both.iter().copied().fold(0.0, f64::max) / mean.max(f64::MIN_POSITIVE),
        seconds,
    })
}

/// The tile and the part of time with the largest excess over the tile's rest.
fn motion(events: &EventStream, window: TimeWindow, is_hot: &[bool]) -> Option<Motion> {
    let size = [events.sensor().width, events.sensor().height].map(usize::from);
    let tile_at = |pixel: usize| {
        let at = [pixel % size[0], pixel / size[0]];
        let [column, row] = [0, 1].map(|k| at[k] * TILES[k] / size[k]);
        row * TILES[0] + column
    };
    let place = |i: usize| {
        let event = events.get(i)?;
        let pixel = usize::from(event.y) * size[0] + usize::from(event.x);
        (!is_hot[pixel]).then(|| (tile_at(pixel), part(event.t, window), pixel))
    };
    let range = events.range(window);
    let mut counts = [[0_u32; PARTS]; TILES[0] * TILES[1]];
    range.clone().filter_map(place).for_each(|(tile, part, _)| counts[tile][part] += 1);
    // `CHANCE` is that of all tiles and parts together.
    let chance = CHANCE / (counts.len() * PARTS) as f64;
    let mut moved = Vec::new();
    for (tile, counts) in counts.iter().enumerate() {
        let mut ordered = counts.map(f64::from);
        ordered.sort_by(f64::total_cmp);
        let quiet = ordered[..QUIET_PARTS].iter().sum::<f64>() / QUIET_PARTS as f64;
        // The quieter parts lie below the mean, by up to this much.
        let rest = quiet + 2.0 * (quiet.max(1.0) / QUIET_PARTS as f64).sqrt();
        let limit = (MOVED * rest).max(f64::from(poisson_quantile(rest, chance)));
        let above = (0..PARTS).filter(|part| f64::from(counts[*part]) > limit);
        moved.extend(above.map(|part| (f64::from(counts[part]) / rest, tile, part)));
    }
    moved.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Many events of a single pixel are noise: what moves passes over several.
    let of_many_pixels = |(_, tile, part): &&(f64, usize, usize)| {
        let mut own = std::collections::BTreeMap::<usize, u32>::new();
        let here = range.clone().filter_map(place).filter(|at| (at.0, at.1) == (*tile, *part));
        here.for_each(|(.., pixel)| *own.entry(pixel).or_default() += 1);
        let most = own.values().copied().max().unwrap_or(0);
        f64::from(most) <= MAX_OF_A_PIXEL * f64::from(counts[*tile][*part])
    };
    let (times, tile, part) = *moved.iter().find(of_many_pixels)?;
    let length = window.length().as_seconds() / PARTS as f64;
    let tile = [tile % TILES[0], tile / TILES[0]];
    // Rounded up, since `tile_at` rounds down.
    let [columns, rows] =
        [0, 1].map(|k| [tile[k], tile[k] + 1].map(|at| (at * size[k]).div_ceil(TILES[k])));
    let [columns, rows] = [columns, rows].map(|[first, end]| [first as u16, end as u16 - 1]);
    let seconds = [part, part + 1].map(|part| part as f64 * length);
    Some(Motion { seconds, columns, rows, times })
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
    // Where nothing is expected, there is no distribution.
    Poisson::new(mean).map_or(0, |poisson| poisson.inverse_cdf(1.0 - chance) as u32)
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

    /// Ten seconds of noise of so many events a second over 160x120 pixels, with what `more` adds.
    fn recording(rate: usize, more: &[evpose_core::Event]) -> (EventStream, TimeWindow) {
        use evpose_core::{CounterRng, Event, EventStreamBuilder, Polarity, SensorSize};
        let mut rng = CounterRng::new(5, "noise test", rate as u64);
        let mut events = EventStreamBuilder::new(SensorSize { width: 160, height: 120 });
        let noise = (0..10 * rate).map(|_| Event {
            t: Micros(rng.below(10_000_000) as i64),
            x: rng.below(160) as u16,
            y: rng.below(120) as u16,
            polarity: Polarity::from_on(rng.chance(0.5)),
        });
        let mut all: Vec<Event> = noise.chain(more.iter().copied()).collect();
        all.sort_by_key(|event| event.t);
        all.into_iter().for_each(|event| events.push(event));
        let window = TimeWindow { start: Micros(0), end: Micros(10_000_000) };
        (events.finish().0, window)
    }

    #[test]
    fn what_moves_is_named_by_place_and_time_and_noise_and_bursts_are_not() {
        use evpose_core::{Event, Polarity};
        let event = |t: i64, x: i64, y: i64| Event {
            t: Micros(t),
            x: x as u16,
            y: y as u16,
            polarity: Polarity::On,
        };
        for rate in [200, 2_000, 20_000] {
            let (events, window) = recording(rate, &[]);
            assert_eq!(noise(&events, window, 1).unwrap().motion, None, "{rate}");
        }
        // A bar of 20 pixels walks over 12 columns, from 6.1 to 6.4 s, and is a hundredth of all events.
        let bar = |k: i64| event(6_100_000 + 1_250 * k, 44 + k / 20, 42 + k % 20);
        let bar: Vec<Event> = (0..240).map(bar).collect();
        let (events, window) = recording(2_000, &bar);
        let found = noise(&events, window, 1).unwrap();
        assert!(found.unrest < 1.5, "{}", found.unrest);
        let moved = found.motion.unwrap();
        assert_eq!((moved.seconds, moved.columns, moved.rows), ([6.0, 6.5], [40, 59], [40, 59]));
        assert!(moved.times > MOVED, "{moved:?}");
        // As many events of one pixel.
        let burst: Vec<Event> = (0..240).map(|k| event(6_100_000 + 1_250 * k, 50, 50)).collect();
        let (events, window) = recording(2_000, &burst);
        assert_eq!(noise(&events, window, 1).unwrap().motion, None);
    }
}
