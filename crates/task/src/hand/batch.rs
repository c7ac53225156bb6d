//! Inputs that are inferred together.

use evpose_core::{Micros, SensorSize};
use evpose_repr::Representation;

/// Input channels of the network.
const CHANNELS: usize = 2;

/// Inputs one after another, `[inputs][2][rows][columns]`, with their time stamps.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct InputBatch {
    values: Vec<f32>,
    times: Vec<Micros>,
}

impl InputBatch {
    /// `count` inputs without events.
    pub fn without_events(sensor: SensorSize, count: usize) -> Self {
        Self {
            values: vec![0.0; count * CHANNELS * sensor.pixels()],
            times: vec![Micros(0); count],
        }
    }

    /// Adds the current image of `representation`, for events of `sensor`, with the time stamp `t`.
    pub fn add(&mut self, representation: &mut dyn Representation, sensor: SensorSize, t: Micros) {
        let (start, pixels) = (self.values.len(), sensor.pixels());
        self.values.resize(start + CHANNELS * pixels, 0.0);
        let channels = representation.channels();
        render_channels(&mut self.values[start..], channels, |own| representation.render(own));
        self.times.push(t);
    }

    /// Values, `[inputs][2][rows][columns]`.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Time stamps of the inputs.
    pub fn times(&self) -> &[Micros] {
        &self.times
    }

    /// Number of inputs.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no inputs.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Removes all inputs.
    pub fn clear(&mut self) {
        self.values.clear();
        self.times.clear();
    }
}

/// Fills the channels of an input `[2][rows][columns]` from a representation of `channels`
/// channels, which `render` writes. A representation of one channel fills both.
pub fn render_channels(input: &mut [f32], channels: usize, render: impl FnOnce(&mut [f32])) {
    let (own, copy) = input.split_at_mut(channels * (input.len() / CHANNELS));
    render(own);
    copy.copy_from_slice(&own[..copy.len()]);
}
