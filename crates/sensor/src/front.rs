//! Runs the stages between luminance and voltage, block by block where pixels do not see each
//! other, and shows every block to the pixels while it is in the cache.

use std::ops::Range;

use evpose_core::{SensorSize, StageNoise, seed_for};

use crate::Request;
use crate::chain::{Chain, FrontStage, Link};
use crate::changes::{Changes, STRIP, Task};
use crate::detector::PixelArray;
use crate::detector::resolve::Step;
use crate::stage::{Block, State};
use crate::tap::Tap;
use crate::tick::Tick;
use evpose_simd::{prefetch, vectorize};

/// Values of `f32` in a cache line.
const CACHE_LINE: usize = 16;

/// Signals, states and noise keys of one run.
#[derive(Debug)]
pub(crate) struct Front {
    size: SensorSize,
    block_pixels: usize,
    /// Light of the block in work; of all pixels where a stage needs the whole plane.
    light: Vec<f32>,
    holds_all_light: bool,
    /// Voltage of all pixels at this step, or only of the block in work: see `goes_by_blocks`.
    voltage: Vec<f32>,
    /// Voltage of all pixels at the step before.
    before: Vec<f32>,
    /// Whether, in this step, a block is resolved before the next one, so that voltages of no more
    /// than a block are kept twice: planes that are not there leave room in the cache.
    goes_by_blocks: bool,
    memory: Vec<StageMemory>,
    changes: Changes,
    repaired: u64,
    /// Cleared by tests that look at every pixel in every step.
    pub(crate) may_pass_over: bool,
}

/// State of one stage.
#[derive(Debug)]
struct StageMemory {
    planes: Vec<Vec<f32>>,
    noise_key: u64,
}

/// Observers of a step's signals.
#[derive(Debug)]
pub(crate) struct Observers<'a> {
    pub(crate) array: &'a mut PixelArray,
    pub(crate) taps: &'a mut [Tap],
    /// Takes pixels through the step block by block, where they need not wait for each other.
    pub(crate) resolution: Option<Resolution<'a>>,
}

/// Step constants of the detector, and the list that takes the requests of resolved pixels.
#[derive(Debug)]
pub(crate) struct Resolution<'a> {
    /// One over the length of the step.
    pub(crate) per_s: f64,
    /// Noise of the detector.
    pub(crate) noise: StageNoise,
    pub(crate) requests: &'a mut Vec<Request>,
}

impl Resolution<'_> {
    /// Takes the pixels that woke through the step, from voltages of all pixels before it and of
    /// those from `first` on behind it.
    fn resolve(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        array: &mut PixelArray,
        [before, after]: [&[f32]; 2],
        first: usize,
    ) {
        let Self { per_s, noise, ref mut requests } = *self;
        array.resolve(Step { chain, tick, before, after, first, per_s, noise }, requests);
    }
}

impl Front {
    pub(crate) fn new(chain: &Chain, size: SensorSize, seed: u64, block_pixels: usize) -> Self {
        let holds_all_light = chain.front.iter().any(|link| link.stage.is_plane());
        let pixels = size.pixels();
        let held = if holds_all_light { pixels } else { block_pixels.max(STRIP).min(pixels) };
        let memory = chain.front.iter().map(|link| StageMemory {
            planes: vec![vec![0.0; pixels]; link.stage.state_planes()],
            noise_key: seed_for(seed, link.name, 0),
        });
        Self {
            size,
            block_pixels: block_pixels.max(1),
            light: vec![0.0; held],
            holds_all_light,
            voltage: vec![0.0; pixels],
            before: vec![0.0; pixels],
            goes_by_blocks: false,
            memory: memory.collect(),
            changes: Changes::new(pixels),
            repaired: 0,
            may_pass_over: true,
        }
    }

    /// Luminance values so far that were negative or not finite, and were taken as darkness.
    pub(crate) fn repaired(&self) -> u64 {
        self.repaired
    }

    /// Voltages at the end of the step before.
    pub(crate) fn before_mut(&mut self) -> &mut [f32] {
        &mut self.before
    }

    /// Voltages at the end of the step before and of this one, where a step goes through all pixels
    /// before any is resolved.
    pub(crate) fn voltages(&self) -> (&[f32], &[f32]) {
        (&self.before, &self.voltage)
    }

    /// Makes this step the one before.
    pub(crate) fn turn_over(&mut self) {
        std::mem::swap(&mut self.before, &mut self.voltage);
    }

    /// Takes one exposure through the chain.
    pub(crate) fn step(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        luminance: &[f32],
        seen_by: &mut Observers<'_>,
    ) {
        self.goes_by_blocks = seen_by.resolution.is_some();
        if self.may_pass_over
            && chain.rests_with_light()
            && let Some(resolution) = seen_by.resolution.take()
        {
            return self.step_changes(chain, tick, luminance, seen_by.array, resolution);
        }
        self.changes.forget();
        let all = self.size.pixels();
        let mut first_stage = 0;
        // A stage that needs the whole plane is a pass of its own; what lies between two such
        // stages goes through together, block by block.
        for pass in chain.front.chunk_by(|a, b| !a.stage.is_plane() && !b.stage.is_plane()) {
            let is_plane = pass[0].stage.is_plane();
            let is_last = first_stage + pass.len() == chain.front.len();
            let block = if is_plane { all } else { self.block_pixels };
            for start in (0..all).step_by(block.max(1)) {
                let pixels = start..(start + block).min(all);
                if first_stage == 0 {
                    self.sense(&luminance[pixels.clone()], &pixels);
                    // Frames come from far; the next block arrives while this one is in work.
                    for pixel in (pixels.end..pixels.end + block).step_by(CACHE_LINE) {
                        prefetch(luminance, pixel);
                    }
                }
                for (offset, link) in pass.iter().enumerate() {
                    self.step_stage(first_stage + offset, link, tick, &pixels);
                    self.tap(link, tick, &pixels, seen_by.taps);
                }
                if is_last {
                    self.show(chain, tick, &pixels, seen_by.array);
                    if let Some(resolution) = &mut seen_by.resolution {
                        let voltage = &self.voltage[..pixels.len()];
                        let voltages = [&self.before, voltage];
                        resolution.resolve(chain, tick, seen_by.array, voltages, pixels.start);
                        self.before[pixels.clone()].copy_from_slice(voltage);
                    }
                }
            }
            first_stage += pass.len();
        }
    }

