//! Surrogate tests of a recording without a scene.
//!
//! The light is unknown, but it changes more slowly than a readout or a clock. [`surrogates`] keep
//! every event in its window of time and randomise its time within the window: a test of structure
//! finer than the window is then exact, whatever the light did. [`scene_free::test_recording`]
//! applies many such tests.
//!
//! # Source
//! Interval jitter in fixed windows: Amarasingham, Harrison, Hatsopoulos, Geman: *Conditional
//! modeling and the jitter method of spike resampling*, J. Neurophysiology 107, 2012. Windows
//! centred on events are no exact test: Platkiewicz, Stark, Amarasingham: *Spike-centered jitter
//! can mistake temporal structure*, Neural Computation 29, 2017.

mod agreement;
mod background;
mod clock;
mod evidence;
mod findings;
mod interval;
mod line;
mod load;
mod multiplicity;
mod null;
mod pixel_counts;
pub mod scene_free;
mod stretches;
mod train;

use evpose_core::{CounterRng, EventStream, Micros};

pub use findings::{
    SceneFreeEffect, SceneFreeFindings, SceneFreeParameter, SceneFreeStatistic, Untestable,
};

/// Draws a surrogate: every event at a uniformly random time within its window. Windows begin at
/// multiples of their length, the first at the first event; the last ends with the last event.
/// Pixel and polarity stay. The same seed and index give the same surrogate.
pub fn surrogates(events: &EventStream, window: Micros, seed: u64, index: u64) -> EventStream {
    let mut rng = CounterRng::new(seed, "interval jitter", index);
    train::Train::from_events(events).jittered(window.0.max(1), &mut rng).into_stream()
}

#[cfg(test)]
mod tests;
