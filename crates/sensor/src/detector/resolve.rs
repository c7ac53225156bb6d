//! The second half of a step: from event to event through the pixels that woke.

use evpose_core::{Polarity, StageNoise};
use evpose_cpu::prefetch;

use super::Change;
use super::band::{Band, Resolved};
use super::level_crossing::{next_level, next_level_through};
use super::pixel::{PixelStep, RefractoryState};
use super::spread::Spread;
use super::term::{NoiseEvent, Recovery};
use super::threshold_mismatch::MIN_THRESHOLD;
use super::varying::{ThresholdLine, next_varying};
use crate::chain::Chain;
use crate::plan::PixelPath;
use crate::tick::Tick;
use crate::{Origin, Request};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<'a> {
    pub(crate) chain: &'a Chain,
    pub(crate) tick: &'a Tick,
    /// Compared voltages at the end of the step before, and at the end of this one.
    pub(crate) before: Voltages<'a>,
    pub(crate) after: Voltages<'a>,
    /// One over the length of the step.
    pub(crate) per_s: f64,
    pub(crate) noise: StageNoise,
}

/// Voltages of the pixels from `first` on.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Voltages<'a> {
    pub(crate) first: usize,
    pub(crate) values: &'a [f32],
}

impl Voltages<'_> {
    #[inline(always)]
    pub(super) fn at(&self, pixel: usize) -> f32 {
        self.values[pixel - self.first]
    }

    #[inline(always)]
    pub(super) fn prefetch(&self, pixel: usize) {
        prefetch(self.values, pixel.wrapping_sub(self.first));
    }
}

/// The state of one pixel, copied from the array for the step.
#[derive(Debug, Clone, Copy)]
pub(super) struct PixelState {
    pub(super) pixel_step: PixelStep,
    pub(super) refractory: RefractoryState,
    /// Leakage over the whole step.
    pub(super) leak: f64,
    /// Thresholds of a formula.
    pub(super) line: ThresholdLine,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct PendingEvent {
    pub(super) t_s: f64,
    pub(super) polarity: Polarity,
    pub(super) origin: Origin,
    pub(super) memory: f64,
}

impl Band<'_> {
    /// Takes every pixel that woke since the last call through the step and appends its requests,
    /// which are served at once: pixel by pixel, those of one pixel in order of time.
    pub(crate) fn resolve(&mut self, step: Step<'_>, out: &mut Vec<Request>) {
        let Resolved { awake: first, accepted: first_accepted } = self.scanned.resolved;
        // No pixel woke since the block before, and none has noise events.
        if self.scanned.awake.len() == first && self.scanned.accepted.len() == first_accepted {
            return;
        }
        let all_awake = std::mem::take(&mut self.scanned.awake);
        let all_accepted = std::mem::take(&mut self.scanned.accepted);
        let (awake, accepted) = (&all_awake[first..], &all_accepted[first_accepted..]);
        let path = step.chain.plan.path;
        let spreads = path == PixelPath::SpreadFrames;
        // Times of a spread step depend on the largest count of all pixels.
        let spread = if spreads { self.largest_count(step, awake) } else { 0 };
        let is_burst = path == PixelPath::Bursts && self.may_take_short_paths;
        // With leaks a voltage is not what the band holds, and comparing it costs what it saves.
        let may_skip = step.chain.redraws.is_some()
            && self.leak_per_s.is_empty()
            && self.leaked_in_step.is_empty();
        if path == PixelPath::Crossings && self.may_take_short_paths {
            self.resolve_in_batches(step, awake, accepted, out);
        } else {
            for_each_run(awake, accepted, |run| match run {
                Run::Quiet(pixels) if is_burst => {
                    pixels.iter().for_each(|&pixel| self.resolve_burst(step, pixel as usize, out));
                }
                Run::Quiet(pixels) => {
                    for &pixel in pixels {
                        if !(may_skip && self.has_no_crossing(step, pixel as usize)) {
                            self.resolve_any(step, pixel, &[], spread, out);
                        }
                    }
                }
                Run::Noisy(pixel, _) if is_burst => self.resolve_burst(step, pixel as usize, out),
                Run::Noisy(pixel, noise_events) => {
                    self.resolve_any(step, pixel, noise_events, spread, out);
                }
            });
        }
        // Marked as done, not removed: both lists grow from block to block.
        self.scanned.resolved = Resolved { awake: all_awake.len(), accepted: all_accepted.len() };
        self.scanned.awake = all_awake;
        self.scanned.accepted = all_accepted;
    }

