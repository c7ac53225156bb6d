//! The fixed-count image: a fixed number of the latest events, in grey values.
//!
//! # Model
//! The number of a pixel's events among the last `n`, whatever their polarity, scaled so that three
//! standard deviations of the pixels that fired are 255; fractions are kept.
//!
//! The published data sets pair the image with a pose that is `offset` events old when the image is
//! complete, so that it lies about in the middle: that is up to who pairs them.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, class `eventFrame` and the scripts that export it; Calabrese et al., *DHP19*, CVPRW
//! 2019, for the scale and for n = 7500.

use std::collections::VecDeque;

use evpose_core::{EventStream, Micros, NumberKind, NumberSpec, Parameter, SensorSize};

use crate::clock::StreamClock;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::three_sigma::{three_sigma_scale, write_scaled};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "fixed-count",
    summary: "how often a pixel fired among the latest events; three deviations are 255",
    parameters: &[Parameter::Number(NumberSpec {
        name: "n",
        unit: "events",
        doc: "how many events an image shows",
        kind: NumberKind::Whole,
        range: (1.0, 1e9),
        default: Some(FixedCountConfig::PUBLISHED.events as f64),
        ..NumberSpec::LINEAR
    })],
    memory: Memory::Count,
    polarity: PolarityUse::Ignored,
    // Which of them are the latest.
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| {
        let config = FixedCountConfig { events: values.whole("n") };
        Box::new(FixedCount::new(window.sensor, config))
    },
    fill: None,
};

/// Events of a fixed-count image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FixedCountConfig {
    /// Number of events.
    pub events: u32,
}

impl FixedCountConfig {
    /// The published data sets.
    pub const PUBLISHED: Self = Self { events: 7_500 };
}

impl Default for FixedCountConfig {
    fn default() -> Self {
        Self::PUBLISHED
    }
}

/// The fixed-count image of a stream: of its latest events. It has no window.
#[derive(Debug, Clone)]
pub struct FixedCount {
    sensor: SensorSize,
    max_events: usize,
    counts: Vec<u32>,
    /// Pixel indices of the last events, the oldest first.
    last: VecDeque<u32>,
    clock: StreamClock,
}

impl FixedCount {
    /// An image without events.
    pub fn new(sensor: SensorSize, config: FixedCountConfig) -> Self {
        let (max_events, counts) = (config.events as usize, vec![0; sensor.pixels()]);
        Self { sensor, max_events, counts, last: VecDeque::new(), clock: StreamClock::default() }
    }
}

impl Representation for FixedCount {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else { return };
        if self.clock.jumps_back(first) {
            self.reset();
        }
        self.clock.observe(last);
        // Events that later ones of the same call push out are not counted at all.
        let shown = events.len().saturating_sub(self.max_events);
        // The oldest go: those that exceed `max_events` together with the new ones.
        let gone = (self.last.len() + events.len() - shown).saturating_sub(self.max_events);
        for index in self.last.drain(..gone) {
            self.counts[index as usize] -= 1;
        }
        let width = u32::from(self.sensor.width);
        let places = events.x()[shown..].iter().zip(&events.y()[shown..]);
        let counts = &mut self.counts;
        self.last.extend(places.map(|(&x, &y)| {
            let index = u32::from(y) * width + u32::from(x);
            counts[index as usize] += 1;
            index
        }));
    }

    fn advance(&mut self, _: Micros) {}

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.counts.len(), "planes of another size");
        let scale = three_sigma_scale(self.counts.iter().copied());
        write_scaled(out, self.counts.iter().copied(), scale, |grey| grey);
    }

    fn grey(&self) -> Grey {
        Grey::White(255.0)
    }

    fn reset(&mut self) {
        self.counts.fill(0);
        self.last.clear();
        self.clock = StreamClock::default();
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    #[test]
    fn only_the_latest_events_count() {
        let sensor = SensorSize { width: 3, height: 1 };
        let config = FixedCountConfig { events: 3 };
        let mut image = FixedCount::new(sensor, config);
        for (t, x) in [0, 0, 0, 0, 1, 2, 1].into_iter().enumerate() {
            let event = Event { t: Micros(t as i64), x, y: 0, polarity: Polarity::Off };
            image.push(&EventStream::from_events(sensor, [event]).unwrap());
        }
        assert_eq!(image.counts, [0, 2, 1]);
    }
}
