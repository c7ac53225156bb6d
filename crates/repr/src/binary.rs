//! The binary image: which pixels fired, whatever the polarity.
//!
//! # Model
//! 255 where a pixel fired within the window, 0 elsewhere.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, class `BIN` (event-driven's has 1 for 255), which is cleared by its user instead.

use evpose_core::{EventStream, Micros};

use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation, StreamWindow};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "binary",
    summary: "255 where a pixel fired",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Ignored,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| Box::new(Binary::new(window)),
    fill: None,
};

/// The binary image of a stream.
#[derive(Debug, Clone)]
pub struct Binary {
    last_times: LastTimes,
}

const PEAK: f32 = 255.0;

impl Binary {
    /// An image without events.
    pub fn new(window: StreamWindow) -> Self {
        Self { last_times: LastTimes::new(window) }
    }
}

impl Representation for Binary {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        self.last_times.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.last_times.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        self.last_times.render_joined(out, |left_us| if left_us > 0 { PEAK } else { 0.0 });
    }

    fn grey(&self) -> Grey {
        Grey::White(PEAK)
    }

    fn reset(&mut self) {
        self.last_times.reset();
    }
}
