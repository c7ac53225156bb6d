//! SAE, the surface of active events: when each pixel last fired.
//!
//! # Model
//! Per pixel, whatever the polarity, the time of its latest event: [`Sae::times`] in microseconds,
//! exact; rendered in seconds from a microsecond before the first event, 0 where there was none. In 32
//! bits, times differ by a microsecond up to 8 s, by a millisecond up to 2 h.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! Benosman et al., *Event-Based Visual Flow*, TNNLS 2014; hpe-core, class `SAE`.

use evpose_core::{EventStream, Micros, SensorSize};
use evpose_cpu::vectorize;

use crate::clock::StreamClock;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "sae",
    summary: "when a pixel last fired, in seconds",
    parameters: &[],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| Box::new(Sae::new(window.sensor)),
    fill: None,
};

/// The SAE of a stream. It has no window.
#[derive(Debug, Clone)]
pub struct Sae {
    sensor: SensorSize,
    /// [`NEVER`] where there was none.
    last: Vec<Micros>,
    /// The time that rendered times count from.
    origin: Option<Micros>,
    clock: StreamClock,
}

const NEVER: Micros = Micros(i64::MIN);

impl Sae {
    /// An SAE without events.
    pub fn new(sensor: SensorSize) -> Self {
        let last = vec![NEVER; sensor.pixels()];
        Self { sensor, last, origin: None, clock: StreamClock::default() }
    }

    /// When each pixel last fired, row by row; none where it never did.
    pub fn times(&self) -> impl ExactSizeIterator<Item = Option<Micros>> + '_ {
        self.last.iter().map(|&t| Some(t).filter(|&t| t != NEVER))
    }
}

impl Representation for Sae {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        if events.t().first().is_some_and(|&first| self.clock.jumps_back(first)) {
            self.reset();
        }
        if let Some(first) = events.t().first() {
            // A microsecond, so that the first event is none that never was.
            self.origin.get_or_insert(Micros(first.0.saturating_sub(1)));
        }
        let width = usize::from(self.sensor.width);
        for ((&t, &x), &y) in events.t().iter().zip(events.x()).zip(events.y()) {
            self.last[usize::from(y) * width + usize::from(x)] = t;
        }
        if let Some(&last) = events.t().last() {
            self.clock.observe(last);
        }
    }

    fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.last.len(), "planes of another size");
        let (last, origin) = (self.last.as_slice(), self.origin.unwrap_or_default());
        vectorize(
            #[inline(always)]
            move || {
                for (out, &t) in out.iter_mut().zip(last) {
                    *out = match t {
                        NEVER => 0.0,
                        t => Micros(t.0.saturating_sub(origin.0)).as_seconds() as f32,
                    };
                }
            },
        );
    }

    fn grey(&self) -> Grey {
        Grey::Largest
    }

    fn reset(&mut self) {
        self.last.fill(NEVER);
        self.origin = None;
        self.clock = StreamClock::default();
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    #[test]
    fn the_latest_event_of_a_pixel_counts_whatever_its_polarity() {
        let sensor = SensorSize { width: 3, height: 1 };
        let event = |t_us, x, polarity| Event { t: Micros(t_us), x, y: 0, polarity };
        let events = [
            event(5, 0, Polarity::On),
            event(1_500_000, 2, Polarity::On),
            event(2_000_001, 0, Polarity::Off),
        ];
        let mut sae = Sae::new(sensor);
        sae.push(&EventStream::from_events(sensor, events).unwrap());
        let want = [Some(Micros(2_000_001)), None, Some(Micros(1_500_000))];
        assert!(sae.times().eq(want));
        let mut out = [f32::NAN; 3];
        sae.render(&mut out);
        assert_eq!(out, [1.999_997, 0.0, 1.499_996]);
    }

    #[test]
    fn a_clock_of_the_calendar_costs_no_precision() {
        let sensor = SensorSize { width: 2, height: 1 };
        let first = 1_605_537_536_000_000;
        let event = |t, x| Event { t: Micros(t), x, y: 0, polarity: Polarity::On };
        let mut sae = Sae::new(sensor);
        let events = [event(first, 0), event(first + 10, 1)];
        sae.push(&EventStream::from_events(sensor, events).unwrap());
        let mut out = [0.0; 2];
        sae.render(&mut out);
        assert_eq!(out, [1e-6, 1.1e-5]);
    }
}
