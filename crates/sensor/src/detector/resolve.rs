//! The second half of a step: from event to event through the pixels that woke.

use evpose_core::{Polarity, StageNoise};

use super::pixel::{Pause, PixelStep};
use super::term::Hit;
use super::{Change, PixelArray, Reset};
use crate::model::Chain;
use crate::stage::Tick;
use crate::{Origin, Request};

/// What a step is about.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<'a> {
    pub(crate) chain: &'a Chain,
    pub(crate) tick: &'a Tick,
    /// What pixels compared at the end of the step before, and at the end of this one.
    pub(crate) before: &'a [f32],
    pub(crate) after: &'a [f32],
    /// One over the length of the step.
    pub(crate) per_s: f64,
    /// Noise of the detector.
    pub(crate) noise: StageNoise,
}

/// Pixels looked up together.
const BATCH: usize = 64;

/// An event about to happen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Firing {
    pub(super) t_s: f64,
    pub(super) polarity: Polarity,
    pub(super) origin: Origin,
    pub(super) memory: f64,
}

impl PixelArray {
    /// Takes every pixel that woke through the step and appends its requests, which are served at
    /// once: pixel by pixel, those of one pixel in order of time.
    pub(crate) fn resolve(&mut self, step: Step<'_>, out: &mut Vec<Request>) {
        let awake = std::mem::take(&mut self.awake);
        let accepted = std::mem::take(&mut self.accepted);
        let detector = &*step.chain.detector.stage;
        if detector.compares_frames() {
            let spread = if detector.spreads() { self.largest_count(step, &awake) } else { 0 };
            for_each_pixel(&awake, &accepted, |pixel, hits| {
                self.resolve_frame(step, pixel, hits, spread, out);
            });
        } else {
            // What pixels remember lies apart: asking for many at once lets the memory answer
            // while the processor goes on asking.
            let mut batch = Vec::with_capacity(BATCH);
            for_each_pixel(&awake, &accepted, |pixel, hits| {
                batch.push((self.step_of(step, pixel), hits));
                if batch.len() == BATCH {
                    batch
                        .drain(..)
                        .for_each(|(seen, hits)| self.resolve_pixel(step, seen, hits, out));
                }
            });
            batch.drain(..).for_each(|(seen, hits)| self.resolve_pixel(step, seen, hits, out));
        }
        self.awake = awake;
        self.accepted = accepted;
    }

    /// Exact times, to the end of the step.
    fn resolve_pixel(
        &mut self,
        step: Step<'_>,
        mut seen: PixelStep,
        mut hits: &[Hit],
        out: &mut Vec<Request>,
    ) {
        let pixel = seen.pixel as usize;
        let mut now_s = step.tick.start_s;
        while let Some(from_s) = self.listens_from(step, pixel, &mut seen, now_s) {
            let Some(firing) = self.next_firing(step, &mut seen, from_s, &mut hits) else { break };
            if step.chain.steps_while_deaf && firing.t_s < self.pauses[pixel].free_s {
                self.step_silently(pixel, &mut seen, firing.memory);
            } else {
                out.push(request(pixel, &firing));
                self.reset(step, &mut seen, &firing);
            }
            now_s = firing.t_s;
        }
        self.arm(pixel, step.tick.end_s, step.chain.steps_while_deaf);
    }

    /// The time from which a pixel listens, unless it is deaf to the end of the step.
    #[inline]
    pub(super) fn listens_from(
        &mut self,
        step: Step<'_>,
        pixel: usize,
        seen: &mut PixelStep,
        now_s: f64,
    ) -> Option<f64> {
        let mut from_s = now_s;
        if let Some(pause) = self.pauses.get_mut(pixel) {
            if pause.follows_until_s > f64::NEG_INFINITY {
                from_s = from_s.max(pause.follows_until_s);
                if from_s > step.tick.end_s {
                    return None;
                }
                let cell = &mut self.cells[pixel];
                cell.memory = seen.at(pause.follows_until_s) as f32;
                pause.follows_until_s = f64::NEG_INFINITY;
                seen.memory = f64::from(cell.memory);
            }
            if !step.chain.steps_while_deaf {
                from_s = from_s.max(pause.free_s);
            }
        }
        (from_s <= step.tick.end_s).then_some(from_s)
    }

