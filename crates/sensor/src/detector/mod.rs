//! Log voltage to requests: which pixels have seen a change, and when.
//!
//! A sensor has one change detector, which knows a single pixel between two exposures, and any
//! number of [pixel terms](PixelTerm), which say how pixels differ, what they do by themselves and
//! what an event leaves behind. The [array](mod@array) keeps the pixels, finds those that may have
//! an event, and asks only them.

use std::fmt::Debug;

use evpose_core::{Polarity, StageNoise};

use crate::{NumberSpec, Parameter, Traits};

pub(crate) mod array;
pub(crate) mod band;
mod batches;
pub(crate) mod brownian_passage;
mod burst;
mod crossings;
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
pub(crate) mod term;
pub(crate) mod threshold_mismatch;
pub(crate) mod threshold_temporal_noise;
mod varying;

pub(crate) use array::PixelArray;
pub(crate) use band::Band;
pub use pixel::{PixelStep, PixelTraits};
pub use term::{NoiseEvent, PixelTerm, Recovery, TermTable};

/// Compares the voltage of a pixel with the one it remembers.
pub trait ChangeDetector: Send + Sync + Debug {
    /// The nominal thresholds in units of ln: ON, OFF.
    fn thresholds(&self) -> [f32; 2];

    /// Properties from which the chain chooses the path of a step.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// For one that compares frames: the voltages from which a pixel has events, up and down, if they
    /// are known to the last bit. [`next`](Self::next) has an answer there and beyond, and nowhere else. The
    /// array otherwise asks a little early, and in every step again where a voltage stays just
    /// within its threshold.
    fn event_limits(&self, _memory: f32, _thresholds: [f32; 2]) -> Option<[f32; 2]> {
        None
    }

    /// The next event or burst of a pixel, not before `from_s`; none if the step ends without one.
    /// The array applies the result and asks again.
    fn next(&self, pixel: &PixelStep, from_s: f64, noise: StageNoise) -> Option<Change>;
}

/// The answer of a detector for one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Time of the event or burst, in seconds.
    pub t_s: f64,
    /// Polarity of its events.
    pub polarity: Polarity,
    /// How many events at once. With none, only the memory changes.
    pub count: u32,
    /// Reference level behind it, ln.
    pub memory: f64,
}

const THRESHOLD: NumberSpec = NumberSpec {
    name: "threshold_on",
    unit: "ln",
    range: (0.01, 5.0),
    typical: Some((0.1, 0.6)),
    doc: "rise of log voltage that makes an ON event",
    ..NumberSpec::LOG
};

const THRESHOLD_ON: Parameter = Parameter::Number(THRESHOLD);

const THRESHOLD_OFF: Parameter = Parameter::Number(NumberSpec {
    name: "threshold_off",
    doc: "fall of log voltage that makes an OFF event",
    ..THRESHOLD
});
