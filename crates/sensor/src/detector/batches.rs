//! Eight pixels at once on the short way through a step: their crossings are vector operations.
//!
//! # Model
//! That of [`crossings`](super::crossings), operation by operation: a pixel has the same events to the
//! last bit whether it goes with others or alone.

use evpose_core::Polarity;
use evpose_cpu::vectorize;

use super::band::Band;
use super::crossings::{later, sooner};
use super::pixel::Cell;
use super::resolve::{Step, for_each_pixel};
use super::term::NoiseEvent;
use crate::{Origin, Request};

/// Pixels that go together: the `f64` in a register of AVX-512.
const LANES: usize = 8;

/// Pixels that have more events than this in a step, one in a hundred, go alone.
const MAX_EVENTS: usize = 2;

/// Pixels at the start of a step.
#[derive(Debug, Default)]
struct Lanes {
    /// Voltage at the start of the step and at its end, ln.
    before: [f32; LANES],
    after: [f32; LANES],
    memory: [f32; LANES],
    threshold_on: [f32; LANES],
    threshold_off: [f32; LANES],
    /// Steady leak, ln per second, and what else leaks in the step, ln.
    leak_per_s: [f32; LANES],
    leaked_in_step: [f32; LANES],
    /// Refractory before this time, and with a memory that follows the voltage until that one.
    free_s: [f64; LANES],
    follows_until_s: [f64; LANES],
}

/// The same pixels at its end.
#[derive(Debug, Default)]
struct Crossed {
    t_s: [[f64; LANES]; MAX_EVENTS],
    /// Event count; [`ALONE`] for pixels that have to go alone.
    count: [u64; LANES],
    /// How far the voltage went, ln: its sign is that of the events.
    change: [f64; LANES],
    /// Mask of the pixels whose events are those of a leak.
    is_leak: [u64; LANES],
    memory: [f64; LANES],
    free_s: [f64; LANES],
    follows_until_s: [f64; LANES],
    /// Levels at which the pixels wake.
    wake_on: [f32; LANES],
    wake_off: [f32; LANES],
}

const ALONE: u64 = u64::MAX;

/// Constants of a step, which all its pixels share.
#[derive(Debug, Clone, Copy)]
struct Common {
    start_s: f64,
    end_s: f64,
    per_s: f64,
    /// When no leak had been taken off the voltage.
    anchor_s: f64,
    /// Both are minus infinity where events leave no such state behind.
    refractory_s: f64,
    follows_s: f64,
    short_fraction: f64,
}

