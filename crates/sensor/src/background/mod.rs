//! Requests that no change of light has caused.

use std::fmt::Debug;

use evpose_core::{SensorSize, StageNoise};

use crate::Request;
use crate::tick::Tick;

pub(crate) mod hot_pixels;
pub(crate) mod shot_noise_poisson;
pub(crate) mod uniform_noise;

/// Adds to the requests of a step, or takes some away.
pub trait BackgroundStage: Send + Sync + Debug {
    /// Changes the requests of `tick`, which need no order: the chain puts them in order behind
    /// the last background stage. Times stay within the tick.
    fn step(&self, tick: &Tick, size: SensorSize, requests: &mut Vec<Request>, noise: StageNoise);
}

/// Uniform in (0, 1], 53 bits: rare events need more than the 24 of a pixel's draw.
pub(crate) fn uniform(noise: StageNoise, sequence: usize, draw: u32) -> f64 {
    ((noise.bits(sequence, draw) >> 11) + 1) as f64 / (1u64 << 53) as f64
}

pub(crate) fn exponential(noise: StageNoise, sequence: usize, draw: u32) -> f64 {
    -uniform(noise, sequence, draw).ln()
}