    /// The way through a step that is open to every pixel of every chain.
    #[inline(never)]
    pub(super) fn resolve_any(
        &mut self,
        step: Step<'_>,
        pixel: u32,
        noise_events: &[NoiseEvent],
        spread: u32,
        out: &mut Vec<Request>,
    ) {
        let mut pixel_state = self.load_pixel(step, pixel as usize);
        match step.chain.plan.path {
            PixelPath::Bursts | PixelPath::Frames | PixelPath::SpreadFrames => {
                self.resolve_frame(step, &mut pixel_state, noise_events, spread, out);
            }
            _ => self.resolve_exactly(step, &mut pixel_state, noise_events, out),
        }
        self.store_pixel(step, &pixel_state);
    }

    /// Whether no threshold that may be drawn puts a level into the way of a pixel's voltage.
    #[inline(always)]
    fn has_no_crossing(&self, step: Step<'_>, pixel: usize) -> bool {
        let cell = &self.cells[pixel];
        let (from, to) = (step.before.at(pixel) - cell.memory, step.after.at(pixel) - cell.memory);
        let (from, to, threshold) = if to > from {
            (from, to, cell.threshold_on)
        } else {
            (-from, -to, cell.threshold_off)
        };
        // Differences of f32 are off in their last bits: what is so close is resolved in f64.
        let early = 1e-6 * (1.0 + cell.memory.abs());
        to < self.least(threshold) - early
            || from > threshold + self.deviation + early
            || from == to
    }

    /// A pixel as it is at the start of the step, or after what it has gone through in it.
    #[inline(always)]
    pub(super) fn load_pixel(&self, step: Step<'_>, pixel: usize) -> PixelState {
        let leaked_in_step =
            self.leaked_in_step.get(pixel).map_or(0.0, |&leaked_in_step| f64::from(leaked_in_step));
        let steady = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
        let mut pixel_step = self.step_of(step, pixel);
        if let Some((term, _)) = step.chain.redraws {
            // One draw a pixel and exposure: all events of the step have the same levels.
            let noise = StageNoise::at_tick(self.terms[term].noise_key, step.tick.index);
            let deviation = f64::from(step.chain.terms[term].stage.redraw(pixel, noise));
            // A threshold must not vanish, however it is drawn: crossings would not end.
            let redrawn = |threshold: f64| (threshold + deviation).max(MIN_THRESHOLD.into());
            pixel_step.threshold_on = redrawn(pixel_step.threshold_on);
            pixel_step.threshold_off = redrawn(pixel_step.threshold_off);
        }
        if pixel_step.is_single {
            // It is off the memory from the start of the step.
            pixel_step.from -= leaked_in_step;
        }
        PixelState {
            pixel_step,
            refractory: self.refractory_states.get(pixel).copied().unwrap_or(RefractoryState::NONE),
            leak: steady * (step.tick.end_s - step.tick.start_s) + leaked_in_step,
            line: self.line_of(pixel),
        }
    }

    #[inline(always)]
    pub(super) fn store_pixel(&mut self, step: Step<'_>, pixel_state: &PixelState) {
        let pixel = pixel_state.pixel_step.pixel as usize;
        let cell = &mut self.cells[pixel];
        cell.memory = pixel_state.pixel_step.memory as f32;
        cell.count = pixel_state.pixel_step.count;
        if let Some(refractory) = self.refractory_states.get_mut(pixel) {
            *refractory = pixel_state.refractory;
        }
        self.set_wake_levels(pixel, step.tick.end_s, step.chain.plan.steps_while_refractory);
    }

