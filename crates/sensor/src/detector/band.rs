//! A band of pixels: consecutive ones, which one thread takes through a step.
//!
//! Pixels of the whole sensor are one band, or several where [no pixel sees
//! another](crate::plan::Division::Bands). A pixel has the index that it has in the whole sensor,
//! which also keys its draws: events do not depend on how the sensor is divided.

use std::ops::{Index, IndexMut, Range};

use evpose_core::{Polarity, StageNoise};
use evpose_cpu::prefetch;

use super::array::{PixelArray, RENEWAL_TICK, TermMemory};
use super::pixel::{Cell, PixelStep, PixelTraits, RefractoryState};
use super::resolve::Step;
use super::term::NoiseEvent;
use super::threshold_mismatch::MIN_THRESHOLD;
use super::varying::VaryingBand;
use crate::chain::Chain;
use crate::changes::take_front;

/// Values of consecutive pixels, by the index of the pixel in the whole sensor. Empty where the array
/// has no such values.
#[derive(Debug)]
pub(super) struct Span<'a, T> {
    pub(super) first: usize,
    pub(super) values: &'a mut [T],
}

impl<'a, T> Span<'a, T> {
    /// The first of `rest`, which go on behind them.
    pub(super) fn split_off(rest: &mut &'a mut [T], pixels: &Range<usize>) -> Self {
        let len = pixels.len().min(rest.len());
        Self { first: pixels.start, values: take_front(rest, len) }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    #[inline(always)]
    pub(super) fn get(&self, pixel: usize) -> Option<&T> {
        self.values.get(pixel - self.first)
    }

    #[inline(always)]
    pub(super) fn get_mut(&mut self, pixel: usize) -> Option<&mut T> {
        self.values.get_mut(pixel - self.first)
    }

    /// Values of some pixels, if there are any values.
    pub(super) fn of(&self, pixels: &Range<usize>) -> Option<&[T]> {
        self.values.get(pixels.start - self.first..pixels.end - self.first)
    }

    /// The same values, mutable; empty if there are none.
    pub(super) fn of_mut(&mut self, pixels: &Range<usize>) -> &mut [T] {
        let range = pixels.start - self.first..pixels.end - self.first;
        self.values.get_mut(range).unwrap_or_default()
    }

    #[inline(always)]
    pub(super) fn prefetch(&self, pixel: usize) {
        prefetch(self.values, pixel - self.first);
    }
}

impl<T> Index<usize> for Span<'_, T> {
    type Output = T;

    #[inline(always)]
    fn index(&self, pixel: usize) -> &T {
        &self.values[pixel - self.first]
    }
}

impl<T> IndexMut<usize> for Span<'_, T> {
    #[inline(always)]
    fn index_mut(&mut self, pixel: usize) -> &mut T {
        &mut self.values[pixel - self.first]
    }
}

#[derive(Debug, Default)]
pub(super) struct Scanned {
    pub(super) awake: Vec<u32>,
    /// Noise events that take place.
    pub(super) accepted: Vec<NoiseEvent>,
    pub(super) next_noise_event: usize,
    /// How many of both have been taken through the step.
    pub(super) resolved: Resolved,
}

/// Counts of pixels and of noise events of a step that are resolved.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Resolved {
    pub(super) awake: usize,
    pub(super) accepted: usize,
}

impl Scanned {
    pub(super) fn clear(&mut self) {
        self.awake.clear();
        self.accepted.clear();
        self.next_noise_event = 0;
        self.resolved = Resolved::default();
    }
}

/// Consecutive pixels of a [`PixelArray`], with the meanings of its fields.
#[derive(Debug)]
pub(crate) struct Band<'a> {
    pub(super) traits: &'a [PixelTraits],
    pub(super) cells: Span<'a, Cell>,
    pub(super) refractory_states: Span<'a, RefractoryState>,
    pub(super) wake_on: Span<'a, f32>,
    pub(super) wake_off: Span<'a, f32>,
    pub(super) leak_per_s: Span<'a, f32>,
    pub(super) photo_leak_per_s: &'a [f32],
    pub(super) leaked: Span<'a, f32>,
    pub(super) leaked_in_step: Span<'a, f32>,
    pub(super) anchor_s: f64,
    pub(super) varying: VaryingBand<'a>,
    pub(super) terms: &'a [TermMemory],
    pub(super) noise_events: &'a [NoiseEvent],
    pub(super) scanned: &'a mut Scanned,
    pub(super) deviation: f32,
    pub(super) may_take_short_paths: bool,
}

