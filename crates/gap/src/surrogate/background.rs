//! Background events: statistics of all events in quiet stretches.
//!
//! Surrogates redraw the time of every event uniformly within its stretch. Poisson events are
//! distributed as before; regular ones are not.

use std::collections::HashMap;

use evpose_core::CounterRng;
use evpose_core::stats::quantile::median_high;

use super::stretches::{Stretch, quiet_stretches};
use super::train::Train;

/// Maximum rate of a pixel in the background, Hz.
const MAX_RATE_HZ: f64 = 15.0;
/// Minimum fraction of pixels and time that is quiet.
const MIN_QUIET: f64 = 0.05;

/// Largest interval between simultaneous events of neighbours.
const SYNCHRONY_US: i64 = 10_000;
/// Maximum synchrony, relative to Poisson events, of a background; light makes more.
const MAX_SYNCHRONY: f64 = 1.4;
/// Minimum expected pairs for an estimate of the synchrony.
const MIN_PAIRS: f64 = 10.0;
/// Minimum stretches, pairs, and degrees of freedom for estimates of regularity, alternation and
/// jitter.
const MIN_STRETCHES: usize = 10;
const MIN_SUCCESSIVE: usize = 20;
const MIN_FREEDOM: f64 = 30.0;
/// Minimum intervals of a pixel for a rate of its own.
const MIN_INTERVALS: usize = 3;

/// All events of quiet stretches.
#[derive(Debug, Clone)]
pub(super) struct Background {
    stretches: Vec<Stretch>,
    /// Time of all quiet pixels together.
    pub(super) pixel_s: f64,
    width: u32,
}

impl Background {
    /// The background of a recording; none if too little is quiet, or if quiet events are too many
    /// or too synchronous.
    pub(super) fn estimate(train: &Train) -> Option<Self> {
        let (stretches, pixel_s) = quiet_stretches(train)?;
        let background = Self { stretches, pixel_s, width: train.width() as u32 };
        let (on_hz, off_hz) = background.rates_hz();
        let quiet = pixel_s / (train.size.pixels() as f64 * train.seconds());
        // Three signs of light that moves: little rest, many events, or neighbours that fire
        // together.
        let is_at_rest = quiet >= MIN_QUIET
            && on_hz + off_hz <= MAX_RATE_HZ
            && background.synchrony().is_none_or(|synchrony| synchrony <= MAX_SYNCHRONY);
        is_at_rest.then_some(background)
    }

    /// Surrogate with every event at a random time within its stretch.
    pub(super) fn redrawn(&self, rng: &mut CounterRng) -> Self {
        let mut redrawn = self.clone();
        for stretch in &mut redrawn.stretches {
            let length = (stretch.to_us - stretch.from_us) as usize;
            for event in &mut stretch.events {
                event.0 = stretch.from_us + rng.below(length) as i64;
            }
            stretch.events.sort_unstable();
        }
        redrawn
    }

    pub(super) fn rates_hz(&self) -> (f64, f64) {
        let count = |is_on: bool| {
            let events = self.stretches.iter().flat_map(|stretch| &stretch.events);
            events.filter(|(_, on)| *on == is_on).count() as f64
        };
        (count(true) / self.pixel_s, count(false) / self.pixel_s)
    }

    pub(super) fn len(&self) -> usize {
        self.stretches.iter().map(|stretch| stretch.events.len()).sum()
    }

    /// Mean over pixels and stretches of the shortest interval between events of a polarity,
    /// relative to its mean for Poisson events: above one for regular events, below one for bursts.
    pub(super) fn regularity(&self, is_on: bool) -> Option<f64> {
        let (mut sum, mut n) = (0.0, 0usize);
        for stretch in &self.stretches {
            let times: Vec<i64> =
                stretch.events.iter().filter(|(_, on)| *on == is_on).map(|(t, _)| *t).collect();
            let shortest = times.windows(2).map(|pair| pair[1] - pair[0]).min();
            if let Some(shortest) = shortest {
                // n points in a length have a shortest interval of length / (n^2 - 1) on average.
                let count = times.len() as f64;
                let expected = (stretch.to_us - stretch.from_us) as f64 / (count * count - 1.0);
                sum += shortest as f64 / expected;
                n += 1;
            }
        }
        (n >= MIN_STRETCHES).then(|| sum / n as f64)
    }