    /// Exact times, to the end of the step.
    #[inline(always)]
    fn resolve_exactly(
        &mut self,
        step: Step<'_>,
        pixel_state: &mut PixelState,
        mut noise_events: &[NoiseEvent],
        out: &mut Vec<Request>,
    ) {
        let mut now_s = step.tick.start_s;
        // An event changes memory, thresholds and recovery: the next one is sought only behind it.
        while let Some(from_s) = pixel_state.ready_from(step, now_s) {
            let Some(pending) = pixel_state.next_pending(step, from_s, &mut noise_events) else {
                break;
            };
            if step.chain.plan.steps_while_refractory && pending.t_s < pixel_state.refractory.free_s
            {
                pixel_state.pixel_step.memory = pending.memory;
            } else {
                out.push(pending.request(pixel_state.pixel_step.pixel));
                self.reset(step, pixel_state, &pending);
            }
            now_s = pending.t_s;
        }
    }

    /// Resets the pixel after an event that was served at once.
    #[inline(always)]
    pub(super) fn reset(
        &mut self,
        step: Step<'_>,
        pixel_state: &mut PixelState,
        pending: &PendingEvent,
    ) {
        let PendingEvent { t_s, polarity, memory, .. } = *pending;
        // The count is the index of the pixel's draws and may wrap.
        pixel_state.pixel_step.count = pixel_state.pixel_step.count.wrapping_add(1);
        let recovery = &step.chain.plan.recovery;
        let threshold = match polarity {
            Polarity::On => pixel_state.pixel_step.threshold_on,
            Polarity::Off => -pixel_state.pixel_step.threshold_off,
        };
        pixel_state.pixel_step.memory = memory - recovery.short_fraction * threshold;
        pixel_state.refractory = RefractoryState::after(t_s, step.tick.end_s, recovery);
        if step.chain.plan.renews {
            self.renew(step, pixel_state, t_s, polarity);
        }
        if let Some(formula) = step.chain.varying() {
            self.vary_behind(formula, step, pixel_state, t_s, polarity);
        }
    }

    /// Redraws the parameters that hold until the next event. A new leak continues from the present
    /// level.
    fn renew(&mut self, step: Step<'_>, pixel_state: &mut PixelState, t_s: f64, last: Polarity) {
        let pixel = pixel_state.pixel_step.pixel as usize;
        // `renewed` and `load_pixel` read the cell, which is behind the copied state during a step.
        self.cells[pixel].count = pixel_state.pixel_step.count;
        let traits = self.renewed(step.chain, pixel, Some(last));
        self.cells[pixel].set_thresholds(&traits);
        self.vary_base(pixel);
        let mut memory = pixel_state.pixel_step.memory;
        if let Some(leak) = self.leak_per_s.get_mut(pixel) {
            // The leak acts since the anchor: without this, the new rate would apply to the past as
            // well.
            memory += f64::from(traits.leak_per_s() - *leak) * (t_s - self.anchor_s);
            *leak = traits.leak_per_s();
        }
        let refractory = pixel_state.refractory;
        *pixel_state = self.load_pixel(step, pixel);
        pixel_state.refractory = refractory;
        pixel_state.pixel_step.memory = memory;
    }

    /// The largest number of events that any pixel has in this step, at least one.
    fn largest_count(&self, step: Step<'_>, awake: &[u32]) -> u32 {
        let counts = awake.iter().map(|&pixel| {
            let pixel_step = self.step_of(step, pixel as usize);
            let change =
                step.chain.detector.stage.next(&pixel_step, pixel_step.start_s, step.noise);
            change.map_or(0, |change| change.count)
        });
        counts.max().unwrap_or(0).max(1)
    }

