//! Runs the stages between luminance and requests, block by block where pixels do not see each
//! other.

use std::ops::Range;

use evpose_core::{SensorSize, StageNoise, seed_for};

use crate::Request;
use crate::model::{Chain, FrontStage, Link};
use crate::stage::{Block, State, Tick};

/// Signals, states and noise keys of one run.
#[derive(Debug)]
pub(crate) struct Front {
    size: SensorSize,
    block_pixels: usize,
    /// Light and voltage of the block in work; of all pixels where a stage needs the whole plane.
    light: Vec<f32>,
    voltage: Vec<f32>,
    holds_whole_plane: bool,
    memory: Vec<StageMemory>,
    repaired: u64,
}

/// What one stage keeps.
#[derive(Debug)]
struct StageMemory {
    planes: Vec<Vec<f32>>,
    noise_key: u64,
}

impl Front {
    pub(crate) fn new(chain: &Chain, size: SensorSize, seed: u64, block_pixels: usize) -> Self {
        let holds_whole_plane = chain.front.iter().any(|link| link.stage.is_plane());
        let pixels = size.pixels();
        let held = if holds_whole_plane { pixels } else { block_pixels.min(pixels) };
        let memory = chain.front.iter().map(|link| StageMemory {
            planes: vec![vec![0.0; pixels]; link.stage.state_planes()],
            noise_key: seed_for(seed, link.name, 0),
        });
        Self {
            size,
            block_pixels,
            light: vec![0.0; held],
            voltage: vec![0.0; held],
            holds_whole_plane,
            memory: memory.collect(),
            repaired: 0,
        }
    }

    /// Luminance values so far that were negative or not finite, and were taken as darkness.
    pub(crate) fn repaired(&self) -> u64 {
        self.repaired
    }

    /// Takes one exposure through the chain and appends the requests it causes.
    pub(crate) fn step(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        luminance: &[f32],
        requests: &mut Vec<Request>,
    ) {
        let all = self.size.pixels();
        let mut first_stage = 0;
        // A stage that needs the whole plane is a pass of its own; what lies between two such
        // stages goes through together, block by block.
        for pass in chain.front.chunk_by(|a, b| !a.stage.is_plane() && !b.stage.is_plane()) {
            let block = if pass[0].stage.is_plane() { all } else { self.block_pixels };
            for start in (0..all).step_by(block.max(1)) {
                let pixels = start..(start + block).min(all);
                if first_stage == 0 {
                    self.sense(&luminance[pixels.clone()], &pixels);
                }
                for (offset, link) in pass.iter().enumerate() {
                    let stage = first_stage + offset;
                    self.step_stage(chain, stage, link, tick, pixels.clone(), requests);
                }
            }
            first_stage += pass.len();
        }
    }

    /// Where in `light` and `voltage` these pixels are.
    fn held(&self, pixels: &Range<usize>) -> Range<usize> {
        if self.holds_whole_plane { pixels.clone() } else { 0..pixels.len() }
    }

    /// Copies luminance; what cannot be light becomes darkness.
    fn sense(&mut self, luminance: &[f32], pixels: &Range<usize>) {
        let held = self.held(pixels);
        let light = &mut self.light[held];
        let mut is_faulty = false;
        for (light, &y) in light.iter_mut().zip(luminance) {
            // Not a number stays one, and differs from itself.
            *light = y.clamp(0.0, f32::MAX);
            is_faulty |= *light != y;
        }
        if is_faulty {
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
        chain: &Chain,
        index: usize,
        link: &Link<FrontStage>,
        tick: &Tick,
        pixels: Range<usize>,
        requests: &mut Vec<Request>,
    ) {
        let held = self.held(&pixels);
        let (light, voltage) = (&mut self.light[held.clone()], &mut self.voltage[held]);
        let memory = &mut self.memory[index];
        let noise = StageNoise::at_tick(memory.noise_key, tick.index);
        let state = State::new(&mut memory.planes, pixels.clone());
        let (photocurrent, signal): (&[f32], &mut [f32]) = match &link.stage {
            FrontStage::Photoreceptor(stage) => return stage.respond(light, voltage),
            FrontStage::LightPixel(_) | FrontStage::LightPlane(_) => (&[], light),
            _ => (light, voltage),
        };
        let block = &mut Block { pixels, photocurrent, signal, state };
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
            FrontStage::Detector(stage) => {
                if is_first {
                    stage.init(block, chain.dark_v(), noise);
                }
                stage.step(tick, block, noise, requests);
            }
        }
    }
}
