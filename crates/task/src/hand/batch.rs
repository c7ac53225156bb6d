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
    // Of a representation with two channels, nothing is left to be copied.
    copy.copy_from_slice(&own[..copy.len()]);
}

#[cfg(test)]
mod tests {
    use burn::tensor::{Device, Tensor, TensorData};
    use evpose_core::{Event, EventStream, Polarity};
    use evpose_repr::{ChannelOrder, REPRESENTATIONS, StreamWindow};

    use super::*;

    #[test]
    fn planes_of_every_representation_become_a_tensor_without_a_copy() {
        let sensor = SensorSize { width: 24, height: 18 };
        let window = StreamWindow::new(sensor, Micros(1000), ChannelOrder::OffFirst).unwrap();
        let event = |t| Event { t: Micros(t), x: 3, y: 2, polarity: Polarity::On };
        let events = EventStream::from_events(sensor, (0..50).map(event)).unwrap();
        for spec in &REPRESENTATIONS {
            let mut representation = spec.with_defaults().start(window);
            representation.push(&events);
            let channels = representation.channels();
            let mut planes = vec![0.0; channels * sensor.pixels()];
            representation.render(&mut planes);
            let (memory, values) = (planes.as_ptr(), planes.clone());
            let data = TensorData::new(planes, [1, channels, 18, 24]);
            let tensor = Tensor::<4>::from_data(data, &Device::flex());
            let back = tensor.into_data();
            let back = back.as_slice::<f32>().unwrap();
            assert_eq!(back, values, "{}", spec.name);
            assert_eq!(back.as_ptr(), memory, "{}", spec.name);
        }
    }
}
