//! Log voltage to requests: which pixels have seen a change, and when.
//!
//! A sensor has one change detector, which knows a single pixel between two exposures, and any
//! number of [pixel terms](PixelTerm), which say how pixels differ, what they do by themselves and
//! what an event leaves behind. The [array](mod@array) keeps the pixels, finds those that may have
//! something to say, and asks only them.

use std::fmt::Debug;

use evpose_core::{Polarity, StageNoise};

use crate::{ParamSpec, Prior, Scale};

pub(crate) mod array;
pub(crate) mod band;
pub(crate) mod brownian_passage;
mod burst;
pub(crate) mod dead_pixels;
mod find;
pub(crate) mod fixed_pattern;
pub(crate) mod frame_count;
pub(crate) mod frame_difference;
pub(crate) mod hysteresis;
pub(crate) mod leak_on;
pub(crate) mod level_crossing;
pub(crate) mod parasitic_photo_leak;
pub(crate) mod pixel;
pub(crate) mod queue;
pub(crate) mod refractory;
pub(crate) mod reset_overshoot;
pub(crate) mod resolve;
pub(crate) mod scan;
mod spread;
mod straight;
pub(crate) mod term;
pub(crate) mod threshold_mismatch;
pub(crate) mod threshold_temporal_noise;
mod together;

pub(crate) use array::PixelArray;
pub(crate) use band::Band;
pub use pixel::{PixelStep, PixelTraits};
pub use term::{NoiseEvent, PixelTerm, Recovery, TermTable};

/// Compares the voltage of a pixel with the one it remembers.
pub trait ChangeDetector: Send + Sync + Debug {
    /// The nominal thresholds in units of ln: ON, OFF.
    fn thresholds(&self) -> [f32; 2];

    /// Whether the memory starts at the voltage of darkness rather than at the first exposure.
    fn starts_cold(&self) -> bool {
        false
    }

    /// Whether it compares light, in code values of 0 to 255, rather than log voltage, and decides
    /// at random: every pixel is then asked at every step.
    fn sees_light(&self) -> bool {
        false
    }

    /// Whether it compares frames: it is asked once a step, and answers for the end of it.
    fn compares_frames(&self) -> bool {
        false
    }

    /// Whether a pixel has events exactly where it is a threshold away from its memory, so that
    /// the array need not ask where it stays within.
    fn crosses_levels(&self) -> bool {
        false
    }

    /// Whether a pixel that waits for a slow readout is blind until it is served. Otherwise the
    /// readout only delays events.
    fn waits_for_readout(&self) -> bool {
        false
    }

    /// Whether the events of one answer are spread over the step, at as many even times as the
    /// busiest pixel has events.
    fn spreads(&self) -> bool {
        false
    }

    /// Whether it rounds as the published emulator does: refractory periods between those even
    /// times are measured in seconds of single precision, and where nothing acts on the voltage
    /// behind the photoreceptor, [memories and leaks](PixelStep::is_single) are kept in it as well.
    fn rounds_as_published(&self) -> bool {
        false
    }

    /// For one that compares frames: the voltages from which a pixel has something to say, up and
    /// down, if that is known to the last bit. [`next`](Self::next) has an answer there and beyond,
    /// and nowhere else. The array otherwise asks a little early, and in every step again where a
    /// voltage stays just within its threshold.
    fn speaks_from(&self, _memory: f32, _thresholds: [f32; 2]) -> Option<[f32; 2]> {
        None
    }

    /// The next event or burst of a pixel, not before `from_s`; none if the step ends without one.
    /// The array applies the result and asks again.
    fn next(&self, pixel: &PixelStep, from_s: f64, noise: StageNoise) -> Option<Change>;
}

/// The answer of a detector for one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// When.
    pub t_s: f64,
    /// Its polarity.
    pub polarity: Polarity,
    /// How many events at once. With none, only the memory changes.
    pub count: u32,
    /// The level to be remembered.
    pub memory: f64,
}

const THRESHOLD_ON: ParamSpec = ParamSpec {
    name: "threshold_on",
    unit: "ln",
    range: (0.01, 5.0),
    scale: Scale::Log,
    prior: Prior::Typical(0.1, 0.6),
    neutral: None,
    doc: "rise of log voltage that makes an ON event",
};

const THRESHOLD_OFF: ParamSpec = ParamSpec {
    name: "threshold_off",
    doc: "fall of log voltage that makes an OFF event",
    ..THRESHOLD_ON
};
