//! Sums of a voxel grid of many events, from which an image costs little more than its pixels.
//!
//! # Model
//! Bins cut the window into segments, each from one bin to the next. Within a segment, an event's
//! share of either bin is linear in its time: of a pixel, `Σ p` and `Σ p·t` of the segment's events
//! say all, with `p` the polarities. They are differences of sums of all events up to either end
//! of the segment. Sums up to the latest event are kept with every push, and copied now and then;
//! those up to an inner border are made for an image, from a copy up to an event nearby.
//!
//! Both sums are one integer, `Σ p·(2^40 + t)`, with times from an origin. It may wrap around:
//! differences are exact, and a division separates counts from times. An image is rounded once.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::ops::Range;

use evpose_core::Micros;
use evpose_cpu::vectorize;

use crate::sliding::{Placed, Sliding};

/// Pixels drawn at a time: what a segment passes on stays in the nearest cache.
const TOGETHER: usize = 512;
/// Weight of a polarity beside times in microseconds.
const COUNT: i64 = 1 << 40;
/// Times are so near to the origin that they weigh less than a polarity.
const FURTHEST_US: i64 = COUNT / 2;
/// Events of a segment, all at one pixel, that do not reach the sign of a sum.
const MAX_EVENTS: usize = 1 << 20;
/// Rounds to integers what is added to it, and has them in its lowest bits.
const ROUNDING: f64 = (3_u64 << 51) as f64;

/// A sum of each pixel's events up to one of the stream.
#[derive(Debug, Clone, Default)]
struct Prefix {
    /// Number of the first event of the stream that is not in it.
    at: usize,
    sums: Vec<i64>,
}

/// The sums of a stream's events.
#[derive(Debug, Clone)]
pub(super) struct PrefixSums {
    /// Times count from here.
    origin: Micros,
    /// Number in the stream of the first event of the window.
    first: usize,
    /// Up to the latest event.
    all: Prefix,
    /// Copies of `all`, ascending: one for a quarter as many events as there are pixels.
    copies: VecDeque<Prefix>,
    /// Memory of copies that no window needs any longer.
    unused: Vec<Vec<i64>>,
    /// Up to the borders of the last image.
    borders: RefCell<Vec<Prefix>>,
}

impl PrefixSums {
    /// No events.
    pub(super) fn new(pixels: usize) -> Self {
        Self {
            origin: Micros(0),
            first: 0,
            all: Prefix { at: 0, sums: vec![0; pixels] },
            copies: VecDeque::new(),
            unused: Vec::new(),
            borders: RefCell::default(),
        }
    }

    /// Takes those of the events of a window that are new.
    pub(super) fn follow(&mut self, window: &Sliding) {
        let Some(((first, _), (last, _))) = window.get(0).zip(window.last()) else { return };
        let is_empty = self.all.at <= self.first;
        if is_empty || last.0.saturating_sub(self.origin.0) > FURTHEST_US {
            self.restart(first);
        }
        let (end, apart) = (self.first + window.len(), (self.all.sums.len() / 4).max(1));
        while self.all.at < end {
            let copied_at = self.copies.back().map_or(self.first, |copy| copy.at);
            let upto = end.min((copied_at + apart).max(self.all.at));
            self.all.go_to(upto, window, self.first, self.origin);
            // Copies are as far apart as a quarter of the sums is large: copying then costs as much
            // as adding.
            if upto >= copied_at + apart {
                let mut sums = self.unused.pop().unwrap_or_default();
                sums.clone_from(&self.all.sums);
                self.copies.push_back(Prefix { at: upto, sums });
            }
        }
    }

    /// Notes that the first `count` events of the window have been removed from it.
    pub(super) fn remove_first(&mut self, count: usize) {
        self.first += count;
        while let Some(old) = self.copies.pop_front_if(|copy| copy.at < self.first) {
            self.unused.push(old.sums);
        }
    }

    /// Forgets every event, and keeps the memory.
    pub(super) fn reset(&mut self) {
        self.first = 0;
        self.restart(Micros(0));
    }

    fn restart(&mut self, origin: Micros) {
        self.origin = origin;
        self.all.at = self.first;
        self.all.sums.fill(0);
        self.unused.extend(self.copies.drain(..).map(|copy| copy.sums));
        self.borders.get_mut().iter_mut().for_each(|border| border.sums.clear());
    }