impl PixelArray {
    pub(crate) fn whole(&mut self) -> Band<'_> {
        let all = 0..self.size.pixels();
        // One range has one band.
        self.bands(&[all]).swap_remove(0)
    }

    /// Bands of pixels that follow each other from the first pixel to the last.
    pub(crate) fn bands(&mut self, ranges: &[Range<usize>]) -> Vec<Band<'_>> {
        // Buffers are kept from step to step, so that nothing is allocated again.
        if self.scanned.len() < ranges.len() {
            self.scanned.resize_with(ranges.len(), Scanned::default);
        }
        let (cells, refractory_states) = (&mut &mut *self.cells, &mut &mut *self.refractory_states);
        let (wake_on, wake_off) = (&mut &mut *self.wake_on, &mut &mut *self.wake_off);
        let leak_per_s = &mut &mut *self.leak_per_s;
        let (leaked, leaked_in_step) = (&mut &mut *self.leaked, &mut &mut *self.leaked_in_step);
        let (mut varying, neighbours_s, patterns) = self.varying.parts();
        let varying = &mut varying;
        let noise_events = &mut &*self.noise_events;
        let bands = ranges.iter().zip(&mut self.scanned).map(|(pixels, scanned)| {
            // Noise events are in order of pixels, so that a band has a slice of them.
            let until = |event: &NoiseEvent| (event.pixel as usize) < pixels.end;
            let own = noise_events.partition_point(until);
            let (own, behind) = noise_events.split_at(own);
            *noise_events = behind;
            Band {
                traits: &self.traits,
                cells: Span::split_off(cells, pixels),
                refractory_states: Span::split_off(refractory_states, pixels),
                wake_on: Span::split_off(wake_on, pixels),
                wake_off: Span::split_off(wake_off, pixels),
                leak_per_s: Span::split_off(leak_per_s, pixels),
                photo_leak_per_s: &self.photo_leak_per_s,
                leaked: Span::split_off(leaked, pixels),
                leaked_in_step: Span::split_off(leaked_in_step, pixels),
                anchor_s: self.anchor_s,
                varying: VaryingBand {
                    cells: Span::split_off(varying, pixels),
                    neighbours_s,
                    patterns,
                },
                terms: &self.terms,
                noise_events: own,
                scanned,
                deviation: self.deviation,
                may_take_short_paths: self.may_take_short_paths,
            }
        });
        bands.collect()
    }
}

impl Band<'_> {
    /// Pixels to visit, from index `first` of the list on.
    pub(crate) fn awake_from(&self, first: usize) -> &[u32] {
        &self.scanned.awake[first..]
    }

    /// Number of pixels to visit, so far in this step.
    pub(crate) fn awake_count(&self) -> usize {
        self.scanned.awake.len()
    }

    /// The traits of a pixel until its next event.
    pub(super) fn renewed(
        &self,
        chain: &Chain,
        pixel: usize,
        last: Option<Polarity>,
    ) -> PixelTraits {
        // From the pattern, not from what held before: deviations must not add up from event to
        // event.
        let mut traits = self.traits[pixel];
        let count = self.cells[pixel].count;
        for (link, memory) in chain.terms.iter().zip(self.terms) {
            if link.traits.renews {
                let noise = StageNoise::at_tick(memory.noise_key, RENEWAL_TICK);
                link.stage.renew(pixel, count, last, &mut traits, noise);
            }
        }
        traits
    }

    /// Sets the levels at which a pixel wakes after `end_s`.
    #[inline(always)]
    pub(super) fn set_wake_levels(
        &mut self,
        pixel: usize,
        end_s: f64,
        steps_while_refractory: bool,
    ) {
        let cell = &self.cells[pixel];
        // A pixel with a due time in a later step is visited in every step until then.
        let is_due = self.refractory_states.get(pixel).is_some_and(|refractory| {
            let is_refractory = refractory.free_s > end_s && !steps_while_refractory;
            is_refractory
                || refractory.free_s == f64::INFINITY
                || refractory.follows_until_s > end_s
        });
        let (on, off) = if is_due {
            (f32::NEG_INFINITY, f32::INFINITY)
        } else {
            // Rounding must not let a pixel sleep over its level: it wakes a little early.
            let early = 1e-6 * (1.0 + cell.memory.abs());
            let at = |threshold: f32| self.least(threshold) - early;
            (cell.memory + at(cell.threshold_on), cell.memory - at(cell.threshold_off))
        };
        self.wake_on[pixel] = on;
        self.wake_off[pixel] = off;
    }

    #[inline(always)]
    pub(super) fn least(&self, threshold: f32) -> f32 {
        if self.deviation > 0.0 {
            (threshold - self.deviation).max(MIN_THRESHOLD)
        } else {
            threshold
        }
    }

    #[inline(always)]
    pub(super) fn step_of(&self, step: Step<'_>, pixel: usize) -> PixelStep {
        let Step { tick, per_s, .. } = step;
        let cell = &self.cells[pixel];
        let leak = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
        PixelStep {
            start_s: tick.start_s,
            end_s: tick.end_s,
            // From the anchor on, not step by step: rounding errors do not add up.
            from: f64::from(step.before.at(pixel)) + leak * (tick.start_s - self.anchor_s),
            to: f64::from(step.after.at(pixel)) + leak * (tick.end_s - self.anchor_s),
            memory: f64::from(cell.memory),
            threshold_on: f64::from(cell.threshold_on),
            threshold_off: f64::from(cell.threshold_off),
            pixel: pixel as u32,
            count: cell.count,
            per_s,
            is_single: step.chain.plan.is_single,
        }
    }

    /// How far a pixel is from its memory at the end of a step; dead ones have none.
    pub(crate) fn residual(&self, step: Step<'_>, pixel: usize) -> f32 {
        let pixel_step = self.step_of(step, pixel);
        (pixel_step.to - pixel_step.memory) as f32
    }
}
