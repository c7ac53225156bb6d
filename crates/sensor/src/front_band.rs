//! Runs the stages between luminance and voltage, block by block where pixels do not see each
//! other, and shows every block to the pixels while it is in the cache.

use std::ops::Range;

use evpose_core::{SensorSize, StageNoise};
use smallvec::SmallVec;

use crate::Request;
use crate::chain::{Chain, FrontStage, Link};
use crate::changes::{BandChanges, Task, take_front};
use crate::detector::Band;
use crate::detector::resolve::{Step, Voltages};
use crate::front::Room;
use crate::stage::{Block, COMMON_PLANES, State};
use crate::tap::Tap;
use crate::tick::Tick;
use evpose_cpu::{prefetch, vectorize};

/// Values of `f32` in a cache line.
const CACHE_LINE: usize = 16;

/// Consecutive pixels on their way from luminance to voltage, with the meanings of the fields of
/// [`Front`](crate::front::Front).
#[derive(Debug)]
pub(crate) struct FrontBand<'a> {
    pub(crate) size: SensorSize,
    /// Indices of the pixels in the whole sensor.
    pub(crate) pixels: Range<usize>,
    pub(crate) block_pixels: usize,
    pub(crate) holds_all_light: bool,
    /// Whether, in this step, a block is resolved before the next one.
    pub(crate) resolves_blocks: bool,
    pub(crate) voltage: &'a mut [f32],
    pub(crate) before: &'a mut [f32],
    pub(crate) stages: Vec<StageBand<'a>>,
    pub(crate) changes: BandChanges<'a>,
    pub(crate) room: &'a mut Room,
}

#[derive(Debug)]
pub(crate) struct StageBand<'a> {
    pub(crate) planes: SmallVec<[&'a mut [f32]; COMMON_PLANES]>,
    pub(crate) noise_key: u64,
}

impl<'a> StageBand<'a> {
    /// The state of the first pixels, which is taken off the rest.
    pub(crate) fn take_front(&mut self, pixels: usize) -> Self {
        let planes = self.planes.iter_mut().map(|plane| take_front(plane, pixels));
        Self { planes: planes.collect(), noise_key: self.noise_key }
    }
}

#[derive(Debug)]
pub(crate) struct Observers<'a, 'b> {
    pub(crate) array: &'a mut Band<'b>,
    pub(crate) taps: &'a mut [Tap],
    /// Takes pixels through the step block by block, where they need not wait for each other.
    pub(crate) resolution: Option<Resolution<'a>>,
}

/// Step constants of the detector, and the list that takes the requests of resolved pixels.
#[derive(Debug)]
pub(crate) struct Resolution<'a> {
    /// One over the length of the step.
    pub(crate) per_s: f64,
    pub(crate) noise: StageNoise,
    pub(crate) requests: &'a mut Vec<Request>,
}

impl Resolution<'_> {
    /// Takes the pixels that woke through the step.
    fn resolve(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        array: &mut Band<'_>,
        [before, after]: [Voltages<'_>; 2],
    ) {
        let Self { per_s, noise, ref mut requests } = *self;
        array.resolve(Step { chain, tick, before, after, per_s, noise }, requests);
    }
}

