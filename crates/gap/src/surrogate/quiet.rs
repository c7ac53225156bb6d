//! Events where nothing happens: in blocks of pixels and slices of time without more than the
//! background.
//!
//! # Method
//! The image is cut in blocks of 8 x 8 pixels, time in slices of 50 ms. The lower quarter of the
//! counts of all blocks and slices says what the background is; a block is quiet while its counts
//! are not clearly above, and those around it in image and time are not either: what moves has a
//! surrounding in which little happens. Surrogates redraw the time of every event inside its stretch of quiet
//! slices: Poisson events are then what they were, regular ones are not.

use std::collections::HashMap;

use evpose_core::CounterRng;

use super::train::Train;

/// Side of a block.
const BLOCK: usize = 8;
/// Length of a slice.
const SLICE_US: i64 = 50_000;
/// More events of a pixel per second are no background.
const MOST_RATE_HZ: f64 = 15.0;
/// Least part of pixels and time that must be quiet.
const LEAST_PART: f64 = 0.05;

/// Events of neighbours up to this apart are at one time.
const SYNCHRONY_US: i64 = 10_000;
/// More than this many times the pairs of chance are made by light.
const MOST_SYNCHRONY: f64 = 1.4;
/// Pairs of chance from which on synchrony is known.
const LEAST_PAIRS: f64 = 10.0;

/// An event: time, and polarity.
type Quiet = (i64, bool);

/// The events of one pixel in one quiet stretch, in order of time.
#[derive(Debug, Clone)]
struct Stretch {
    pixel: u32,
    from_us: i64,
    to_us: i64,
    events: Vec<Quiet>,
}

/// All events of quiet blocks and slices.
#[derive(Debug, Clone)]
pub(super) struct Background {
    stretches: Vec<Stretch>,
    pixel_s: f64,
    width: u32,
}

impl Background {
    /// None if nothing is quiet.
    pub(super) fn of(train: &Train) -> Option<Self> {
        let (start, end) = train.span_us();
        let slices = ((end - start) / SLICE_US) as usize;
        let (width, height) = (train.width(), usize::from(train.size.height));
        let across = width.div_ceil(BLOCK);
        let blocks = across * height.div_ceil(BLOCK);
        if slices == 0 {
            return None;
        }
        let block = |pixel: u32| {
            let pixel = pixel as usize;
            pixel / width / BLOCK * across + pixel % width / BLOCK
        };
        let slice = |t_us: i64| ((t_us - start) / SLICE_US) as usize;
        let mut counts = vec![0u32; blocks * slices];
        for mark in &train.marks {
            if let Some(count) =
                counts[block(mark.pixel) * slices..][..slices].get_mut(slice(mark.t_us))
            {
                *count += 1;
            }
        }
        let mut sorted = counts.clone();
        let (_, quarter, _) = sorted.select_nth_unstable(blocks * slices / 4);
        let quarter = f64::from(*quarter);
        let limit = quarter + 4.0 * quarter.sqrt() + 2.0;
        let is_busy =
            |block: usize, slice: usize| f64::from(counts[block * slices + slice]) > limit;
        let down = blocks / across;
        let mut disturbed = vec![false; blocks * slices];
        for (b, k) in (0..blocks).flat_map(|b| (0..slices).map(move |k| (b, k))) {
            if is_busy(b, k) {
                let (x, y) = (b % across, b / across);
                for row in y.saturating_sub(1)..(y + 2).min(down) {
                    for column in x.saturating_sub(1)..(x + 2).min(across) {
                        let at = (row * across + column) * slices;
                        disturbed[at + k.saturating_sub(1)..at + (k + 2).min(slices)].fill(true);
                    }
                }
            }
        }
        let is_quiet = |block: usize, slice: usize| !disturbed[block * slices + slice];
        let mut pixel_s = 0.0;
        // The first slice of the stretch that each slice belongs to, and the one behind it.
        let mut bounds: Vec<Option<(usize, usize)>> = vec![None; blocks * slices];
        for b in 0..blocks {
            let (w, h) =
                (BLOCK.min(width - b % across * BLOCK), BLOCK.min(height - b / across * BLOCK));
            let mut from = 0;
            while from < slices {
                let to = (from..slices).find(|k| !is_quiet(b, *k)).unwrap_or(slices);
                bounds[b * slices + from..b * slices + to].fill(Some((from, to)));
                pixel_s += (w * h) as f64 * (to - from) as f64 * SLICE_US as f64 * 1e-6;
                from = to + 1;
            }
        }
        let mut last: Vec<Option<usize>> = vec![None; width * height];
        let mut stretches: Vec<Stretch> = Vec::new();
        for mark in &train.marks {
            let at = slice(mark.t_us);
            let Some((from, to)) =
                (at < slices).then(|| bounds[block(mark.pixel) * slices + at]).flatten()
            else {
                continue;
            };
            let from_us = start + from as i64 * SLICE_US;
            let event = (mark.t_us, mark.is_on);
            let known = &mut last[mark.pixel as usize];
            match known.filter(|i| stretches[*i].from_us == from_us) {
                Some(i) => stretches[i].events.push(event),
                None => {
                    *known = Some(stretches.len());
                    let to_us = start + to as i64 * SLICE_US;
                    stretches.push(Stretch {
                        pixel: mark.pixel,
                        from_us,
                        to_us,
                        events: vec![event],
                    });
                }
            }
        }
        let found = Self { stretches, pixel_s, width: width as u32 };
        let (on_hz, off_hz) = found.rates_hz();
        let part = pixel_s / ((width * height) as f64 * train.seconds());
        let is_at_rest = part >= LEAST_PART
            && on_hz + off_hz <= MOST_RATE_HZ
            && found.synchrony().is_none_or(|synchrony| synchrony <= MOST_SYNCHRONY);
        is_at_rest.then_some(found)
    }

