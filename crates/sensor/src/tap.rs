//! A probe on one pixel: its signal behind a stage, step by step.

use std::ops::Range;

/// Recording of one pixel's signals.
#[derive(Debug, Clone, PartialEq)]
pub struct Tap {
    stage: &'static str,
    pixel: usize,
    samples: Vec<(f64, f32)>,
}

impl Tap {
    pub(crate) fn new(stage: &'static str, pixel: usize) -> Self {
        Self { stage, pixel, samples: Vec::new() }
    }

    /// The stage behind which it sits.
    pub fn stage(&self) -> &'static str {
        self.stage
    }

    /// Pixel index, row by row from the top left.
    pub fn pixel(&self) -> usize {
        self.pixel
    }

    /// Time in seconds and signal, one pair per step: light relative to white in front of the
    /// photoreceptor, units of ln behind it. Behind a change detector it is the difference from
    /// the memory.
    pub fn samples(&self) -> &[(f64, f32)] {
        &self.samples
    }

    pub(crate) fn is_at(&self, stage: &str, pixels: &Range<usize>) -> bool {
        pixels.contains(&self.pixel) && self.stage == stage
    }

    pub(crate) fn push(&mut self, t_s: f64, value: f32) {
        self.samples.push((t_s, value));
    }
}
