//! PIM, the polarity-integrated image: brightness gained and lost, fading.
//!
//! # Model
//! An ON event adds 1 to its pixel, an OFF event takes 1; in between, values fade to
//! `v·exp(-rate·dt)`. The published programs fade the whole image when it is looked at; here an
//! event counts `exp(rate·(t - t0))` instead, for some `t0`, and the whole is multiplied by
//! `exp(-rate·(now - t0))` when it is looked at, which differs in rounding only.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, class `PIM` in Python and C++. Its C++ takes polarity bits of the YARP encoding, in
//! which 1 is OFF, and its `alpha` is our rate.

use evpose_core::{EventStream, Micros, NumberSpec, Parameter, SensorSize};

use crate::clock::StreamClock;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "pim",
    summary: "ON minus OFF events of a pixel, fading",
    parameters: &[Parameter::Number(NumberSpec {
        name: "rate",
        unit: "1/s",
        doc: "how fast values fade",
        range: (0.0, 1e6),
        default: Some(PimConfig::PUBLISHED.rate_hz),
        ..NumberSpec::LINEAR
    })],
    memory: Memory::Own,
    polarity: PolarityUse::Sign,
    // Sums are rounded.
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| {
        Box::new(Pim::new(window.sensor, PimConfig { rate_hz: values.number("rate") }))
    },
    fill: None,
};

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
    /// Sums of weights of events, ON less OFF.
    sums: Vec<f64>,
    /// When an event weighs 1.
    origin: Option<Micros>,
    clock: StreamClock,
}

/// Logarithm of the largest weight: far from what overflows, and what weighs 1 beside it is
/// nothing.
const HEAVIEST: f64 = 300.0;

impl Pim {
    /// An image without events.
    pub fn new(sensor: SensorSize, config: PimConfig) -> Self {
        let sums = vec![0.0; sensor.pixels()];
        Self { sensor, config, sums, origin: None, clock: StreamClock::default() }
    }

    /// How much an event counts.
    fn weight(&mut self, t: Micros) -> f64 {
        let origin = *self.origin.get_or_insert(t);
        let logarithm = self.fading(origin, t);
        if logarithm <= HEAVIEST {
            return logarithm.exp();
        }
        let faded = (-logarithm).exp();
        self.sums.iter_mut().for_each(|sum| *sum *= faded);
        self.origin = Some(t);
        1.0
    }

    /// By how much values fade from one time to another, as a logarithm.
    fn fading(&self, from: Micros, to: Micros) -> f64 {
        self.config.rate_hz * to.0.saturating_sub(from.0) as f64 * 1e-6
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
        // Many events have the time of the one before.
        let (mut t_before, mut weight) = (None, 0.0);
        for event in events.iter() {
            if t_before != Some(event.t) {
                (t_before, weight) = (Some(event.t), self.weight(event.t));
            }
            let step = if event.polarity.is_on() { weight } else { -weight };
            self.sums[usize::from(event.y) * width + usize::from(event.x)] += step;
        }
        if let Some(&last) = events.t().last() {
            self.clock.observe(last);
        }
    }

    fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.sums.len(), "planes of another size");
        let (now, origin) = (self.clock.now.unwrap_or_default(), self.origin.unwrap_or_default());
        let faded = (-self.fading(origin, now)).exp();
        for (out, sum) in out.iter_mut().zip(&self.sums) {
            *out = (sum * faded) as f32;
        }
    }

    fn grey(&self) -> Grey {
        Grey::Signed
    }

    fn reset(&mut self) {
        self.sums.fill(0.0);
        self.origin = None;
        self.clock = StreamClock::default();
    }
}

#[cfg(test)]
mod tests {
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

    /// An hour of events at intervals in which a value fades to 1 / e: 1 + 1/e + 1/e² + …
    #[test]
    fn weights_never_overflow() {
        let mut pim = Pim::new(SENSOR, PimConfig { rate_hz: 1.0 });
        let every_s =
            |s: i64| Event { t: Micros(1_000_000 * s), x: 1, y: 0, polarity: Polarity::On };
        pim.push(&EventStream::from_events(SENSOR, (0..3600).map(every_s)).unwrap());
        let mut out = [f32::NAN; 2];
        pim.render(&mut out);
        let want = 1.0 / (1.0 - (-1f64).exp());
        assert!(out[0] == 0.0 && (f64::from(out[1]) - want).abs() < 1e-6, "{out:?}");
    }
}