impl FrontBand<'_> {
    /// Takes one exposure through the chain.
    pub(crate) fn step(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        luminance: &[f32],
        seen_by: &mut Observers<'_, '_>,
    ) {
        self.resolves_blocks = seen_by.resolution.is_some();
        self.changes.mark_all_unknown();
        let all = self.pixels.clone();
        let mut first_stage = 0;
        // A stage that needs the whole plane is a pass of its own; what lies between two such
        // stages goes through together, block by block.
        for pass in chain.front.chunk_by(|a, b| !a.stage.is_plane() && !b.stage.is_plane()) {
            let is_plane = pass[0].stage.is_plane();
            let is_last = first_stage + pass.len() == chain.front.len();
            let block = if is_plane { all.len() } else { self.block_pixels };
            for start in all.clone().step_by(block.max(1)) {
                let pixels = start..(start + block).min(all.end);
                if first_stage == 0 {
                    self.load_luminance(&luminance[pixels.clone()], &pixels);
                    // Frames come from far; the next block arrives while this one is in work.
                    for pixel in (pixels.end..(pixels.end + block).min(all.end)).step_by(CACHE_LINE)
                    {
                        prefetch(luminance, pixel);
                    }
                }
                for (offset, link) in pass.iter().enumerate() {
                    self.step_stage(first_stage + offset, link, tick, &pixels);
                    self.tap(link, tick, &pixels, seen_by.taps);
                }
                if is_last {
                    self.scan_block(chain, tick, &pixels, seen_by.array);
                    if let Some(resolution) = &mut seen_by.resolution {
                        let before = Voltages { first: all.start, values: self.before };
                        let voltage = &self.voltage[..pixels.len()];
                        let after = Voltages { first: pixels.start, values: voltage };
                        resolution.resolve(chain, tick, seen_by.array, [before, after]);
                        let own = self.own(&pixels);
                        self.before[own].copy_from_slice(&self.voltage[..pixels.len()]);
                    }
                }
            }
            first_stage += pass.len();
        }
    }

    /// The same where [unchanged pixels are skipped](crate::plan::ExecutionPlan). Voltages of
    /// all pixels are those of this step afterwards.
    pub(crate) fn step_changes(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        luminance: &[f32],
        array: &mut Band<'_>,
        mut resolution: Resolution<'_>,
    ) {
        // Pieces are short: they are resolved together.
        self.resolves_blocks = false;
        let mut tasks = std::mem::take(&mut self.room.tasks);
        let own = &luminance[self.pixels.clone()];
        self.changes.find(own, self.before, self.voltage, self.block_pixels, &mut tasks);
        // Pieces to scan have the voltage of the step before, and pixels that may have more events.
        for (pixels, task) in &tasks {
            if *task == Task::Recompute {
                self.load_luminance(&luminance[pixels.clone()], pixels);
                for (index, link) in chain.front.iter().enumerate() {
                    self.step_stage(index, link, tick, pixels);
                }
            }
            // Only pixels that wake in this piece are marked.
            let first = array.awake_count();
            self.scan_block(chain, tick, pixels, array);
            self.changes.wake(array.awake_from(first));
        }
        self.room.tasks = tasks;
        let first = self.pixels.start;
        let before = Voltages { first, values: self.before };
        let after = Voltages { first, values: self.voltage };
        resolution.resolve(chain, tick, array, [before, after]);
    }

    /// Range of these pixels in the planes of the band.
    fn own(&self, pixels: &Range<usize>) -> Range<usize> {
        pixels.start - self.pixels.start..pixels.end - self.pixels.start
    }

    /// Range of these pixels in `light`.
    fn light_range(&self, pixels: &Range<usize>) -> Range<usize> {
        if self.holds_all_light { self.own(pixels) } else { 0..pixels.len() }
    }

    /// Range of these pixels in `voltage`.
    fn voltage_range(&self, pixels: &Range<usize>) -> Range<usize> {
        if self.resolves_blocks { 0..pixels.len() } else { self.own(pixels) }
    }

    /// Shows the voltages of a block to its pixels.
    fn scan_block(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        pixels: &Range<usize>,
        array: &mut Band<'_>,
    ) {
        let light = &self.room.light[self.light_range(pixels)];
        let (own, held) = (self.own(pixels), self.voltage_range(pixels));
        let voltage = &mut self.voltage[held];
        let before = Voltages { first: self.pixels.start, values: self.before };
        array.scan(chain, tick, pixels, light, before, voltage);
        // Nothing is before the first exposure, so that it changes nothing.
        if tick.index == 0 {
            self.before[own].copy_from_slice(voltage);
        }
    }

    fn tap(&self, link: &Link<FrontStage>, tick: &Tick, pixels: &Range<usize>, taps: &mut [Tap]) {
        for tap in taps.iter_mut().filter(|tap| tap.is_at(link.name, pixels)) {
            let offset = tap.pixel() - pixels.start;
            let value = if link.traits.acts_on.is_light() {
                self.room.light[self.light_range(pixels)][offset]
            } else {
                self.voltage[self.voltage_range(pixels)][offset]
            };
            tap.push(tick.end_s, value);
        }
    }

    /// Copies luminance; what cannot be light becomes darkness.
    fn load_luminance(&mut self, luminance: &[f32], pixels: &Range<usize>) {
        let held = self.light_range(pixels);
        let light = &mut self.room.light[held];
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
            self.changes.mark_unknown(pixels);
            for (light, y) in light.iter_mut().zip(luminance) {
                if !(0.0..=f32::MAX).contains(y) {
                    *light = 0.0;
                    self.room.repaired += 1;
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
        let (own, held) = (self.own(pixels), self.light_range(pixels));
        let held_voltage = self.voltage_range(pixels);
        let (light, voltage) = (&mut self.room.light[held], &mut self.voltage[held_voltage]);
        let memory = &mut self.stages[index];
        let noise = StageNoise::at_tick(memory.noise_key, tick.index);
        let state = State::new(&mut memory.planes, own);
        // Behind the law the light stays as it is: bandwidths and noise there depend on it.
        let (photocurrent, signal): (&[f32], &mut [f32]) = match &link.stage {
            FrontStage::Photoreceptor(stage) => return stage.respond(light, voltage),
            _ if link.traits.acts_on.is_light() => (&[], light),
            _ => (light, voltage),
        };
        let block = &mut Block { pixels: pixels.clone(), photocurrent, signal, state };
        let is_first = tick.index == 0;
        match &link.stage {
            FrontStage::Photoreceptor(_) => {}
            FrontStage::Pixel(stage) => {
                // Started with the first light: filters begin at rest.
                if is_first {
                    stage.init(block, noise);
                }
                stage.step(tick, block, noise);
            }
            FrontStage::Plane(stage) => {
                if is_first {
                    stage.init(self.size, block, noise);
                }
                stage.step(tick, self.size, block, noise);
            }
        }
    }
}
