//! The second half of a step: from event to event through the pixels that woke.

use evpose_core::{Polarity, StageNoise};

use super::level_crossing::next_level;
use super::pixel::{Pause, PixelStep};
use super::spread::Spread;
use super::term::{Hit, Recovery};
use super::{Change, PixelArray};
use crate::chain::Chain;
use crate::tick::Tick;
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

/// A pixel taken out of the array to be worked on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Subject {
    pub(super) seen: PixelStep,
    pub(super) pause: Pause,
    /// What leaks in the whole step.
    pub(super) leak: f64,
}

/// An event about to happen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Firing {
    pub(super) t_s: f64,
    pub(super) polarity: Polarity,
    pub(super) origin: Origin,
    pub(super) memory: f64,
}

/// Pixels looked up together.
const BATCH: usize = 64;

impl PixelArray {
    /// Takes every pixel that woke through the step and appends its requests, which are served at
    /// once: pixel by pixel, those of one pixel in order of time.
    pub(crate) fn resolve(&mut self, step: Step<'_>, out: &mut Vec<Request>) {
        let awake = std::mem::take(&mut self.awake);
        let accepted = std::mem::take(&mut self.accepted);
        let detector = &*step.chain.detector.stage;
        let (is_frame, spreads) = (detector.compares_frames(), detector.spreads());
        let spread = if spreads { self.largest_count(step, &awake) } else { 0 };
        // What pixels remember lies apart: asking for many at once lets the memory answer while
        // the processor goes on asking.
        let mut batch = Vec::with_capacity(BATCH);
        let work =
            |array: &mut Self, batch: &mut Vec<(Subject, &[Hit])>, out: &mut Vec<Request>| {
                for (subject, hits) in batch.iter_mut() {
                    if is_frame {
                        array.resolve_frame(step, subject, hits, spread, out);
                    } else {
                        array.resolve_exactly(step, subject, hits, out);
                    }
                    array.put_back(step, subject);
                }
                batch.clear();
            };
        let is_straight = step.chain.goes_straight() && self.may_go_straight;
        let is_burst = step.chain.goes_in_bursts() && self.may_go_straight;
        for_each_pixel(&awake, &accepted, |pixel, hits| {
            if is_burst {
                return self.resolve_burst(step, pixel, out);
            }
            if is_straight && hits.is_empty() && self.resolve_straight(step, pixel as u32, out) {
                return;
            }
            batch.push((self.take_out(step, pixel), hits));
            if batch.len() == BATCH {
                work(self, &mut batch, out);
            }
        });
        work(self, &mut batch, out);
        self.awake = awake;
        self.accepted = accepted;
    }

    /// A pixel as it is at the start of the step, or after what it has gone through in it.
    #[inline(always)]
    pub(super) fn take_out(&self, step: Step<'_>, pixel: usize) -> Subject {
        let seeped = self.seeped.get(pixel).map_or(0.0, |&seeped| f64::from(seeped));
        let steady = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
        let mut seen = self.step_of(step, pixel);
        if seen.is_single {
            // It is off the memory from the start of the step.
            seen.from -= seeped;
        }
        Subject {
            seen,
            pause: self.pauses.get(pixel).copied().unwrap_or(Pause::NONE),
            leak: steady * (step.tick.end_s - step.tick.start_s) + seeped,
        }
    }

    #[inline(always)]
    pub(super) fn put_back(&mut self, step: Step<'_>, subject: &Subject) {
        let pixel = subject.seen.pixel as usize;
        let cell = &mut self.cells[pixel];
        cell.memory = subject.seen.memory as f32;
        cell.count = subject.seen.count;
        if let Some(pause) = self.pauses.get_mut(pixel) {
            *pause = subject.pause;
        }
        self.arm(pixel, step.tick.end_s, step.chain.steps_while_deaf);
    }

    /// Exact times, to the end of the step.
    #[inline(always)]
    fn resolve_exactly(
        &mut self,
        step: Step<'_>,
        subject: &mut Subject,
        mut hits: &[Hit],
        out: &mut Vec<Request>,
    ) {
        let mut now_s = step.tick.start_s;
        while let Some(from_s) = subject.listens_from(step, now_s) {
            let Some(firing) = subject.next_firing(step, from_s, &mut hits) else { break };
            if step.chain.steps_while_deaf && firing.t_s < subject.pause.free_s {
                subject.seen.memory = firing.memory;
            } else {
                out.push(firing.request(subject.seen.pixel));
                self.reset(step, subject, &firing);
            }
            now_s = firing.t_s;
        }
    }

    /// What an event that was served at once leaves behind.
    #[inline(always)]
    pub(super) fn reset(&mut self, step: Step<'_>, subject: &mut Subject, firing: &Firing) {
        let Firing { t_s, polarity, memory, .. } = *firing;
        subject.seen.count = subject.seen.count.wrapping_add(1);
        let recovery = &step.chain.recovery;
        let threshold = match polarity {
            Polarity::On => subject.seen.threshold_on,
            Polarity::Off => -subject.seen.threshold_off,
        };
        subject.seen.memory = memory - recovery.short_fraction * threshold;
        subject.pause = Pause::after(t_s, recovery);
        if step.chain.has_renewals {
            self.renew(step, subject, t_s, polarity);
        }
    }

