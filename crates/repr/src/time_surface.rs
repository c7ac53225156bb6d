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

use crate::drawn::PixelState;
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
        default: Some(30.0),
        ..NumberSpec::LINEAR
    })],
    memory: Memory::Own,
    polarity: PolarityUse::Channels,
    any_order_at_once: true,
    channels: |_| 2,
    start: |window, values| Box::new(TimeSurface::new(window, values.number("tau_ms"))),
    fill: None,
};

#[derive(Debug)]
struct TimeSurface {
    last_times: LastTimes,
    fade: Fade,
}

impl TimeSurface {
    /// A time surface without events. The length of `window` is ignored.
    fn new(window: StreamWindow, tau_ms: f64) -> Self {
        assert!(tau_ms > 0.0, "a time constant of {tau_ms} ms");
        Self { last_times: LastTimes::new(window.longest()), fade: Fade::new(tau_ms * 1e3) }
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
        let mut representation = TimeSurface::new(window, 10.0);
        let events = [(0, 0), (23_026, 1)];
        let events = events.map(|(t, x)| Event { t: Micros(t), x, y: 0, polarity: Polarity::On });
        representation.push(&EventStream::from_events(sensor, events).unwrap());
        let mut out = [f32::NAN; 4];
        representation.render(&mut out);
        assert!((out[0] - 0.1).abs() < 2e-6, "{out:?}");
        assert_eq!(out[1..], [1.0, 0.0, 0.0]);
    }
}