    /// Number of simultaneous events of one polarity in adjacent pixels, relative to Poisson
    /// events: one for a background, more for events caused by light. None if few are expected.
    pub(super) fn synchrony(&self) -> Option<f64> {
        let place = |stretch: &Stretch| (stretch.pixel, stretch.from_us);
        let known: HashMap<(u32, i64), usize> =
            self.stretches.iter().enumerate().map(|(i, stretch)| (place(stretch), i)).collect();
        let (mut pairs, mut expected) = (0usize, 0.0);
        for stretch in &self.stretches {
            // To the right and below: each pair once.
            for step in [1, self.width] {
                // Stretches of one block have the same bounds; pairs across blocks are left out.
                let Some(i) = known.get(&(stretch.pixel + step, stretch.from_us)) else { continue };
                let beside = &self.stretches[*i];
                if beside.to_us != stretch.to_us {
                    continue;
                }
                for is_on in [false, true] {
                    let times = |stretch: &Stretch| -> Vec<i64> {
                        let own = stretch.events.iter().filter(|(_, on)| *on == is_on);
                        own.map(|(t, _)| *t).collect()
                    };
                    let (mine, theirs) = (times(stretch), times(beside));
                    let length = (stretch.to_us - stretch.from_us) as f64;
                    let reach = 2.0 * SYNCHRONY_US as f64;
                    // So often do independent events meet.
                    expected += (mine.len() * theirs.len()) as f64 * (reach / length).min(1.0);
                    for t in mine {
                        let from = theirs.partition_point(|other| *other < t - SYNCHRONY_US);
                        let to = theirs.partition_point(|other| *other < t + SYNCHRONY_US);
                        pairs += to - from;
                    }
                }
            }
        }
        (expected >= MIN_PAIRS).then(|| pairs as f64 / expected)
    }

    /// Fraction of successive events of a pixel that are of opposite polarity.
    pub(super) fn alternation(&self) -> Option<f64> {
        let pairs = || self.stretches.iter().flat_map(|stretch| stretch.events.windows(2));
        let n = pairs().count();
        let changes = pairs().filter(|pair| pair[0].1 != pair[1].1).count();
        (n >= MIN_SUCCESSIVE).then(|| changes as f64 / n as f64)
    }

    /// Median interval between an event and the next one of opposite polarity, microseconds.
    pub(super) fn return_us(&self) -> Option<f64> {
        let pairs = self.stretches.iter().flat_map(|stretch| stretch.events.windows(2));
        let intervals =
            pairs.filter(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0 - pair[0].0);
        median_high(&mut intervals.map(|us| us as f64).collect::<Vec<_>>())
    }

    /// Rate and jitter of regular ON events: the median over pixels of their rates (the mean rate
    /// if most pixels have few intervals), and the standard deviation of intervals relative to
    /// their pixel's mean.
    pub(super) fn leak(&self) -> Option<(f64, Option<f64>)> {
        let pixels = self.stretches.iter().map(|s| s.pixel as usize + 1).max()?;
        let mut intervals: Vec<Vec<f64>> = vec![Vec::new(); pixels];
        for stretch in &self.stretches {
            let times: Vec<i64> =
                stretch.events.iter().filter(|(_, on)| *on).map(|(t, _)| *t).collect();
            intervals[stretch.pixel as usize]
                .extend(times.windows(2).map(|pair| (pair[1] - pair[0]) as f64));
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let mut known: Vec<f64> =
            intervals.iter().filter(|i| i.len() >= MIN_INTERVALS).map(|i| mean(i)).collect();
        // Stretches truncate the intervals of slow pixels: then only the mean rate is unbiased.
        let any = intervals.iter().filter(|intervals| !intervals.is_empty()).count();
        let rate_hz =
            if 2 * known.len() > any { 1e6 / median_high(&mut known)? } else { self.rates_hz().0 };
        // Pooled relative variance, with one degree of freedom less for each pixel.
        let (mut squares, mut freedom) = (0.0, 0.0);
        for intervals in intervals.iter().filter(|intervals| intervals.len() >= MIN_INTERVALS) {
            let mean = mean(intervals);
            squares += intervals.iter().map(|i| (i / mean - 1.0).powi(2)).sum::<f64>();
            freedom += (intervals.len() - 1) as f64;
        }
        Some((rate_hz, (freedom >= MIN_FREEDOM).then(|| (squares / freedom).sqrt())))
    }
}
