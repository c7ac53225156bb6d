//! Log voltage to requests: which pixels have seen a change, and when.

use std::fmt::Debug;

use evpose_core::StageNoise;

use crate::stage::{Block, Tick};
use crate::{ParamSpec, Prior, Request, Scale};

pub(crate) mod frame_difference;
pub(crate) mod level_crossing;

/// Compares the voltage of a pixel with the one it remembers.
pub trait ChangeDetector: Send + Sync + Debug {
    /// How many `f32` values a pixel keeps between exposures, the same for all parameters.
    fn state_planes(&self) -> usize;

    /// Fills the state just before the first step. `dark_v` is the voltage of a pixel without
    /// light, in units of ln.
    fn init(&self, block: &mut Block<'_>, dark_v: f32, noise: StageNoise);

    /// Appends the requests of `tick`, pixel by pixel in the order of the block, those of one pixel
    /// in order of time.
    fn step(&self, tick: &Tick, block: &mut Block<'_>, noise: StageNoise, out: &mut Vec<Request>);
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

/// Pixels looked at together. A few cache lines: wide enough for any vector unit, small enough
/// that one event does not send many quiet pixels down the slow path.
const LANES: usize = 16;

/// Calls `fire(index, voltage, memory)` for the pixels whose voltage lies beyond their memory,
/// skipping quiet ones many at a time.
fn for_each_beyond(
    signal: &[f32],
    memory: &mut [f32],
    beyond: impl Fn(f32) -> bool,
    mut fire: impl FnMut(usize, f32, &mut f32),
) {
    let (signal_lanes, signal_rest) = signal.as_chunks::<LANES>();
    let (memory_lanes, memory_rest) = memory.as_chunks_mut::<LANES>();
    let mut each = |first: usize, signal: &[f32], memory: &mut [f32]| {
        for (k, (v, m)) in signal.iter().zip(memory).enumerate() {
            if beyond(v - *m) {
                fire(first + k, *v, m);
            }
        }
    };
    for (lane, (v, m)) in signal_lanes.iter().zip(memory_lanes).enumerate() {
        // No early exit: a loop without branches is what becomes vector instructions.
        if v.iter().zip(m.iter()).fold(false, |any, (v, m)| any | beyond(v - m)) {
            each(lane * LANES, v, m);
        }
    }
    each(signal_lanes.len() * LANES, signal_rest, memory_rest);
}