    /// One answer for the whole step: all at its end, or at `spread` even times.
    fn resolve_frame(
        &mut self,
        step: Step<'_>,
        pixel_state: &mut PixelState,
        noise_events: &[NoiseEvent],
        spread: u32,
        out: &mut Vec<Request>,
    ) {
        let Step { chain, tick, .. } = step;
        let (pixel, end_s) = (pixel_state.pixel_step.pixel, tick.end_s);
        let Recovery { refractory_s, follows_s, to_exposure, .. } = chain.plan.recovery;
        let rounds = chain.detector.traits.rounds_as_published;
        let times = Spread::new(tick, spread, refractory_s, rounds);
        let is_published = spread > 0 && follows_s <= 0.0 && to_exposure <= 0.0;
        let is_passed = is_published && times.ignores_refractory();
        let is_blind = !is_published && pixel_state.ready_from(step, tick.start_s).is_none();
        let change = chain.detector.stage.next(&pixel_state.pixel_step, tick.start_s, step.noise);
        let refractory = pixel_state.refractory;
        if let Some(change) = change.filter(|_| !is_blind) {
            let origin = pixel_state.origin(change.polarity);
            let first = pixel_state.pixel_step;
            // A burst's events move the memory in equal steps.
            let each = (change.memory - first.memory) / f64::from(change.count.max(1));
            let mut kept = 0;
            for k in 0..change.count {
                let t_s = if spread == 0 { change.t_s } else { times.at(k) };
                // As published, an event at the very end of the refractory period is lost.
                let is_refractory = match spread {
                    0 => t_s <= pixel_state.refractory.free_s,
                    _ => !is_passed && times.is_refractory(k, pixel_state.refractory),
                };
                if is_refractory {
                    kept += u32::from(chain.plan.steps_while_refractory);
                    continue;
                }
                kept += 1;
                // The level of the whole burst is the detector's own, to the last bit.
                let memory = match () {
                    () if kept == change.count => change.memory,
                    () if first.is_single => first.memory_behind(change.polarity, kept),
                    () => first.memory + f64::from(kept) * each,
                };
                let pending = PendingEvent { t_s, polarity: change.polarity, origin, memory };
                out.push(pending.request(pixel));
                self.reset(step, pixel_state, &pending);
                if is_published {
                    times.keep(k, &mut pixel_state.refractory);
                }
            }
        }
        // As published, such a step leaves the refractory period as it was.
        if is_passed {
            pixel_state.refractory = refractory;
        }
        let refractory = pixel_state.refractory;
        for noise_event in noise_events {
            // A frame knows the light at its end alone.
            let memory = pixel_state.pixel_step.to;
            let pending = PendingEvent {
                t_s: end_s,
                polarity: noise_event.polarity,
                origin: noise_event.origin,
                memory,
            };
            out.push(pending.request(pixel));
            self.reset(step, pixel_state, &pending);
            // Noise leaves no refractory period behind where times are spread, as published.
            if is_published {
                pixel_state.refractory = refractory;
            }
        }
    }
}

impl PixelState {
    /// The time from which a pixel detects changes, unless it is refractory to the end of the step.
    #[inline(always)]
    pub(super) fn ready_from(&mut self, step: Step<'_>, now_s: f64) -> Option<f64> {
        let RefractoryState { free_s, follows_until_s } = self.refractory;
        // The reference level follows first: its end sets the memory that the refractory pixel
        // compares.
        let mut from_s = now_s.max(follows_until_s);
        if from_s > step.tick.end_s {
            return None;
        }
        if follows_until_s > f64::NEG_INFINITY {
            self.pixel_step.memory = self.pixel_step.at(follows_until_s);
            self.refractory.follows_until_s = f64::NEG_INFINITY;
        }
        if !step.chain.plan.steps_while_refractory {
            from_s = from_s.max(free_s);
        }
        (from_s <= step.tick.end_s).then_some(from_s)
    }

    /// Begins the recovery from an event at `t_s`, the next exposure being at `exposure_s`.
    pub(super) fn recover(&mut self, t_s: f64, exposure_s: f64, recovery: &Recovery) {
        self.refractory = RefractoryState::after(t_s, exposure_s, recovery);
    }

