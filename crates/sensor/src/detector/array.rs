//! All pixels of a run: their patterns, their memories, and the levels at which they wake.
//!
//! A step has two halves. The [scan](super::scan) goes through blocks while their voltages are in
//! the cache and compares every pixel with the two levels at which it may have an event; that
//! is all that most pixels cost. The [resolution](super::resolve) takes the few that woke, and
//! those with noise events, from event to event.
//!
//! # Model
//! A steady leak moves the level of a pixel by `leak_per_s (t - anchor)`: nothing is written while
//! nothing happens, and no charge is lost to rounding. The anchor moves on every second.
//!
//! If a detector [rounds as published](crate::Traits::rounds_as_published), the leak and
//! what else leaks in a step are subtracted from all reference levels at its start, and the anchor is
//! at its end.

use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, PoisonError};

use evpose_core::{SensorSize, StageNoise, seed_for};
use evpose_cpu::ThreadPool;

use super::band::Scanned;
use super::pixel::{Cell, PixelTraits, RefractoryState};
use super::term::{NoiseEvent, TermTable};
use super::threshold_mismatch::MIN_THRESHOLD;
use super::varying::Varying;
use crate::chain::Chain;
use crate::formula;
use crate::tick::Tick;

/// Seconds after which leaks are taken into the memories: long enough to cost nothing, short
/// enough for single precision to resolve the leak of a single step.
const ANCHOR_S: f64 = 1.0;

/// Draws that set pixels apart, and draws that hold until the next event, have ticks of their own.
pub(super) const PATTERN_TICK: u64 = 0;
pub(super) const RENEWAL_TICK: u64 = u64::MAX;

#[derive(Debug)]
pub(crate) struct PixelArray {
    pub(super) size: SensorSize,
    pub(super) traits: Vec<PixelTraits>,
    pub(super) cells: Vec<Cell>,
    /// Empty where pixels are never refractory.
    pub(super) refractory_states: Vec<RefractoryState>,
    /// A pixel may have an ON event where `x` is not below this, and an OFF event where it is not
    /// above that.
    pub(super) wake_on: Vec<f32>,
    pub(super) wake_off: Vec<f32>,
    /// Steady leak of every pixel, ln per second; empty if there is none.
    pub(super) leak_per_s: Vec<f32>,
    /// Leak per light of white, ln per second; empty if there is none.
    pub(super) photo_leak_per_s: Vec<f32>,
    /// Other leakage since the anchor time, and in the last step; empty if there is none.
    pub(super) leaked: Vec<f32>,
    pub(super) leaked_in_step: Vec<f32>,
    pub(super) anchor_s: f64,
    /// State of pixels with thresholds or refractory periods of a formula; empty without one.
    pub(super) varying: Varying,
    /// Key of the noise of formulas.
    formula_key: u64,
    /// Per term: the key of its noise, and its table.
    pub(super) terms: Vec<TermMemory>,
    /// Noise events of this exposure, in order of pixels.
    pub(super) noise_events: Vec<NoiseEvent>,
    /// Results of this step's scan, of every band.
    pub(super) scanned: Vec<Scanned>,
    has_dead: bool,
    /// How far thresholds of one exposure deviate at most, if they are redrawn.
    pub(super) deviation: f32,
    /// Cleared by tests that compare the short paths with the general one.
    pub(crate) may_take_short_paths: bool,
}

#[derive(Debug)]
pub(super) struct TermMemory {
    pub(super) noise_key: u64,
    pub(super) table: TermTable,
}

