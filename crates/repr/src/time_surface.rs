//! The time surface: how recently each pixel fired, fading exponentially.
//!
//! # Model
//! Per pixel and polarity, with `t_last` the time of its latest event: `exp(-(t_now - t_last)/τ)`,
//! 1 for an event that happens now, 0 where there was none. Windows are ignored: what is older than
//! some τ is gone anyway (and what is older than 18 minutes is dropped). A value is the nearest `f32`
//! or the one next to it.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! Lagorce et al., *HOTS*, TPAMI 2017, Eq. 3, for the whole plane at one time. No time constant is
//! common to the literature; 30 ms is ours.

use evpose_core::{EventStream, Micros, NumberSpec, Parameter};

use crate::fade::Fade;
use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation, StreamWindow};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "time-surface",
    summary: "how recently a pixel fired, per polarity, fading exponentially",
    parameters: &[Parameter::Number(NumberSpec {
        name: "tau_ms",
        unit: "ms",
        doc: "time constant",
        range: (1e-3, 1e6),
        default: Some(TimeSurfaceConfig::DEFAULT.tau_ms),
        ..NumberSpec::LINEAR
    })],
    memory: Memory::Own,
    polarity: PolarityUse::Channels,
    any_order_at_once: true,
    channels: |_| 2,
    start: |window, values| {
        let config = TimeSurfaceConfig { tau_ms: values.number("tau_ms") };
        Box::new(TimeSurface::new(window, config))
    },
    fill: None,
};

/// How a time surface fades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSurfaceConfig {
    /// The time constant, in milliseconds.
    pub tau_ms: f64,
}

impl TimeSurfaceConfig {
    /// 30 ms.
    pub const DEFAULT: Self = Self { tau_ms: 30.0 };
}

impl Default for TimeSurfaceConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The time surface of a stream.
#[derive(Debug, Clone)]
pub struct TimeSurface {
    last_times: LastTimes,
    fade: Fade,
}

impl TimeSurface {
    /// A time surface without events. The length of `window` is ignored.
    ///
    /// # Panics
    /// If the time constant is not above 0.
    pub fn new(window: StreamWindow, config: TimeSurfaceConfig) -> Self {
        assert!(config.tau_ms > 0.0, "a time constant of {} ms", config.tau_ms);
        Self { last_times: LastTimes::new(window.longest()), fade: Fade::new(config.tau_ms * 1e3) }
    }
}

impl Representation for TimeSurface {
    fn channels(&self) -> usize {
        2
    }

    fn push(&mut self, events: &EventStream) {
        self.last_times.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.last_times.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        let (length_us, fade) = (self.last_times.length_us(), self.fade);
        self.last_times.render(
            out,
            #[inline(always)]
            move |left_us| {
                // A product, not a branch: no vector takes both ways of one.
                let is_shown = f32::from(u8::from(left_us > 0));
                is_shown * fade.after(length_us - left_us)
            },
        );
    }

    fn grey(&self) -> Grey {
        Grey::White(1.0)
    }

    fn reset(&mut self) {
        self.last_times.reset();
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity, SensorSize};

    use super::*;
    use crate::ChannelOrder;

    #[test]
    fn a_value_is_a_tenth_after_2_3_time_constants_whatever_the_window() {
        let sensor = SensorSize { width: 2, height: 1 };
        let window = StreamWindow::new(sensor, Micros(1), ChannelOrder::OnFirst).unwrap();
        let mut representation = TimeSurface::new(window, TimeSurfaceConfig { tau_ms: 10.0 });
        let events = [(0, 0), (23_026, 1)];
        let events = events.map(|(t, x)| Event { t: Micros(t), x, y: 0, polarity: Polarity::On });
        representation.push(&EventStream::from_events(sensor, events).unwrap());
        let mut out = [f32::NAN; 4];
        representation.render(&mut out);
        assert!((out[0] - 0.1).abs() < 2e-6, "{out:?}");
        assert_eq!(out[1..], [1.0, 0.0, 0.0]);
    }
}