    /// Writes the planes of `bins`, at least two, from all events of a window that it follows;
    /// returns whether it did. It does not if sums might overflow.
    pub(super) fn render(&self, window: &Sliding, bins: usize, out: &mut [f32]) -> bool {
        let Some(((first, _), (last, _))) = window.get(0).zip(window.last()) else { return false };
        let (segments, span_us) = ((bins - 1) as i64, (last.0 - first.0).max(1));
        let begin = |k: i64| {
            let at = window.partition_point(|t| (t.0 - first.0) * segments < k * span_us);
            self.first + at
        };
        let mut ends: Vec<usize> = (0..segments).map(begin).collect();
        ends.push(self.all.at);
        let most = ends.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        // Half of a segment is as far as an event is from its middle.
        let reach_us = span_us / (2 * segments) + 2;
        if most > MAX_EVENTS || most as i64 > COUNT / 4 / reach_us {
            return false;
        }
        // The sums of the image before: from these, few events lead to the new borders.
        let mut borders = self.borders.borrow_mut();
        borders.resize_with(bins - 1, Prefix::default);
        for (border, &at) in borders.iter_mut().zip(&ends) {
            self.start_near(at, border);
            border.go_to(at, window, self.first, self.origin);
        }
        let per_us = segments as f64 / span_us as f64;
        let pairs = borders.iter().zip(borders.iter().skip(1).chain([&self.all]));
        let drawn = pairs.enumerate().map(|(k, (before, after))| {
            let middle_us = span_us * (2 * k as i64 + 1) / (2 * segments);
            Segment {
                before: &before.sums,
                after: &after.sums,
                weight: COUNT + (first.0 - self.origin.0) + middle_us,
                share: middle_us as f64 * per_us - k as f64,
            }
        });
        draw(&drawn.collect::<Vec<_>>(), per_us, out);
        true
    }

    /// Makes `border` the nearest of the sums that are there, itself included, unless that saves
    /// less than a copy costs.
    fn start_near(&self, at: usize, border: &mut Prefix) {
        let others = self.copies.iter().chain([&self.all]);
        let nearest = others.min_by_key(|other| other.at.abs_diff(at)).unwrap_or(&self.all);
        // Events before the window are gone: from there, nothing can be added.
        let can_stay = !border.sums.is_empty() && border.at >= self.first;
        let copy_cost = self.all.sums.len() / 8;
        if !can_stay || border.at.abs_diff(at) > nearest.at.abs_diff(at) + copy_cost {
            border.at = nearest.at;
            border.sums.clone_from(&nearest.sums);
        }
    }
}

impl Prefix {
    /// Adds or takes away the events up to number `at` of the stream.
    fn go_to(&mut self, at: usize, window: &Sliding, first: usize, origin: Micros) {
        let range = |from: usize, to: usize| from - first..to - first;
        if at >= self.at {
            self.add(window, range(self.at, at), origin, 1);
        } else {
            self.add(window, range(at, self.at), origin, -1);
        }
        self.at = at;
    }

    /// Adds events `times` over.
    fn add(&mut self, window: &Sliding, range: Range<usize>, origin: Micros, times: i64) {
        let sums = self.sums.as_mut_slice();
        let pixels = sums.len();
        window.range(range).for_each(|(t, index): Placed| {
            let index = index as usize;
            // No branch: polarities are not predicted.
            let is_on = usize::from(index >= pixels);
            let sign = times * (2 * is_on as i64 - 1);
            let sum = &mut sums[index - is_on * pixels];
            *sum = sum.wrapping_add(sign.wrapping_mul(COUNT + (t.0 - origin.0)));
        });
    }
}

/// A segment of the window.
#[derive(Debug, Clone, Copy)]
struct Segment<'a> {
    /// Sums up to its beginning and up to its end.
    before: &'a [i64],
    after: &'a [i64],
    /// Weight of an event in the middle of the segment.
    weight: i64,
    /// Its share of the next bin.
    share: f64,
}

/// Writes the planes of bins from the segments between them; `per_us` is in bins per microsecond.
fn draw(segments: &[Segment<'_>], per_us: f64, out: &mut [f32]) {
    let pixels = segments[0].before.len();
    vectorize(
        #[inline(always)]
        move || {
            for start in (0..pixels).step_by(TOGETHER) {
                let length = TOGETHER.min(pixels - start);
                let mut passed_on = [0.0; TOGETHER];
                for (k, &Segment { before, after, weight, share }) in segments.iter().enumerate() {
                    let (before, after) = (&before[start..][..length], &after[start..][..length]);
                    let out = &mut out[k * pixels + start..][..length];
                    let per_weight = 1.0 / weight as f64;
                    for (((out, before), after), passed_on) in
                        out.iter_mut().zip(before).zip(after).zip(&mut passed_on)
                    {
                        let sum = after.wrapping_sub(*before);
                        // A quarter of a weight at most is of times: rounding leaves the count.
                        let rounded = sum as f64 * per_weight + ROUNDING;
                        let count = rounded - ROUNDING;
                        let counted = rounded.to_bits().wrapping_sub(ROUNDING.to_bits()) as i64;
                        let from_middle_us = sum.wrapping_sub(counted.wrapping_mul(weight)) as f64;
                        // The part that falls to the next bin.
                        let next = per_us * from_middle_us + share * count;
                        *out = (count - next + *passed_on) as f32;
                        *passed_on = next;
                    }
                }
                let last = &mut out[segments.len() * pixels + start..][..length];
                for (out, &passed_on) in last.iter_mut().zip(&passed_on) {
                    *out = passed_on as f32;
                }
            }
        },
    );
}