/// Pixels to be taken through the step, in order, with their noise events.
#[derive(Debug)]
struct Batch<'a> {
    pixels: [(u32, &'a [NoiseEvent]); LANES],
    len: usize,
    lanes: Lanes,
}

impl Band<'_> {
    /// Takes pixels through the step, on the short way those that may take it.
    pub(super) fn resolve_in_batches(
        &mut self,
        step: Step<'_>,
        awake: &[u32],
        noise_events: &[NoiseEvent],
        out: &mut Vec<Request>,
    ) {
        let recovery = &step.chain.plan.recovery;
        let common = Common {
            start_s: step.tick.start_s,
            end_s: step.tick.end_s,
            per_s: step.per_s,
            anchor_s: self.anchor_s,
            refractory_s: time_or_never(recovery.refractory_s),
            follows_s: time_or_never(recovery.follows_s),
            short_fraction: recovery.short_fraction,
        };
        // Where the next exposure ends a refractory period, pixels go one by one.
        let goes_alone = recovery.to_exposure > 0.0;
        let mut batch = Batch { pixels: [(0, &[]); LANES], len: 0, lanes: Lanes::default() };
        for_each_pixel(awake, noise_events, |pixel, noise_events| {
            if goes_alone {
                return self.resolve_alone(step, pixel as u32, noise_events, out);
            }
            batch.pixels[batch.len] = (pixel as u32, noise_events);
            self.take_lane(step, pixel, batch.len, &mut batch.lanes);
            batch.len += 1;
            if batch.len == LANES {
                self.resolve_batch(step, common, &mut batch, out);
            }
        });
        // The last batch may not be full: lanes beyond its length are computed and ignored.
        self.resolve_batch(step, common, &mut batch, out);
    }

    /// Takes one pixel through the step.
    fn resolve_alone(
        &mut self,
        step: Step<'_>,
        pixel: u32,
        noise_events: &[NoiseEvent],
        out: &mut Vec<Request>,
    ) {
        if !noise_events.is_empty() || !self.resolve_crossings(step, pixel, out) {
            self.resolve_any(step, pixel, noise_events, 0, out);
        }
    }

    #[inline(always)]
    fn take_lane(&self, step: Step<'_>, pixel: usize, lane: usize, lanes: &mut Lanes) {
        let Cell { memory, threshold_on, threshold_off, .. } = self.cells[pixel];
        // Values of pixels lie apart; one gather into arrays makes the arithmetic contiguous.
        lanes.before[lane] = step.before.at(pixel);
        lanes.after[lane] = step.after.at(pixel);
        lanes.memory[lane] = memory;
        lanes.threshold_on[lane] = threshold_on;
        lanes.threshold_off[lane] = threshold_off;
        if let Some(&leak_per_s) = self.leak_per_s.get(pixel) {
            lanes.leak_per_s[lane] = leak_per_s;
        }
        if let Some(&leaked_in_step) = self.leaked_in_step.get(pixel) {
            lanes.leaked_in_step[lane] = leaked_in_step;
        }
        if let Some(state) = self.refractory_states.get(pixel) {
            lanes.free_s[lane] = state.free_s;
            lanes.follows_until_s[lane] = state.follows_until_s;
        }
    }

    #[inline(always)]
    fn resolve_batch(
        &mut self,
        step: Step<'_>,
        common: Common,
        batch: &mut Batch<'_>,
        out: &mut Vec<Request>,
    ) {
        let Batch { pixels, len, lanes } = batch;
        // Two copies of the loops: without refractory states there is none to look after.
        let crossed = if self.refractory_states.is_empty() {
            vectorize(
                #[inline(always)]
                || cross::<false>(lanes, common),
            )
        } else {
            vectorize(
                #[inline(always)]
                || cross::<true>(lanes, common),
            )
        };
        for (lane, &(pixel, noise_events)) in pixels[..*len].iter().enumerate() {
            let count = crossed.count[lane];
            // From the step's start: nothing of such a lane has been written yet.
            if count == ALONE || !noise_events.is_empty() {
                self.resolve_alone(step, pixel, noise_events, out);
                continue;
            }
            let polarity = Polarity::from_on(crossed.change[lane] > 0.0);
            let origin = if crossed.is_leak[lane] != 0 { Origin::Leak } else { Origin::Signal };
            let request =
                |event: usize| Request { t_s: crossed.t_s[event][lane], pixel, polarity, origin };
            // Both are written, whatever the count: a branch would be guessed wrong.
            let start = out.len();
            out.extend_from_slice(&[request(0), request(1)]);
            out.truncate(start + count as usize);
            let index = pixel as usize;
            let cell = &mut self.cells[index];
            cell.memory = crossed.memory[lane] as f32;
            cell.count = cell.count.wrapping_add(count as u32);
            if let Some(state) = self.refractory_states.get_mut(index) {
                state.free_s = crossed.free_s[lane];
                state.follows_until_s = crossed.follows_until_s[lane];
            }
            self.wake_on[index] = crossed.wake_on[lane];
            self.wake_off[index] = crossed.wake_off[lane];
        }
        *len = 0;
    }
}

