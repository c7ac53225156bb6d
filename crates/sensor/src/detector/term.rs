//! Pixel terms: one effect each on how a pixel detects changes.

use std::fmt::Debug;
use std::ops::Range;

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::PixelTraits;
use crate::tick::Tick;
use crate::{Origin, Traits};

/// An effect on pixels, beside the change detector. Every method has an empty default: a term
/// gives those that it is about.
pub trait PixelTerm: Send + Sync + Debug {
    /// Properties from which the chain chooses the path of a step. Methods below that a property names
    /// are asked only where the term has it.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// Changes what sets a pixel apart, for good. The noise is the same at every call.
    fn pattern(&self, _pixel: usize, _traits: &mut PixelTraits, _noise: StageNoise) {}

    /// How far the memory of a pixel is from its first voltage, in thresholds to be passed to an
    /// ON event: between 0 and 1.
    fn first_phase(&self, _pixel: usize, _noise: StageNoise) -> f32 {
        0.0
    }

    /// Changes what holds until the next event of a pixel that has had `count`, the last of them
    /// `last`. `traits` is the fixed pattern, as far as terms before this one have left it.
    fn renew(
        &self,
        _pixel: usize,
        _count: u32,
        _last: Option<Polarity>,
        _traits: &mut PixelTraits,
        _noise: StageNoise,
    ) {
    }

    /// Deviation of the thresholds of a pixel in one exposure, ln.
    fn redraw(&self, _pixel: usize, _noise: StageNoise) -> f32 {
        0.0
    }

    /// Adds what leaks off the memories of some pixels in this tick, in ln, beyond the steady
    /// `leak_per_s` of each.
    fn add_leak(
        &self,
        _tick: &Tick,
        _pixels: &Range<usize>,
        _leak_per_s: &[f32],
        _leaked: &mut [f32],
        _noise: StageNoise,
    ) {
    }

    /// Table for [`PixelTerm::noise_events`], computed once for all pixels.
    fn table(&self, _traits: &[PixelTraits], _noise: StageNoise) -> TermTable {
        TermTable::default()
    }

    /// Number of parts of [`PixelTerm::noise_events`], which may be drawn at the same time. The last are the
    /// longest.
    fn noise_parts(&self) -> usize {
        1
    }

    /// Appends a part of what pixels do by themselves in this exposure, best in order of pixels and,
    /// for one pixel, of time: the array puts them in order. Dead pixels do nothing.
    fn noise_events(
        &self,
        _part: usize,
        _tick: &Tick,
        _size: SensorSize,
        _table: &TermTable,
        _noise: StageNoise,
        _noise_events: &mut Vec<NoiseEvent>,
    ) {
    }

    /// The probability that a noise event takes place at this light.
    fn acceptance(&self, _light: f32) -> f32 {
        1.0
    }
}

/// Values that a term precomputes for all its pixels; the term defines their meaning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TermTable {
    /// Cumulative sums.
    pub sums: Vec<f64>,
    /// One value per pixel.
    pub values: Vec<f32>,
}

/// A noise event: not caused by a change of light. It resets the memorised level to the voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseEvent {
    /// Time of the event, in seconds.
    pub t_s: f64,
    /// Index of the pixel.
    pub pixel: u32,
    /// Polarity of the event.
    pub polarity: Polarity,
    /// Cause of the event.
    pub origin: Origin,
    /// Uniform in (0, 1]: the noise event takes place if it is not above the acceptance.
    pub chance: f32,
    /// Index of the term it comes from; set by the array.
    pub term: u8,
}

/// The recovery of a pixel from an event.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Recovery {
    /// Refractory period after the event, in seconds.
    pub refractory_s: f64,
    /// How long its memory follows the voltage, in seconds.
    pub follows_s: f64,
    /// Fraction of the time to the next exposure for which it does both at least.
    pub to_exposure: f64,
    /// The part of the threshold by which the memory falls short of the level crossed.
    pub short_fraction: f64,
}

impl Recovery {
    /// Both: the longer times, and the parts together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            refractory_s: self.refractory_s.max(other.refractory_s),
            follows_s: self.follows_s.max(other.follows_s),
            to_exposure: self.to_exposure.max(other.to_exposure),
            short_fraction: self.short_fraction + other.short_fraction,
        }
    }

    /// Whether an event leaves a refractory period or a following reference level.
    pub(crate) fn is_refractory(&self) -> bool {
        self.refractory_s > 0.0 || self.follows_s > 0.0 || self.to_exposure > 0.0
    }
}