    /// The next event of a pixel: a change or a hit, whichever comes first.
    #[inline]
    pub(super) fn next_firing(
        &mut self,
        step: Step<'_>,
        seen: &mut PixelStep,
        from_s: f64,
        hits: &mut &[Hit],
    ) -> Option<Firing> {
        if !hits.is_empty() {
            let pause = self.pauses.get(seen.pixel as usize).unwrap_or(&Pause::NONE);
            let free_s = pause.free_s.max(from_s);
            *hits = &hits[hits.iter().take_while(|hit| hit.t_s < free_s).count()..];
        }
        let change = step.chain.detector.stage.next(seen, from_s, step.noise);
        if let [hit, rest @ ..] = hits
            && change.is_none_or(|change| change.count == 0 || hit.t_s < change.t_s)
        {
            *hits = rest;
            return Some(Firing {
                t_s: hit.t_s,
                polarity: hit.polarity,
                origin: hit.origin,
                memory: seen.at(hit.t_s),
            });
        }
        let Change { t_s, polarity, count, memory } = change?;
        if count == 0 {
            self.cells[seen.pixel as usize].memory = memory as f32;
            return None;
        }
        Some(Firing { t_s, polarity, origin: self.origin(seen, polarity), memory })
    }

    /// Whether a change is one of light or of leaked charge, whichever moves more.
    #[inline]
    fn origin(&self, seen: &PixelStep, polarity: Polarity) -> Origin {
        let pixel = seen.pixel as usize;
        let steady = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
        let seeped = self.seeped.get(pixel).map_or(0.0, |&s| f64::from(s));
        let leak = steady * (seen.end_s - seen.start_s) + seeped;
        if polarity.is_on() && leak > 0.0 && 2.0 * leak > seen.to - seen.from {
            Origin::Leak
        } else {
            Origin::Signal
        }
    }

    fn step_silently(&mut self, pixel: usize, seen: &mut PixelStep, memory: f64) {
        self.cells[pixel].memory = memory as f32;
        seen.memory = f64::from(self.cells[pixel].memory);
    }

    /// What an event that was served at once leaves behind.
    #[inline]
    pub(super) fn reset(&mut self, step: Step<'_>, seen: &mut PixelStep, firing: &Firing) {
        let Firing { t_s, polarity, memory, .. } = *firing;
        let pixel = seen.pixel as usize;
        let cell = &mut self.cells[pixel];
        cell.count += 1;
        cell.memory = memory as f32;
        // Within a step the level keeps its precision: rounding at every event would add up.
        seen.memory = memory;
        if !step.chain.resetting.is_empty() {
            let threshold = match polarity {
                Polarity::On => seen.threshold_on,
                Polarity::Off => seen.threshold_off,
            };
            let mut reset = Reset {
                t_s,
                polarity,
                threshold,
                memory,
                free_s: self.pauses[pixel].free_s,
                follows_until_s: f64::NEG_INFINITY,
            };
            for &term in &step.chain.resetting {
                step.chain.terms[term].stage.reset(&mut reset);
            }
            cell.memory = reset.memory as f32;
            seen.memory = reset.memory;
            let Reset { free_s, follows_until_s, .. } = reset;
            self.pauses[pixel] = Pause { free_s, follows_until_s };
        }
        seen.count = cell.count;
        if step.chain.has_renewals {
            self.renew(step, seen, t_s, polarity);
        }
    }