    /// What holds until the next event. A new leak goes on from the level there is.
    fn renew(&mut self, step: Step<'_>, subject: &mut Subject, t_s: f64, last: Polarity) {
        let pixel = subject.seen.pixel as usize;
        self.cells[pixel].count = subject.seen.count;
        let traits = self.renewed(step.chain, pixel, Some(last));
        self.cells[pixel].take(&traits);
        let mut memory = subject.seen.memory;
        if let Some(leak) = self.leak_per_s.get_mut(pixel) {
            memory += f64::from(traits.leak_per_s() - *leak) * (t_s - self.anchor_s);
            *leak = traits.leak_per_s();
        }
        let pause = subject.pause;
        *subject = self.take_out(step, pixel);
        subject.pause = pause;
        subject.seen.memory = memory;
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
        subject: &mut Subject,
        hits: &[Hit],
        spread: u32,
        out: &mut Vec<Request>,
    ) {
        let Step { chain, tick, .. } = step;
        let (pixel, end_s) = (subject.seen.pixel, tick.end_s);
        let Recovery { deaf_s, follows_s, .. } = chain.recovery;
        let rounds = chain.detector.stage.rounds_as_published();
        let times = Spread::new(tick, spread, deaf_s, rounds);
        let is_published = spread > 0 && follows_s <= 0.0;
        let is_passed = is_published && times.passes_over();
        let is_blind = !is_published && subject.listens_from(step, tick.start_s).is_none();
        let change = chain.detector.stage.next(&subject.seen, tick.start_s, step.noise);
        let pause = subject.pause;
        if let Some(change) = change.filter(|_| !is_blind) {
            let origin = subject.origin(change.polarity);
            let first = subject.seen;
            let each = (change.memory - first.memory) / f64::from(change.count.max(1));
            let mut kept = 0;
            for k in 0..change.count {
                let t_s = if spread == 0 { change.t_s } else { times.at(k) };
                // As published, an event at the very end of the deaf time is lost.
                let is_deaf = match spread {
                    0 => t_s <= subject.pause.free_s,
                    _ => !is_passed && times.is_deaf(k, subject.pause),
                };
                if is_deaf {
                    kept += u32::from(chain.steps_while_deaf);
                    continue;
                }
                kept += 1;
                // The level of the whole burst is the detector's own, to the last bit.
                let memory = match () {
                    () if kept == change.count => change.memory,
                    () if first.is_single => first.memory_behind(change.polarity, kept),
                    () => first.memory + f64::from(kept) * each,
                };
                let firing = Firing { t_s, polarity: change.polarity, origin, memory };
                out.push(firing.request(pixel));
                self.reset(step, subject, &firing);
                if is_published {
                    times.keep(k, &mut subject.pause);
                }
            }
        }
        if is_passed {
            subject.pause = pause;
        }
        let pause = subject.pause;
        for hit in hits {
            let memory = subject.seen.to;
            let firing = Firing { t_s: end_s, polarity: hit.polarity, origin: hit.origin, memory };
            out.push(firing.request(pixel));
            self.reset(step, subject, &firing);
            // Noise leaves no deaf time behind where times are spread, as published.
            if is_published {
                subject.pause = pause;
            }
        }
    }
}

impl Subject {
    /// The time from which a pixel listens, unless it is deaf to the end of the step.
    #[inline(always)]
    pub(super) fn listens_from(&mut self, step: Step<'_>, now_s: f64) -> Option<f64> {
        let Pause { free_s, follows_until_s } = self.pause;
        let mut from_s = now_s.max(follows_until_s);
        if from_s > step.tick.end_s {
            return None;
        }
        if follows_until_s > f64::NEG_INFINITY {
            self.seen.memory = self.seen.at(follows_until_s);
            self.pause.follows_until_s = f64::NEG_INFINITY;
        }
        if !step.chain.steps_while_deaf {
            from_s = from_s.max(free_s);
        }
        (from_s <= step.tick.end_s).then_some(from_s)
    }

    /// The next event: a change or a hit, whichever comes first.
    #[inline(always)]
    pub(super) fn next_firing(
        &mut self,
        step: Step<'_>,
        from_s: f64,
        hits: &mut &[Hit],
    ) -> Option<Firing> {
        let change = if step.chain.crosses_levels {
            next_level(&self.seen, from_s)
        } else {
            step.chain.detector.stage.next(&self.seen, from_s, step.noise)
        };
        if !hits.is_empty() {
            let free_s = self.pause.free_s.max(from_s);
            *hits = &hits[hits.iter().take_while(|hit| hit.t_s < free_s).count()..];
            if let [hit, rest @ ..] = hits
                && change.is_none_or(|change| change.count == 0 || hit.t_s < change.t_s)
            {
                *hits = rest;
                let Hit { t_s, polarity, origin, .. } = *hit;
                return Some(Firing { t_s, polarity, origin, memory: self.seen.at(t_s) });
            }
        }
        let Change { t_s, polarity, count, memory } = change?;
        if count == 0 {
            self.seen.memory = memory;
            return None;
        }
        Some(Firing { t_s, polarity, origin: self.origin(polarity), memory })
    }

    /// Whether a change is one of light or of leaked charge, whichever moves more.
    #[inline]
    fn origin(&self, polarity: Polarity) -> Origin {
        let is_leak = self.leak > 0.0 && 2.0 * self.leak > self.seen.to - self.seen.from;
        if is_leak && polarity.is_on() { Origin::Leak } else { Origin::Signal }
    }
}

impl Firing {
    #[inline(always)]
    pub(super) fn request(&self, pixel: u32) -> Request {
        let Self { t_s, polarity, origin, .. } = *self;
        Request { t_s, pixel, polarity, origin }
    }
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
