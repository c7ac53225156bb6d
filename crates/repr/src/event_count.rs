//! The event-count image: how often each pixel fired, in grey values.
//!
//! # Model
//! The number of a pixel's events within the window, whatever their polarity, scaled so that three
//! standard deviations of the pixels that fired are 255, without fraction.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, `createCountImage` and `varianceNormalisation`. There, counters of 8 bits wrap, and
//! columns are taken for rows; neither is imitated.

use evpose_core::{EventStream, Micros};

use crate::counts::Counts;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::three_sigma::{three_sigma_scale, write_scaled};
use crate::{Counting, Grey, Representation, StreamWindow};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "event-count",
    summary: "how often a pixel fired; three deviations are 255, fractions dropped",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Ignored,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| Box::new(EventCount::new(window)),
    fill: None,
};

/// The event-count image of a stream.
#[derive(Debug, Clone)]
pub struct EventCount {
    counts: Counts,
}

impl EventCount {
    /// An image without events.
    pub fn new(window: StreamWindow) -> Self {
        Self { counts: Counts::new(window, Counting::EveryEvent) }
    }
}

impl Representation for EventCount {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        self.counts.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.counts.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(2 * out.len(), self.counts.per_polarity().len(), "planes of another size");
        let scale = three_sigma_scale(self.counts.per_pixel());
        write_scaled(out, self.counts.per_pixel(), scale, f64::trunc);
    }

    fn grey(&self) -> Grey {
        Grey::White(255.0)
    }

    fn reset(&mut self) {
        self.counts.reset();
    }
}