    /// The same for a chain that rests with the light: only where that is another one.
    fn step_changes(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        luminance: &[f32],
        array: &mut PixelArray,
        mut resolution: Resolution<'_>,
    ) {
        // Pieces are short: they are resolved together.
        self.goes_by_blocks = false;
        let Self { before, voltage, .. } = self;
        let tasks = self.changes.tasks(luminance, before, voltage, self.block_pixels);
        for (pixels, task) in &tasks {
            if *task == Task::Sense {
                self.sense(&luminance[pixels.clone()], pixels);
                for (index, link) in chain.front.iter().enumerate() {
                    self.step_stage(index, link, tick, pixels);
                }
            }
            let first = array.awake_count();
            self.show(chain, tick, pixels, array);
            self.changes.wake(array.awake_from(first));
        }
        resolution.resolve(chain, tick, array, [&self.before, &self.voltage], 0);
        self.changes.give_back(tasks);
        self.turn_over();
    }

    /// Takes nothing of the last step for granted.
    pub(crate) fn forget_light(&mut self) {
        self.changes.forget();
    }

    /// Range of these pixels in `light`.
    fn light_range(&self, pixels: &Range<usize>) -> Range<usize> {
        if self.holds_all_light { pixels.clone() } else { 0..pixels.len() }
    }

    /// Range of these pixels in `voltage`.
    fn voltage_range(&self, pixels: &Range<usize>) -> Range<usize> {
        if self.goes_by_blocks { 0..pixels.len() } else { pixels.clone() }
    }

    /// Shows the voltages of a block to its pixels.
    fn show(&mut self, chain: &Chain, tick: &Tick, pixels: &Range<usize>, array: &mut PixelArray) {
        let light = &self.light[self.light_range(pixels)];
        let held = self.voltage_range(pixels);
        let voltage = &mut self.voltage[held];
        array.scan(chain, tick, pixels, light, &self.before, voltage);
        if tick.index == 0 {
            self.before[pixels.clone()].copy_from_slice(voltage);
        }
    }

    fn tap(&self, link: &Link<FrontStage>, tick: &Tick, pixels: &Range<usize>, taps: &mut [Tap]) {
        for tap in taps.iter_mut().filter(|tap| tap.is_at(link.name, pixels)) {
            let value = if link.stage.is_in_light() {
                self.light[self.light_range(pixels)][tap.pixel() - pixels.start]
            } else {
                self.voltage[tap.pixel()]
            };
            tap.push(tick.end_s, value);
        }
    }

    /// Copies luminance; what cannot be light becomes darkness.
    fn sense(&mut self, luminance: &[f32], pixels: &Range<usize>) {
        let held = self.light_range(pixels);
        let light = &mut self.light[held];
        let is_faulty = vectorize(
            #[inline(always)]
            || {
                let mut is_faulty = false;
                for (light, &y) in light.iter_mut().zip(luminance) {
                    // Not a number stays one, and differs from itself.
                    *light = y.clamp(0.0, f32::MAX);
                    is_faulty |= *light != y;
                }
                is_faulty
            },
        );
        if is_faulty {
            // They are counted in every step.
            self.changes.doubt(pixels);
            for (light, y) in light.iter_mut().zip(luminance) {
                if !(0.0..=f32::MAX).contains(y) {
                    *light = 0.0;
                    self.repaired += 1;
                }
            }
        }
    }

    fn step_stage(
        &mut self,
        index: usize,
        link: &Link<FrontStage>,
        tick: &Tick,
        pixels: &Range<usize>,
    ) {
        let held = self.light_range(pixels);
        let held_voltage = self.voltage_range(pixels);
        let (light, voltage) = (&mut self.light[held], &mut self.voltage[held_voltage]);
        let memory = &mut self.memory[index];
        let noise = StageNoise::at_tick(memory.noise_key, tick.index);
        let state = State::new(&mut memory.planes, pixels.clone());
        let (photocurrent, signal): (&[f32], &mut [f32]) = match &link.stage {
            FrontStage::Photoreceptor(stage) => return stage.respond(light, voltage),
            FrontStage::LightPixel(_) | FrontStage::LightPlane(_) => (&[], light),
            _ => (light, voltage),
        };
        let block = &mut Block { pixels: pixels.clone(), photocurrent, signal, state };
        let is_first = tick.index == 0;
        match &link.stage {
            FrontStage::Photoreceptor(_) => {}
            FrontStage::LightPixel(stage) | FrontStage::VoltagePixel(stage) => {
                if is_first {
                    stage.init(block, noise);
                }
                stage.step(tick, block, noise);
            }
            FrontStage::LightPlane(stage) | FrontStage::VoltagePlane(stage) => {
                if is_first {
                    stage.init(self.size, block, noise);
                }
                stage.step(tick, self.size, block, noise);
            }
        }
    }
}