/// Takes all lanes through the step. Loops over local arrays without a branch become registers.
/// Without `RECOVERS` events leave no state behind but the memory.
#[inline(always)]
fn cross<const RECOVERS: bool>(lanes: &Lanes, common: Common) -> Crossed {
    let Common { start_s, end_s, per_s, anchor_s, refractory_s, follows_s, .. } = common;
    let Lanes { mut free_s, mut follows_until_s, .. } = *lanes;
    let (mut from, mut to, mut change) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let (mut drained, mut memory) = ([0.0; LANES], [0.0; LANES]);
    let (mut threshold_on, mut threshold_off) = ([0.0; LANES], [0.0; LANES]);
    // In double precision: times are seconds since the beginning of the run.
    for k in 0..LANES {
        let leak = f64::from(lanes.leak_per_s[k]);
        from[k] = f64::from(lanes.before[k]) + leak * (start_s - anchor_s);
        to[k] = f64::from(lanes.after[k]) + leak * (end_s - anchor_s);
        change[k] = to[k] - from[k];
        drained[k] = leak * (end_s - start_s) + f64::from(lanes.leaked_in_step[k]);
        memory[k] = f64::from(lanes.memory[k]);
        threshold_on[k] = f64::from(lanes.threshold_on[k]);
        threshold_off[k] = f64::from(lanes.threshold_off[k]);
    }
    let at = |k: usize, t_s: f64| {
        // Ends are taken, not computed: no rounding moves a level across them.
        let within = from[k] + change[k] * ((t_s - start_s) * per_s);
        let since_start = if t_s <= start_s { from[k] } else { within };
        if t_s >= end_s { to[k] } else { since_start }
    };
    let mut now_s = [start_s; LANES];
    let mut now = from;
    if RECOVERS {
        for k in 0..LANES {
            let follows_s = follows_until_s[k];
            let settled_s = later(start_s, follows_s);
            let settles = mask(follows_s > f64::NEG_INFINITY) & mask(settled_s <= end_s);
            memory[k] = select(settles, at(k, follows_s), memory[k]);
            follows_until_s[k] = select(settles, f64::NEG_INFINITY, follows_s);
            now_s[k] = later(settled_s, free_s[k]);
            now[k] = at(k, now_s[k]);
        }
    }
    let mut threshold = [0.0; LANES];
    let mut sign = [0.0; LANES];
    let mut is_open = [0u64; LANES];
    let mut is_alone = [0u64; LANES];
    let mut is_leak = [0u64; LANES];
    for k in 0..LANES {
        // On a line all events of a step have one sign.
        threshold[k] = if change[k] > 0.0 { threshold_on[k] } else { -threshold_off[k] };
        sign[k] = if change[k] > 0.0 { 1.0 } else { -1.0 };
        is_open[k] = mask(now_s[k] <= end_s);
        // Beyond a level already: an event is due at once, which is the general path's.
        let on = mask(now[k] >= memory[k] + threshold_on[k]);
        let off = mask(now[k] <= memory[k] - threshold_off[k]);
        is_alone[k] = is_open[k] & (on | off);
        // A rise of which more than half has leaked is the leak's.
        is_leak[k] =
            mask(drained[k] > 0.0) & mask(2.0 * drained[k] > change[k]) & mask(change[k] > 0.0);
    }
    let mut t_s = [[0.0; LANES]; MAX_EVENTS];
    let mut count = [0u64; LANES];
    for t_s in &mut t_s {
        for k in 0..LANES {
            let level = memory[k] + threshold[k];
            let fires = is_open[k] & mask((to[k] - level) * sign[k] >= 0.0);
            // Without a change the way is not finite: such a lane has no event here, or goes alone.
            let way = (level - from[k]) / change[k];
            // Rounding may put a crossing just outside of the step.
            t_s[k] = sooner(later(start_s + (end_s - start_s) * way, now_s[k]), end_s);
            count[k] += fires & 1;
            let mut memory_then = level - common.short_fraction * threshold[k];
            now_s[k] = t_s[k];
            if RECOVERS {
                let free_then_s = t_s[k] + refractory_s;
                let follows_then_s = t_s[k] + follows_s;
                let settled_s = later(t_s[k], follows_then_s);
                let settles = mask(follows_then_s > f64::NEG_INFINITY) & mask(settled_s <= end_s);
                memory_then = select(settles, at(k, follows_then_s), memory_then);
                let follows_then_s = select(settles, f64::NEG_INFINITY, follows_then_s);
                now_s[k] = later(settled_s, free_then_s);
                free_s[k] = select(fires, free_then_s, free_s[k]);
                follows_until_s[k] = select(fires, follows_then_s, follows_until_s[k]);
            }
            memory[k] = select(fires, memory_then, memory[k]);
            is_open[k] = fires & mask(now_s[k] <= end_s);
        }
    }
    let mut is_due = [0u64; LANES];
    for k in 0..LANES {
        // A pixel with more events than there is room for goes alone.
        is_alone[k] |= is_open[k] & mask((to[k] - (memory[k] + threshold[k])) * sign[k] >= 0.0);
        count[k] |= is_alone[k];
        if RECOVERS {
            is_due[k] = mask(free_s[k] > end_s) | mask(follows_until_s[k] > end_s);
        }
    }
    // As every pixel is armed: it wakes a little early, and in every step with a state.
    let mut wake_on = memory.map(|memory| memory as f32);
    let mut wake_off = wake_on;
    let (on, off) = (lanes.threshold_on, lanes.threshold_off);
    for k in 0..LANES {
        let early = 1e-6 * (1.0 + wake_on[k].abs());
        (wake_on[k], wake_off[k]) = (wake_on[k] + (on[k] - early), wake_off[k] - (off[k] - early));
    }
    if RECOVERS {
        for k in 0..LANES {
            wake_on[k] = select32(is_due[k] as u32, f32::NEG_INFINITY, wake_on[k]);
            wake_off[k] = select32(is_due[k] as u32, f32::INFINITY, wake_off[k]);
        }
    }
    Crossed { t_s, count, change, is_leak, memory, free_s, follows_until_s, wake_on, wake_off }
}

#[inline(always)]
fn mask(is_set: bool) -> u64 {
    u64::from(is_set).wrapping_neg()
}

/// `a` where the mask is set, `b` elsewhere.
#[inline(always)]
fn select(mask: u64, a: f64, b: f64) -> f64 {
    f64::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
}

/// The same of 32 bits.
#[inline(always)]
fn select32(mask: u32, a: f32, b: f32) -> f32 {
    f32::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
}

fn time_or_never(s: f64) -> f64 {
    if s > 0.0 { s } else { f64::NEG_INFINITY }
}
