//! Signals, states and noise keys between luminance and voltage.
//!
//! A step goes through all pixels as one [band](FrontBand), or as several at the same time.

use std::ops::Range;

use evpose_core::{SensorSize, seed_for};

use crate::chain::Chain;
use crate::changes::{Changes, STRIP, Task, take_front};
use crate::front_band::{FrontBand, StageBand};

#[derive(Debug)]
pub(crate) struct Front {
    size: SensorSize,
    block_pixels: usize,
    holds_all_light: bool,
    /// Voltage of all pixels at this step. Where every block is resolved before the next one, that
    /// of the block in work, at the beginning of its band: planes that are not there leave room in
    /// the cache.
    voltage: Vec<f32>,
    /// Voltage of all pixels at the step before.
    before: Vec<f32>,
    memory: Vec<StageMemory>,
    changes: Changes,
    room: Vec<Room>,
    /// Cleared by tests that look at every pixel in every step.
    pub(crate) may_skip_unchanged: bool,
}

#[derive(Debug)]
struct StageMemory {
    planes: Vec<Vec<f32>>,
    noise_key: u64,
}

#[derive(Debug, Default)]
pub(crate) struct Room {
    /// Light of the block in work; of all pixels where a stage needs the whole plane.
    pub(crate) light: Vec<f32>,
    /// Work of this step, where unchanged pixels are skipped.
    pub(crate) tasks: Vec<(Range<usize>, Task)>,
    /// Luminance values so far that were negative or not finite, and were taken as darkness.
    pub(crate) repaired: u64,
}

impl Front {
    pub(crate) fn new(chain: &Chain, size: SensorSize, seed: u64, block_pixels: usize) -> Self {
        let pixels = size.pixels();
        let memory = chain.front.iter().map(|link| StageMemory {
            planes: vec![vec![0.0; pixels]; link.stage.state_planes()],
            // By name: a stage that is added leaves the noise of the others unchanged.
            noise_key: seed_for(seed, link.name, 0),
        });
        Self {
            size,
            block_pixels: block_pixels.max(1),
            holds_all_light: chain.front.iter().any(|link| link.stage.is_plane()),
            voltage: vec![0.0; pixels],
            before: vec![0.0; pixels],
            memory: memory.collect(),
            changes: Changes::new(pixels),
            room: Vec::new(),
            may_skip_unchanged: true,
        }
    }

    /// Luminance values so far that were negative or not finite, and were taken as darkness.
    pub(crate) fn repaired(&self) -> u64 {
        self.room.iter().map(|room| room.repaired).sum()
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
    pub(crate) fn swap_steps(&mut self) {
        std::mem::swap(&mut self.before, &mut self.voltage);
    }

    /// Takes nothing of the last step for granted.
    pub(crate) fn mark_all_unknown(&mut self) {
        self.changes.mark_all_unknown();
    }

    /// Whether a step by blocks looks only at what changes.
    pub(crate) fn skips_unchanged(&self, chain: &Chain) -> bool {
        self.may_skip_unchanged && chain.plan.skips_unchanged
    }

    /// Bands of pixels that follow each other from the first pixel to the last.
    pub(crate) fn bands(&mut self, ranges: &[Range<usize>]) -> Vec<FrontBand<'_>> {
        // Buffers are kept from step to step, so that nothing is allocated again.
        if self.room.len() < ranges.len() {
            self.room.resize_with(ranges.len(), Room::default);
        }
        let (mut voltage, mut before) = (&mut *self.voltage, &mut *self.before);
        let mut stages: Vec<StageBand<'_>> = self
            .memory
            .iter_mut()
            .map(|memory| StageBand {
                planes: memory.planes.iter_mut().map(Vec::as_mut_slice).collect(),
                noise_key: memory.noise_key,
            })
            .collect();
        let changes = self.changes.bands(ranges);
        let bands =
            ranges.iter().zip(&mut self.room).zip(changes).map(|((pixels, room), changes)| {
                // A plane stage reads pixels of other blocks, so that no light may be overwritten
                // before it.
                let held = if self.holds_all_light {
                    pixels.len()
                } else {
                    self.block_pixels.max(STRIP).min(pixels.len())
                };
                room.light.resize(held, 0.0);
                FrontBand {
                    size: self.size,
                    pixels: pixels.clone(),
                    block_pixels: self.block_pixels,
                    holds_all_light: self.holds_all_light,
                    resolves_blocks: false,
                    voltage: take_front(&mut voltage, pixels.len()),
                    before: take_front(&mut before, pixels.len()),
                    stages: stages.iter_mut().map(|stage| stage.take_front(pixels.len())).collect(),
                    changes,
                    room,
                }
            });
        bands.collect()
    }
}
