//! All pixels of a run: their patterns, their memories, and the levels at which they wake.
//!
//! A step has two halves. The [scan](super::scan) goes through blocks while their voltages are in
//! the cache and compares every pixel with the two levels at which it has something to say; that
//! is all that most pixels cost. The [resolution](super::resolve) takes the few that woke, and
//! those that noise strikes, from event to event.
//!
//! # Model
//! A steady leak moves the level of a pixel by `leak_per_s (t - anchor)`: nothing is written while
//! nothing happens, and no charge is lost to rounding. The anchor moves on every second.
//!
//! If a detector [rounds as published](super::ChangeDetector::rounds_as_published), the leak and
//! the seepage of a step are subtracted from all reference levels at its start, and the anchor is
//! at its end.

use evpose_core::{SensorSize, StageNoise, seed_for};

use super::pixel::{Cell, PixelStep, PixelTraits, RefractoryState};
use super::queue::Queue;
use super::resolve::Step;
use super::term::{NoiseEvent, TermTable};
use super::threshold_mismatch::MIN_THRESHOLD;
use crate::chain::Chain;
use crate::tick::Tick;

/// Seconds after which leaks are taken into the memories: long enough to cost nothing, short
/// enough for single precision to resolve the leak of a single step.
const ANCHOR_S: f64 = 1.0;

/// Draws that set pixels apart, and draws that hold until the next event, have ticks of their own.
const PATTERN_TICK: u64 = 0;
pub(super) const RENEWAL_TICK: u64 = u64::MAX;

/// The pixels of one run.
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
    pub(super) seeped: Vec<f32>,
    pub(super) anchor_s: f64,
    /// Per term: the key of its noise, and its table.
    pub(super) terms: Vec<TermMemory>,
    /// Hits of this exposure, in order of pixels.
    pub(super) noise_events: Vec<NoiseEvent>,
    /// Index of the next noise event of this step's scan.
    pub(super) next_noise_event: usize,
    /// Results of this step's scan: pixels to visit, and noise events that take place.
    pub(super) awake: Vec<u32>,
    pub(super) accepted: Vec<NoiseEvent>,
    /// How many of them have been taken through the step.
    pub(super) resolved: Resolved,
    pub(super) queue: Queue,
    has_dead: bool,
    /// How far thresholds of one exposure deviate at most, if they are redrawn.
    pub(super) deviation: f32,
    /// Cleared by tests that look at the long way.
    pub(crate) may_go_straight: bool,
}