impl PixelArray {
    pub(crate) fn new(chain: &Chain, size: SensorSize, seed: u64) -> Self {
        let pixels = size.pixels();
        let terms = chain.terms.iter().map(|link| TermMemory {
            noise_key: seed_for(seed, link.name, 0),
            table: TermTable::default(),
        });
        let mut array = Self {
            size,
            traits: Vec::with_capacity(pixels),
            cells: Vec::new(),
            refractory_states: Vec::new(),
            // No pixel wakes before the first step has armed it.
            wake_on: vec![f32::INFINITY; pixels],
            wake_off: vec![f32::NEG_INFINITY; pixels],
            leak_per_s: Vec::new(),
            photo_leak_per_s: Vec::new(),
            leaked: Vec::new(),
            leaked_in_step: Vec::new(),
            anchor_s: 0.0,
            varying: Varying::default(),
            formula_key: seed_for(seed, formula::SPEC.name, 0),
            terms: terms.collect(),
            noise_events: Vec::new(),
            scanned: Vec::new(),
            has_dead: false,
            deviation: chain.redraws.map_or(0.0, |(_, limit)| limit),
            may_take_short_paths: true,
        };
        array.make_pattern(chain);
        // In this order: renewal reads patterns and event counts.
        array.cells = array.traits.iter().map(Cell::new).collect();
        array.renew_all(chain);
        if chain.plan.has_refractory_states {
            array.refractory_states = vec![RefractoryState::NONE; pixels];
        }
        array
    }

    /// Goes on with other parameters: patterns are made anew, memories stay.
    pub(crate) fn retune(&mut self, chain: &Chain, before: &mut [f32], now_s: f64) {
        self.move_anchor(before, now_s);
        // The leak until now, taken into the memories above, was at the rates before.
        self.make_pattern(chain);
        self.renew_all(chain);
        let pixels = self.size.pixels();
        let mut whole = self.whole();
        for pixel in 0..pixels {
            whole.set_wake_levels(pixel, now_s, chain.plan.steps_while_refractory);
        }
    }

    fn make_pattern(&mut self, chain: &Chain) {
        let [threshold_on, threshold_off] = chain.detector.stage.thresholds();
        let nominal = PixelTraits::alike(threshold_on, threshold_off);
        self.traits.clear();
        self.traits.resize(self.size.pixels(), nominal);
        for (link, memory) in chain.terms.iter().zip(&self.terms) {
            let noise = StageNoise::at_tick(memory.noise_key, PATTERN_TICK);
            for (pixel, traits) in self.traits.iter_mut().enumerate() {
                link.stage.pattern(pixel, traits, noise);
            }
        }
        if let Some(formula) = chain.formula.as_ref().filter(|formula| formula.is_pattern()) {
            let noise = StageNoise::at_tick(self.formula_key, PATTERN_TICK);
            for (traits, [on, off]) in self.traits.iter_mut().zip(formula.pattern(self.size, noise))
            {
                traits.threshold_on = (traits.threshold_on * on).max(MIN_THRESHOLD);
                traits.threshold_off = (traits.threshold_off * off).max(MIN_THRESHOLD);
            }
        }
        self.has_dead = self.traits.iter().any(|traits| traits.is_dead);
        // Tables come last: they depend on the thresholds and dead pixels of all patterns.
        for (link, memory) in chain.terms.iter().zip(&mut self.terms) {
            let noise = StageNoise::at_tick(memory.noise_key, PATTERN_TICK);
            memory.table = link.stage.table(&self.traits, noise);
        }
    }

    /// Redraws the parameters that hold until the next event, for every pixel, and the planes
    /// derived from them.
    fn renew_all(&mut self, chain: &Chain) {
        let leaks = self.traits.iter().any(|t| t.leak_hz > 0.0);
        // Taken out, since `renewed` borrows the array.
        let mut leak_per_s = std::mem::take(&mut self.leak_per_s);
        leak_per_s.clear();
        let pixels = self.size.pixels();
        let mut whole = self.whole();
        for pixel in 0..pixels {
            let traits = whole.renewed(chain, pixel, None);
            whole.cells[pixel].set_thresholds(&traits);
            if leaks {
                leak_per_s.push(traits.leak_per_s());
            }
        }
        self.leak_per_s = leak_per_s;
        self.varying = chain.varying().map_or_else(Varying::default, |formula| {
            let known = std::mem::take(&mut self.varying);
            known.of(formula, self.size, self.formula_key, &self.cells)
        });
        self.photo_leak_per_s.clear();
        if self.traits.iter().any(|t| t.photo_leak_hz > 0.0) {
            let rates = self.traits.iter().map(|t| t.photo_leak_hz * t.threshold_on);
            self.photo_leak_per_s.extend(rates);
        }
        // Such leaks change with light or noise: they are added up pixel by pixel.
        let leaks_unevenly = !self.photo_leak_per_s.is_empty()
            || chain.terms.iter().any(|link| link.traits.adds_leak);
        let uneven = if leaks_unevenly { pixels } else { 0 };
        self.leaked.resize(uneven, 0.0);
        self.leaked_in_step.resize(uneven, 0.0);
    }

