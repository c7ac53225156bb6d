//! One pixel in continuous time: light in, instants of events out.

mod comparator;
mod front;
mod noise;
mod walk;

use crate::circuit::Circuit;
use crate::draw::{Purpose, Stream};
use crate::event::Spike;

pub(crate) use noise::noise_variance;

/// Seeds of a recording: what belongs to the camera and what to the moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seeds {
    /// Fixed pattern: mismatch, leakage, hot pixels.
    pub camera: u64,
    /// Everything that differs between two recordings of one camera.
    pub run: u64,
}

/// The events of one pixel under `log_light(t)`, the natural logarithm of light (0 at white), up
/// to `duration_s`. The amplifier is balanced at t = 0.
///
/// Background, readout and clock are not part of the pixel.
pub fn pixel_spikes(
    circuit: &Circuit,
    seeds: Seeds,
    pixel: u32,
    duration_s: f64,
    log_light: impl Fn(f64) -> f64,
) -> Vec<Spike> {
    walk::Walker::new(circuit, seeds, pixel, log_light).run(duration_s)
}

/// Instants and polarities at which photon noise may fire the comparators: a Poisson process at the
/// dark rate, of which light keeps a share.
#[derive(Debug, Clone)]
struct PhotonEvents {
    stream: Stream,
    dark_rate_hz: f64,
    half_share: f64,
    index: u64,
    next_s: f64,
}

impl PhotonEvents {
    fn new(circuit: &Circuit, run_seed: u64, pixel: u32) -> Option<Self> {
        let noise = circuit.detector.photon_noise?;
        let mut events = Self {
            stream: Stream::new(run_seed, Purpose::Photon, u64::from(pixel)),
            dark_rate_hz: noise.dark_rate_hz,
            half_share: noise.half_current_a / circuit.photoreceptor.white_current_a,
            index: 0,
            next_s: 0.0,
        };
        events.wait();
        Some(events)
    }

    fn wait(&mut self) {
        self.next_s += self.stream.exponential(3 * self.index) / self.dark_rate_hz;
    }

    /// The event at `next_s` in this light, if light lets it pass; goes on to the next instant.
    fn take(&mut self, log_current: f64) -> Option<bool> {
        let passes = self.half_share / (self.half_share + log_current.exp());
        let kept = self.stream.uniform(3 * self.index + 1) < passes;
        let on = self.stream.uniform(3 * self.index + 2) < 0.5;
        self.index += 1;
        self.wait();
        kept.then_some(on)
    }
}