    /// What holds until the next event. A new leak goes on from the level there is.
    fn renew(&mut self, step: Step<'_>, seen: &mut PixelStep, t_s: f64, last: Polarity) {
        let pixel = seen.pixel as usize;
        let traits = self.renewed(step.chain, pixel, Some(last));
        let cell = &mut self.cells[pixel];
        cell.take(&traits);
        if let Some(leak) = self.leak_per_s.get_mut(pixel) {
            let shift = f64::from(traits.leak_per_s() - *leak) * (t_s - self.anchor_s);
            cell.memory = (f64::from(cell.memory) + shift) as f32;
            *leak = traits.leak_per_s();
        }
        *seen = self.step_of(step, pixel);
    }

    /// The largest number of events that any pixel has in this step, at least one.
    fn largest_count(&self, step: Step<'_>, awake: &[u32]) -> u32 {
        let counts = awake.iter().map(|&pixel| {
            let seen = self.step_of(step, pixel as usize);
            let change = step.chain.detector.stage.next(&seen, seen.start_s, step.noise);
            change.map_or(0, |change| change.count)
        });
        counts.max().unwrap_or(0).max(1)
    }

    /// One answer for the whole step: all at its end, or at `spread` even times.
    fn resolve_frame(
        &mut self,
        step: Step<'_>,
        pixel: usize,
        hits: &[Hit],
        spread: u32,
        out: &mut Vec<Request>,
    ) {
        let Step { chain, tick, .. } = step;
        let mut seen = self.step_of(step, pixel);
        let end_s = tick.end_s;
        let is_blind = self.listens_from(step, pixel, &mut seen, tick.start_s).is_none();
        let change = chain.detector.stage.next(&seen, tick.start_s, step.noise);
        if let Some(change) = change.filter(|_| !is_blind) {
            let origin = self.origin(&seen, change.polarity);
            let threshold = change.memory - seen.memory;
            let each = threshold / f64::from(change.count.max(1));
            let (first, mut kept) = (seen.memory, 0);
            for k in 0..change.count {
                let t_s = match spread {
                    0 => change.t_s,
                    n => tick.start_s + f64::from(k + 1) / f64::from(n) * tick.dt_s(),
                };
                // As published, an event at the very end of the deaf time is lost.
                if self.pauses.get(pixel).is_some_and(|pause| t_s <= pause.free_s) {
                    if chain.steps_while_deaf {
                        kept += 1;
                    }
                    continue;
                }
                kept += 1;
                // The level of the whole burst is the detector's own, to the last bit.
                let whole = kept == change.count;
                let memory = if whole { change.memory } else { first + f64::from(kept) * each };
                let firing = Firing { t_s, polarity: change.polarity, origin, memory };
                out.push(request(pixel, &firing));
                self.reset(step, &mut seen, &firing);
            }
        }
        for hit in hits {
            let Hit { polarity, origin, .. } = *hit;
            let firing = Firing { t_s: end_s, polarity, origin, memory: seen.to };
            out.push(request(pixel, &firing));
            self.reset(step, &mut seen, &firing);
        }
        self.arm(pixel, end_s, chain.steps_while_deaf);
    }
}

pub(super) fn request(pixel: usize, firing: &Firing) -> Request {
    let Firing { t_s, polarity, origin, .. } = *firing;
    Request { t_s, pixel: pixel as u32, polarity, origin }
}

/// Calls `each(pixel, hits)` for every pixel that is awake or hit, in order.
pub(super) fn for_each_pixel<'h>(
    mut awake: &[u32],
    mut hits: &'h [Hit],
    mut each: impl FnMut(usize, &'h [Hit]),
) {
    loop {
        if hits.is_empty() {
            awake.iter().for_each(|&pixel| each(pixel as usize, &[]));
            return;
        }
        let pixel = match (awake, hits) {
            (_, []) => return,
            ([], [hit, ..]) => hit.pixel,
            ([pixel, rest @ ..], [hit, ..]) => {
                if *pixel <= hit.pixel {
                    awake = rest;
                }
                hit.pixel.min(*pixel)
            }
        };
        let struck = hits.iter().take_while(|hit| hit.pixel == pixel).count();
        let (now, later) = hits.split_at(struck);
        hits = later;
        each(pixel as usize, now);
    }
}