    /// Takes what has leaked so far into the memories, if it is time.
    pub(crate) fn keep_anchor(&mut self, before: &mut [f32], now_s: f64) {
        if now_s - self.anchor_s >= ANCHOR_S {
            // What has leaked so far leaked at the old rates.
            self.move_anchor(before, now_s);
        }
    }

    fn move_anchor(&mut self, before: &mut [f32], now_s: f64) {
        let age_s = now_s - self.anchor_s;
        // Without leaks no level shifts with time: the anchor alone moves.
        if self.leak_per_s.is_empty() && self.leaked.is_empty() {
            self.anchor_s = now_s;
            return;
        }
        for (pixel, cell) in self.cells.iter_mut().enumerate() {
            let steady = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
            // In double precision: roundings would add up from anchor to anchor.
            let mut shift = steady * age_s;
            if let Some(leaked) = self.leaked.get_mut(pixel) {
                shift += f64::from(*leaked);
                // This voltage holds the leak as well: memory and voltage move together.
                before[pixel] -= *leaked;
                *leaked = 0.0;
            }
            cell.memory = (f64::from(cell.memory) - shift) as f32;
            self.wake_on[pixel] = (f64::from(self.wake_on[pixel]) - shift) as f32;
            self.wake_off[pixel] = (f64::from(self.wake_off[pixel]) - shift) as f32;
        }
        self.anchor_s = now_s;
    }

    pub(crate) fn draw_noise_events(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        thread_pool: &ThreadPool,
    ) {
        self.noise_events.clear();
        // The first exposure has no length in which noise could come.
        if tick.dt_s() <= 0.0 {
            return;
        }
        let terms = chain.terms.iter().zip(&self.terms).enumerate();
        let parts: Vec<_> = terms
            .flat_map(|(index, term)| {
                let parts = 0..term.0.stage.noise_parts();
                parts.map(move |part| (index as u8, part, term))
            })
            .collect();
        let size = self.size;
        let draw = |k: usize, out: &mut Vec<NoiseEvent>| {
            let (term, part, (link, memory)) = parts[k];
            let first = out.len();
            // The key knows term and tick, not the thread: any division draws the same events.
            let noise = StageNoise::at_tick(memory.noise_key, tick.index);
            link.stage.noise_events(part, tick, size, &memory.table, noise, out);
            out[first..].iter_mut().for_each(|noise_event| noise_event.term = term);
        };
        if thread_pool.threads() == 1 || parts.len() < 2 {
            (0..parts.len()).for_each(|k| draw(k, &mut self.noise_events));
        } else {
            // Threads count down one number: parts of unequal length spread by themselves.
            let left = AtomicUsize::new(parts.len());
            let drawn: Vec<Mutex<Vec<NoiseEvent>>> =
                parts.iter().map(|_| Mutex::default()).collect();
            thread_pool.run(&|_| {
                let next = || left.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1)).ok();
                while let Some(left) = next() {
                    // No other thread has this part.
                    let k = left - 1;
                    draw(k, &mut drawn[k].lock().unwrap_or_else(PoisonError::into_inner));
                }
            });
            // In the order of parts, whichever thread drew them.
            for drawn in drawn {
                let drawn = drawn.into_inner().unwrap_or_else(PoisonError::into_inner);
                self.noise_events.extend_from_slice(&drawn);
            }
        }
        // Hits come in long runs in order, of which a stable sort makes use.
        self.noise_events.sort_by(|a, b| a.pixel.cmp(&b.pixel).then(a.t_s.total_cmp(&b.t_s)));
    }

    /// Whether background requests of this pixel are lost as well.
    pub(crate) fn is_dead(&self, pixel: u32) -> bool {
        self.has_dead && self.traits[pixel as usize].is_dead
    }
}
