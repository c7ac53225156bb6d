//! What a recording tells alone, without a scene.
//!
//! The light is unknown, but what it does is slower than what a readout or a clock does.
//! [`surrogates`] keep every event in its window of time and forget where in the window it was: a
//! statistic of structure finer than the window is then compared with a recording that has none,
//! exactly, whatever the light did. [`bare::examine`] does so with many statistics.
//!
//! # Source
//! Interval jitter in fixed windows: Amarasingham, Harrison, Hatsopoulos, Geman: *Conditional
//! modeling and the jitter method of spike resampling*, J. Neurophysiology 107, 2012. Windows
//! centred on events are no exact test: Platkiewicz, Stark, Amarasingham: *Spike-centered jitter
//! can mistake temporal structure*, Neural Computation 29, 2017.

mod agreement;
pub mod bare;
mod clock;
mod evidence;
mod findings;
mod fourier;
mod interval;
mod line;
mod load;
mod multiplicity;
mod null;
mod places;
mod quiet;
mod train;

use evpose_core::{CounterRng, EventStream, Micros};

pub use findings::{BareEffect, BareFindings, BareParameter, BareStatistic, Untestable};

/// The recording with every event at a time of chance inside its window: windows begin at whole
/// multiples of their length. Pixel and polarity stay. The first window begins with the first event
/// and the last ends with the last, so that nothing leaves the recording.
///
/// The same seed and index give the same surrogate.
pub fn surrogates(events: &EventStream, window: Micros, seed: u64, index: u64) -> EventStream {
    let mut rng = CounterRng::new(seed, "interval jitter", index);
    train::Train::of(events).jittered(window.0.max(1), &mut rng).into_stream()
}

#[cfg(test)]
mod tests;
