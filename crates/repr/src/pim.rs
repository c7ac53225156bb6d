//! PIM, the polarity-integrated image: brightness gained and lost, fading.
//!
//! # Model
//! An ON event adds 1 to its pixel, an OFF event takes 1; in between, values fade to
//! `v·exp(-rate·dt)`. The published programs fade the whole image when it is looked at; here each pixel
//! knows when it was last written, which differs in rounding only.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, class `PIM` in Python and C++. Its C++ takes polarity bits of the YARP encoding, in which
//! 1 is OFF, and its `alpha` is our rate.

use evpose_core::{EventStream, Micros, SensorSize};

use crate::clock::Clock;
use crate::{Grey, Representation};

/// How a PIM fades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PimConfig {
    /// Fading, in 1/s.
    pub rate_hz: f64,
}

impl PimConfig {
    /// The published class.
    pub const PUBLISHED: Self = Self { rate_hz: 1.0 };
}

impl Default for PimConfig {
    fn default() -> Self {
        Self::PUBLISHED
    }
}

/// The PIM of a stream. It has a memory of its own and no window.
#[derive(Debug, Clone)]
pub struct Pim {
    sensor: SensorSize,
    config: PimConfig,
    pixels: Vec<Pixel>,
    clock: Clock,
}

#[derive(Debug, Clone, Copy)]
struct Pixel {
    /// At `t`.
    value: f64,
    t: Micros,
}

/// As good as any time: nothing fades to nothing.
const EMPTY: Pixel = Pixel { value: 0.0, t: Micros(0) };

impl Pixel {
    fn at(self, now: Micros, rate_hz: f64) -> f64 {
        // Many pixels are empty, and events of one time need no exponential.
        if self.value == 0.0 || self.t == now {
            return self.value;
        }
        let age_s = now.0.saturating_sub(self.t.0) as f64 * 1e-6;
        self.value * (-rate_hz * age_s).exp()
    }
}

impl Pim {
    /// An image without events.
    pub fn new(sensor: SensorSize, config: PimConfig) -> Self {
        let pixels = vec![EMPTY; sensor.pixels()];
        Self { sensor, config, pixels, clock: Clock::default() }
    }
}

impl Representation for Pim {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        if events.t().first().is_some_and(|&first| self.clock.jumps_back(first)) {
            self.reset();
        }
        let width = usize::from(self.sensor.width);
        for event in events.iter() {
            let pixel = &mut self.pixels[usize::from(event.y) * width + usize::from(event.x)];
            let step = if event.polarity.is_on() { 1.0 } else { -1.0 };
            let value = pixel.at(event.t, self.config.rate_hz) + step;
            *pixel = Pixel { value, t: event.t };
        }
        if let Some(&last) = events.t().last() {
            self.clock.see(last);
        }
    }

    fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.pixels.len(), "planes of another size");
        let now = self.clock.now.unwrap_or_default();
        for (out, pixel) in out.iter_mut().zip(&self.pixels) {
            *out = pixel.at(now, self.config.rate_hz) as f32;
        }
    }

    fn grey(&self) -> Grey {
        Grey::Signed
    }

    fn reset(&mut self) {
        self.pixels.fill(EMPTY);
        self.clock = Clock::default();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::{Event, Polarity};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 2, height: 1 };

    #[test]
    fn polarities_cancel_and_values_fade_by_e_in_a_time_constant() {
        let mut pim = Pim::new(SENSOR, PimConfig { rate_hz: 2.0 });
        let mut events = EventStream::empty(SENSOR);
        for (t_s, x, on) in [(0, 0, true), (0, 0, true), (0, 0, false), (0, 1, false)] {
            let event = Event { t: Micros(t_s), x, y: 0, polarity: Polarity::from_on(on) };
            events.push(event).unwrap();
        }
        pim.push(&events);
        let mut out = [f32::NAN; 2];
        pim.render(&mut out);
        assert_eq!(out, [1.0, -1.0]);
        pim.advance(Micros(500_000));
        pim.render(&mut out);
        assert_eq!(out, [(-1f64).exp() as f32, -(-1f64).exp() as f32]);
        let mut grey = [0; 2];
        pim.render_u8(&mut grey);
        assert_eq!(grey, [255, 0]);
        let later = EventStream::from_events(
            SENSOR,
            [Event { t: Micros(1_000_000), x: 0, y: 0, polarity: Polarity::On }],
        );
        pim.push(&later.unwrap());
        pim.render(&mut out);
        assert_eq!(out[0], ((-2f64).exp() + 1.0) as f32);
    }
}