    /// The next event: a change or a noise event, whichever comes first.
    #[inline(always)]
    pub(super) fn next_pending(
        &mut self,
        step: Step<'_>,
        from_s: f64,
        noise_events: &mut &[NoiseEvent],
    ) -> Option<PendingEvent> {
        let change = match step.chain.plan.path {
            // Called directly, so that they are inlined: the stage would answer the same.
            PixelPath::RedrawnLevels => next_level_through(&self.pixel_step, from_s),
            PixelPath::VaryingLevels => {
                next_varying(&self.pixel_step, &self.line, from_s).map(|(change, [on, off])| {
                    // What falls short of a level is a part of the threshold of that time.
                    (self.pixel_step.threshold_on, self.pixel_step.threshold_off) = (on, off);
                    change
                })
            }
            PixelPath::Crossings | PixelPath::Levels => next_level(&self.pixel_step, from_s),
            _ => step.chain.detector.stage.next(&self.pixel_step, from_s, step.noise),
        };
        if !noise_events.is_empty() {
            // Noise events in the refractory period are lost, not deferred.
            let free_s = self.refractory.free_s.max(from_s);
            *noise_events = &noise_events
                [noise_events.iter().take_while(|noise_event| noise_event.t_s < free_s).count()..];
            if let [noise_event, rest @ ..] = noise_events
                && change.is_none_or(|change| change.count == 0 || noise_event.t_s < change.t_s)
            {
                *noise_events = rest;
                let NoiseEvent { t_s, polarity, origin, .. } = *noise_event;
                return Some(PendingEvent {
                    t_s,
                    polarity,
                    origin,
                    memory: self.pixel_step.at(t_s),
                });
            }
        }
        let Change { t_s, polarity, count, memory } = change?;
        // A detector with a random walk moves its residual to the end of the step.
        if count == 0 {
            self.pixel_step.memory = memory;
            return None;
        }
        Some(PendingEvent { t_s, polarity, origin: self.origin(polarity), memory })
    }

    /// Whether a change is one of light or of leaked charge, whichever moves more.
    #[inline]
    fn origin(&self, polarity: Polarity) -> Origin {
        let is_leak =
            self.leak > 0.0 && 2.0 * self.leak > self.pixel_step.to - self.pixel_step.from;
        if is_leak && polarity.is_on() { Origin::Leak } else { Origin::Signal }
    }
}

impl PendingEvent {
    #[inline(always)]
    pub(super) fn request(&self, pixel: u32) -> Request {
        let Self { t_s, polarity, origin, .. } = *self;
        Request { t_s, pixel, polarity, origin }
    }
}

/// Pixels to be taken through a step.
#[derive(Debug, Clone, Copy)]
enum Run<'a> {
    /// Awake, without noise events.
    Quiet(&'a [u32]),
    /// With noise events, awake or not.
    Noisy(u32, &'a [NoiseEvent]),
}

/// Calls `each` for all pixels that are awake or have noise events, in order.
fn for_each_run<'a>(
    mut awake: &'a [u32],
    noise_events: &'a [NoiseEvent],
    mut each: impl FnMut(Run<'a>),
) {
    for own in noise_events.chunk_by(|a, b| a.pixel == b.pixel) {
        let pixel = own[0].pixel;
        let quiet = awake.iter().take_while(|awake| **awake < pixel).count();
        each(Run::Quiet(&awake[..quiet]));
        awake = &awake[quiet..];
        // A pixel that is both awake and noisy is visited once, with its noise.
        if let [first, rest @ ..] = awake
            && *first == pixel
        {
            awake = rest;
        }
        each(Run::Noisy(pixel, own));
    }
    each(Run::Quiet(awake));
}

/// Calls `each(pixel, noise events)` for every pixel that is awake or has noise events, in order.
pub(super) fn for_each_pixel<'a>(
    awake: &'a [u32],
    noise_events: &'a [NoiseEvent],
    mut each: impl FnMut(usize, &'a [NoiseEvent]),
) {
    for_each_run(awake, noise_events, |run| match run {
        Run::Quiet(pixels) => pixels.iter().for_each(|&pixel| each(pixel as usize, &[])),
        Run::Noisy(pixel, noise_events) => each(pixel as usize, noise_events),
    });
}