    /// The same with every event at a time of chance inside its stretch.
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

    /// ON and OFF events of a pixel per second.
    pub(super) fn rates_hz(&self) -> (f64, f64) {
        let count = |is_on: bool| {
            let events = self.stretches.iter().flat_map(|stretch| &stretch.events);
            events.filter(|(_, on)| *on == is_on).count() as f64
        };
        (count(true) / self.pixel_s, count(false) / self.pixel_s)
    }

    /// Number of events.
    pub(super) fn len(&self) -> usize {
        self.stretches.iter().map(|stretch| stretch.events.len()).sum()
    }

    /// The shortest interval between events of a polarity over what chance makes of it, the mean
    /// of all pixels and stretches: one for Poisson events, more for regular ones, less for
    /// bursts.
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
        (n >= 10).then(|| sum / n as f64)
    }

    /// Events of one polarity in pixels side by side at nearly one time, over what chance makes of
    /// it: one for a background, more for what light does. None where chance makes few.
    pub(super) fn synchrony(&self) -> Option<f64> {
        let place = |stretch: &Stretch| (stretch.pixel, stretch.from_us);
        let known: HashMap<(u32, i64), usize> =
            self.stretches.iter().enumerate().map(|(i, stretch)| (place(stretch), i)).collect();
        let (mut found, mut expected) = (0usize, 0.0);
        for stretch in &self.stretches {
            for step in [1, self.width] {
                // Stretches of a block have the same bounds; those of other blocks do not count.
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
                    expected += (mine.len() * theirs.len()) as f64 * (reach / length).min(1.0);
                    for t in mine {
                        let from = theirs.partition_point(|other| *other < t - SYNCHRONY_US);
                        let to = theirs.partition_point(|other| *other < t + SYNCHRONY_US);
                        found += to - from;
                    }
                }
            }
        }
        (expected >= LEAST_PAIRS).then(|| found as f64 / expected)
    }

    /// Part of the neighbouring events of a pixel that are of opposite polarity.
    pub(super) fn alternation(&self) -> Option<f64> {
        let pairs = || self.stretches.iter().flat_map(|stretch| stretch.events.windows(2));
        let n = pairs().count();
        let changes = pairs().filter(|pair| pair[0].1 != pair[1].1).count();
        (n >= 20).then(|| changes as f64 / n as f64)
    }

    /// The median interval between an event and the next of opposite polarity, in microseconds.
    pub(super) fn return_us(&self) -> Option<f64> {
        let pairs = self.stretches.iter().flat_map(|stretch| stretch.events.windows(2));
        let intervals =
            pairs.filter(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0 - pair[0].0);
        median(intervals.map(|us| us as f64).collect())
    }

    /// Rate and jitter of regular ON events: over pixels the median of the rates (the mean where
    /// most have few intervals), and the standard
    /// deviation of intervals as a part of their pixel's mean.
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
        let known: Vec<f64> = intervals.iter().filter(|i| i.len() >= 3).map(|i| mean(i)).collect();
        // Intervals of slow pixels are cut off: then the mean rate is all there is.
        let any = intervals.iter().filter(|intervals| !intervals.is_empty()).count();
        let rate_hz = if 2 * known.len() > any { 1e6 / median(known)? } else { self.rates_hz().0 };
        // Squares over means squared, with one degree of freedom less for each pixel.
        let (mut squares, mut freedom) = (0.0, 0.0);
        for intervals in intervals.iter().filter(|intervals| intervals.len() >= 3) {
            let mean = mean(intervals);
            squares += intervals.iter().map(|i| (i / mean - 1.0).powi(2)).sum::<f64>();
            freedom += (intervals.len() - 1) as f64;
        }
        Some((rate_hz, (freedom >= 30.0).then(|| (squares / freedom).sqrt())))
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
