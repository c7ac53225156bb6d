//! One pixel of the array: how it differs from others, what it remembers, and its step.
//!
//! # Model
//! A detector compares `x(t) = V(t) + leaked(t)` with a level `M`: taking charge off the memory is
//! the same as adding it to the voltage, and leaves the memory alone until there is an event. In a
//! step `x` is a straight line, leak included.

use evpose_core::Polarity;

use super::Recovery;

/// The fixed pattern: what is different from pixel to pixel, for good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelTraits {
    /// Rise that makes an ON event, ln.
    pub threshold_on: f32,
    /// Fall that makes an OFF event, ln.
    pub threshold_off: f32,
    /// ON events per second without light or change.
    pub leak_hz: f32,
    /// The same per light of white.
    pub photo_leak_hz: f32,
    /// Whether the pixel has no events.
    pub is_dead: bool,
}

impl PixelTraits {
    pub(crate) fn alike(threshold_on: f32, threshold_off: f32) -> Self {
        Self { threshold_on, threshold_off, leak_hz: 0.0, photo_leak_hz: 0.0, is_dead: false }
    }

    pub(crate) fn leak_per_s(&self) -> f32 {
        self.leak_hz * self.threshold_on
    }
}

/// State of a pixel between exposures. Only pixels that may have an event are touched, one here and
/// one there: what they need lies together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    /// The level compared with, as it was at the array's anchor time.
    pub(crate) memory: f32,
    pub(crate) threshold_on: f32,
    pub(crate) threshold_off: f32,
    /// Events so far, which number the draws of this pixel.
    pub(crate) count: u32,
}

impl Cell {
    pub(crate) fn new(traits: &PixelTraits) -> Self {
        let mut cell = Self { memory: 0.0, threshold_on: 0.0, threshold_off: 0.0, count: 0 };
        cell.set_thresholds(traits);
        cell
    }

    pub(crate) fn set_thresholds(&mut self, traits: &PixelTraits) {
        let dead = |threshold| if traits.is_dead { f32::INFINITY } else { threshold };
        self.threshold_on = dead(traits.threshold_on);
        self.threshold_off = dead(traits.threshold_off);
    }
}

/// The state of a pixel after an event: refractory, or with a reference level that follows the
/// voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RefractoryState {
    /// Refractory before this time; for ever while it waits for the readout.
    pub(crate) free_s: f64,
    /// The memory is what the voltage will be then; minus infinity where nothing is due.
    pub(crate) follows_until_s: f64,
}

impl RefractoryState {
    pub(crate) const NONE: Self =
        Self { free_s: f64::NEG_INFINITY, follows_until_s: f64::NEG_INFINITY };

    /// Refractory state after an event at `t_s`, the next exposure being at `exposure_s`.
    #[inline(always)]
    pub(crate) fn after(t_s: f64, exposure_s: f64, recovery: &Recovery) -> Self {
        let least = if recovery.to_exposure > 0.0 {
            t_s + recovery.to_exposure * (exposure_s - t_s).max(0.0)
        } else {
            f64::NEG_INFINITY
        };
        let until = |s: f64| if s > 0.0 { least.max(t_s + s) } else { least };
        Self { free_s: until(recovery.refractory_s), follows_until_s: until(recovery.follows_s) }
    }
}

/// A pixel in one step, as a detector sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelStep {
    /// Start of the step, in seconds.
    pub start_s: f64,
    /// End of the step, in seconds.
    pub end_s: f64,
    /// The compared quantity at the start: log voltage and leak, or light.
    pub from: f64,
    /// The compared quantity at the end of the step.
    pub to: f64,
    /// The level compared with.
    pub memory: f64,
    /// Threshold in force, ln.
    pub threshold_on: f64,
    /// Threshold in force, ln.
    pub threshold_off: f64,
    /// Index of the pixel, row by row.
    pub pixel: u32,
    /// How many events it has had.
    pub count: u32,
    /// Parts of the step per second: one over its length.
    pub per_s: f64,
    /// Whether voltage and memory are kept in single precision, as published: the leak is then off
    /// the memory already, and operations on it are rounded one by one.
    pub is_single: bool,
}

#[cfg(test)]
impl PixelStep {
    /// A step of a second from its beginning to its end, of pixel 0.
    pub(crate) fn of_test(memory: f64, [from, to]: [f64; 2], [on, off]: [f64; 2]) -> Self {
        let (threshold_on, threshold_off) = (on, off);
        let (start_s, end_s, per_s) = (0.0, 1.0, 1.0);
        let (pixel, count, is_single) = (0, 0, false);
        Self {
            start_s,
            end_s,
            from,
            to,
            memory,
            threshold_on,
            threshold_off,
            pixel,
            count,
            per_s,
            is_single,
        }
    }
}

impl PixelStep {
    /// The compared quantity at a time within the step.
    pub fn at(&self, t_s: f64) -> f64 {
        if t_s >= self.end_s {
            return self.to;
        }
        if t_s <= self.start_s {
            return self.from;
        }
        self.from + (self.to - self.from) * ((t_s - self.start_s) * self.per_s)
    }

    /// Difference of the compared quantity and the memory at the end of the step.
    pub fn difference(&self) -> f64 {
        self.rounded(self.to - self.memory)
    }

    /// The memory behind `count` events at once.
    pub fn memory_behind(&self, polarity: Polarity, count: u32) -> f64 {
        let by = |threshold| self.rounded(f64::from(count) * threshold);
        self.rounded(match polarity {
            Polarity::On => self.memory + by(self.threshold_on),
            Polarity::Off => self.memory - by(self.threshold_off),
        })
    }

    /// Rounds to single precision if the detector does; of single-precision operands, a double
    /// result rounded again is the single result.
    fn rounded(&self, x: f64) -> f64 {
        if self.is_single { f64::from(x as f32) } else { x }
    }

    /// The level one threshold away.
    pub fn level(&self, polarity: Polarity) -> f64 {
        match polarity {
            Polarity::On => self.memory + self.threshold_on,
            Polarity::Off => self.memory - self.threshold_off,
        }
    }
}