/// Counts of pixels and of noise events of a step that are resolved.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Resolved {
    pub(super) awake: usize,
    pub(super) accepted: usize,
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
            wake_on: vec![f32::INFINITY; pixels],
            wake_off: vec![f32::NEG_INFINITY; pixels],
            leak_per_s: Vec::new(),
            photo_leak_per_s: Vec::new(),
            leaked: Vec::new(),
            seeped: Vec::new(),
            anchor_s: 0.0,
            terms: terms.collect(),
            noise_events: Vec::new(),
            next_noise_event: 0,
            awake: Vec::new(),
            accepted: Vec::new(),
            resolved: Resolved::default(),
            queue: Queue::default(),
            has_dead: false,
            deviation: chain.redraws.map_or(0.0, |(_, most)| most),
            may_go_straight: true,
        };
        array.make_pattern(chain);
        array.cells = array.traits.iter().map(Cell::new).collect();
        array.renew_all(chain);
        if chain.has_refractory_states() {
            array.refractory_states = vec![RefractoryState::NONE; pixels];
        }
        array
    }

    /// Goes on with other parameters: patterns are made anew, memories stay.
    pub(crate) fn retune(&mut self, chain: &Chain, before: &mut [f32], now_s: f64) {
        self.move_anchor(before, now_s);
        self.make_pattern(chain);
        self.renew_all(chain);
        for pixel in 0..self.cells.len() {
            self.arm(pixel, now_s, chain.steps_while_refractory);
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
        self.has_dead = self.traits.iter().any(|traits| traits.is_dead);
        for (link, memory) in chain.terms.iter().zip(&mut self.terms) {
            let noise = StageNoise::at_tick(memory.noise_key, PATTERN_TICK);
            memory.table = link.stage.table(&self.traits, noise);
        }
    }

    /// Redraws the parameters that hold until the next event, for every pixel, and the planes
    /// derived from them.
    fn renew_all(&mut self, chain: &Chain) {
        let leaks = self.traits.iter().any(|t| t.leak_hz > 0.0);
        self.leak_per_s.clear();
        for pixel in 0..self.cells.len() {
            let traits = self.renewed(chain, pixel, None);
            self.cells[pixel].take(&traits);
            if leaks {
                self.leak_per_s.push(traits.leak_per_s());
            }
        }
        let pixels = self.size.pixels();
        self.photo_leak_per_s.clear();
        if self.traits.iter().any(|t| t.photo_leak_hz > 0.0) {
            let rates = self.traits.iter().map(|t| t.photo_leak_hz * t.threshold_on);
            self.photo_leak_per_s.extend(rates);
        }
        let seeps =
            !self.photo_leak_per_s.is_empty() || chain.terms.iter().any(|link| link.stage.seeps());
        let seeping = if seeps { pixels } else { 0 };
        self.leaked.resize(seeping, 0.0);
        self.seeped.resize(seeping, 0.0);
    }

    /// The traits of a pixel until its next event.
    pub(super) fn renewed(
        &self,
        chain: &Chain,
        pixel: usize,
        last: Option<evpose_core::Polarity>,
    ) -> PixelTraits {
        let mut traits = self.traits[pixel];
        let count = self.cells[pixel].count;
        for (link, memory) in chain.terms.iter().zip(&self.terms) {
            if link.stage.renews() {
                let noise = StageNoise::at_tick(memory.noise_key, RENEWAL_TICK);
                link.stage.renew(pixel, count, last, &mut traits, noise);
            }
        }
        traits
    }

    /// Memories at the first exposure, from the voltages of some pixels.
    pub(super) fn settle(&mut self, chain: &Chain, tick: &Tick, first: usize, voltage: &[f32]) {
        self.anchor_s = tick.start_s;
        let cold = chain.detector.stage.starts_cold().then(|| chain.dark_v());
        let rests = chain.detector.stage.sees_light();
        for (offset, &v) in voltage.iter().enumerate() {
            let pixel = first + offset;
            let phase: f32 = if rests { 0.0 } else { self.first_phase(chain, pixel) };
            let start = if rests { 0.0 } else { cold.unwrap_or(v) };
            let cell = &mut self.cells[pixel];
            cell.memory = start - phase * self.traits[pixel].threshold_on;
            self.arm(pixel, tick.start_s, chain.steps_while_refractory);
        }
    }

    fn first_phase(&self, chain: &Chain, pixel: usize) -> f32 {
        let terms = chain.terms.iter().zip(&self.terms);
        let phases = terms.map(|(link, memory)| {
            let noise = StageNoise::at_tick(memory.noise_key, PATTERN_TICK);
            link.stage.first_phase(pixel, noise)
        });
        phases.sum::<f32>().fract()
    }

    /// Sets the levels at which a pixel wakes after `end_s`.
    #[inline(always)]
    pub(super) fn arm(&mut self, pixel: usize, end_s: f64, steps_while_refractory: bool) {
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

    /// The least that a threshold may be in an exposure.
    #[inline(always)]
    pub(super) fn least(&self, threshold: f32) -> f32 {
        if self.deviation > 0.0 {
            (threshold - self.deviation).max(MIN_THRESHOLD)
        } else {
            threshold
        }
    }

    /// Takes what has leaked so far into the memories, if it is time.
    pub(crate) fn keep_anchor(&mut self, before: &mut [f32], now_s: f64) {
        if now_s - self.anchor_s >= ANCHOR_S {
            self.move_anchor(before, now_s);
        }
    }

    fn move_anchor(&mut self, before: &mut [f32], now_s: f64) {
        let age_s = now_s - self.anchor_s;
        if self.leak_per_s.is_empty() && self.leaked.is_empty() {
            self.anchor_s = now_s;
            return;
        }
        for (pixel, cell) in self.cells.iter_mut().enumerate() {
            let steady = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
            let mut shift = steady * age_s;
            if let Some(leaked) = self.leaked.get_mut(pixel) {
                shift += f64::from(*leaked);
                before[pixel] -= *leaked;
                *leaked = 0.0;
            }
            cell.memory = (f64::from(cell.memory) - shift) as f32;
            self.wake_on[pixel] = (f64::from(self.wake_on[pixel]) - shift) as f32;
            self.wake_off[pixel] = (f64::from(self.wake_off[pixel]) - shift) as f32;
        }
        self.anchor_s = now_s;
    }

    /// Draws the spontaneous events of the pixels in this exposure.
    pub(crate) fn strike(&mut self, chain: &Chain, tick: &Tick) {
        self.noise_events.clear();
        if tick.dt_s() <= 0.0 {
            return;
        }
        for (index, (link, memory)) in chain.terms.iter().zip(&self.terms).enumerate() {
            let noise = StageNoise::at_tick(memory.noise_key, tick.index);
            let first = self.noise_events.len();
            link.stage.strike(tick, self.size, &memory.table, noise, &mut self.noise_events);
            self.noise_events[first..]
                .iter_mut()
                .for_each(|noise_event| noise_event.term = index as u8);
        }
        // Hits come in long runs in order, of which a stable sort makes use.
        self.noise_events.sort_by(|a, b| a.pixel.cmp(&b.pixel).then(a.t_s.total_cmp(&b.t_s)));
    }

    /// A pixel as the detector sees it in a step.
    #[inline(always)]
    pub(super) fn step_of(&self, step: Step<'_>, pixel: usize) -> PixelStep {
        let Step { tick, per_s, .. } = step;
        let cell = &self.cells[pixel];
        let leak = self.leak_per_s.get(pixel).map_or(0.0, |&leak| f64::from(leak));
        PixelStep {
            start_s: tick.start_s,
            end_s: tick.end_s,
            from: f64::from(step.before[pixel]) + leak * (tick.start_s - self.anchor_s),
            to: f64::from(step.after(pixel)) + leak * (tick.end_s - self.anchor_s),
            memory: f64::from(cell.memory),
            threshold_on: f64::from(cell.threshold_on),
            threshold_off: f64::from(cell.threshold_off),
            pixel: pixel as u32,
            count: cell.count,
            per_s,
            is_single: step.chain.is_single,
        }
    }

    /// How far a pixel is from its memory at the end of a step; dead ones have none.
    pub(crate) fn residual(&self, step: Step<'_>, pixel: usize) -> f32 {
        let pixel_step = self.step_of(step, pixel);
        (pixel_step.to - pixel_step.memory) as f32
    }

    /// Whether background requests of this pixel are lost as well.
    pub(crate) fn is_dead(&self, pixel: u32) -> bool {
        self.has_dead && self.traits[pixel as usize].is_dead
    }
}
