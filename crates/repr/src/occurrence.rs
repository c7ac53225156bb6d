//! EOI, the event occurrence image: which pixels fired.
//!
//! # Model
//! 1 where a pixel fired with that polarity within the window, 0 elsewhere.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Eq. 1.

use crate::drawn::Drawn;
use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{FrameEvent, FrameWindow, Grey};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "eoi",
    summary: "whether a pixel fired, per polarity",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Channels,
    any_order_at_once: true,
    channels: |_| 2,
    start: |window, _| {
        Box::new(Drawn {
            state: LastTimes::new(window),
            channels: 2,
            grey: Grey::White(1.0),
            draw: |last, out| last.render(out, |left_us| if left_us > 0 { 1.0 } else { 0.0 }),
        })
    },
    fill: Some(fill_eoi),
};

/// Fills `out`, `[2][height][width]`, with the EOI of a window of frames.
///
/// # Panics
/// If `out` has another length or an event lies outside the sensor.
fn fill_eoi(window: &FrameWindow, events: &[FrameEvent], out: &mut [f32]) {
    let planes = window.planes::<2>(out);
    for &event in events {
        if window.shows(event.frame) {
            planes.values[planes.index(event)] = 1.0;
        }
    }
}
