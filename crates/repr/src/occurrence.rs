//! EOI, the event occurrence image: which pixels fired.
//!
//! # Model
//! 1 where a pixel fired with that polarity within the window, 0 elsewhere.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Eq. 1.

use evpose_core::{EventStream, Micros};

use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{FrameEvent, FrameWindow, Grey, Representation, StreamWindow};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "eoi",
    summary: "whether a pixel fired, per polarity",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Channels,
    any_order_at_once: true,
    channels: |_| 2,
    start: |window, _| Box::new(Eoi::new(window)),
    fill: Some(|window, events, out| fill_eoi(window, events.iter().copied(), out)),
};

/// The EOI of a stream.
#[derive(Debug, Clone)]
pub struct Eoi {
    last_times: LastTimes,
}

impl Eoi {
    /// An image without events.
    pub fn new(window: StreamWindow) -> Self {
        Self { last_times: LastTimes::new(window) }
    }
}

impl Representation for Eoi {
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
        self.last_times.render(out, |left_us| if left_us > 0 { 1.0 } else { 0.0 });
    }

    fn grey(&self) -> Grey {
        Grey::White(1.0)
    }

    fn reset(&mut self) {
        self.last_times.reset();
    }
}

/// Fills `out`, `[2][height][width]`, with the EOI of a window of frames.
///
/// # Panics
/// If `out` has another length or an event lies outside the sensor.
pub fn fill_eoi(
    window: &FrameWindow,
    events: impl IntoIterator<Item = FrameEvent>,
    out: &mut [f32],
) {
    let planes = window.planes::<2>(out);
    for event in events {
        if window.shows(event.frame) {
            planes.values[planes.index(event)] = 1.0;
        }
    }
}
