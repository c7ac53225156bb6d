//! Surfaces that are predicted together.

use evpose_core::{Micros, SensorSize};
use evpose_repr::Representation;

/// Input channels of the network.
const CHANNELS: usize = 2;

/// Surfaces one after another, as the network takes them, and their times.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct SurfaceBatch {
    values: Vec<f32>,
    times: Vec<Micros>,
}

impl SurfaceBatch {
    /// So many surfaces on which nothing happened.
    pub fn empty_surfaces(sensor: SensorSize, count: usize) -> Self {
        Self {
            values: vec![0.0; count * CHANNELS * sensor.pixels()],
            times: vec![Micros(0); count],
        }
    }

    /// Adds `surface` as it is now, at `t`, of `sensor`. One of a single channel fills both of the network's.
    pub fn add(&mut self, surface: &mut dyn Representation, sensor: SensorSize, t: Micros) {
        let (start, pixels) = (self.values.len(), sensor.pixels());
        self.values.resize(start + CHANNELS * pixels, 0.0);
        let (own, copy) = self.values[start..].split_at_mut(surface.channels() * pixels);
        surface.render(own);
        copy.copy_from_slice(&own[..copy.len()]);
        self.times.push(t);
    }

    /// `[surfaces][2][rows][columns]`.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Of every surface.
    pub fn times(&self) -> &[Micros] {
        &self.times
    }

    /// How many surfaces there are.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.values.clear();
        self.times.clear();
    }
}
