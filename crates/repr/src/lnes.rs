//! LNES (locally normalised event surfaces): how recently each pixel fired.
//!
//! # Model
//! Per pixel and polarity, with `t_last` the time of its latest event in a window of length `T`
//! that ends now: `LNES = (t_last - (t_now - T)) / T`, 0 for the oldest event and 1 for one that
//! happens now; 0 where there was none.
//!
//! The windowed form counts in frames: an event of frame `i` of `W` gives `i / W`, so that the
//! oldest frame is invisible and the newest is `(W - 1) / W`. With the events of frame `k` at
//! `k` ms, the two are bitwise equal when the stream is rendered one frame after the newest, at
//! `t_now = (n + 1)` ms for the window that ends with frame `n`; at `n` ms the stream gives
//! `(i + 1) / W`.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, Sec. 3; supplement, Sec. 1.2.

use evpose_core::{EventStream, Micros};

use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{FrameEvent, FrameWindow, Grey, Representation, StreamWindow};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "lnes",
    summary: "how recently a pixel fired, per polarity",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Channels,
    any_order_at_once: true,
    channels: |_| 2,
    start: |window, _| Box::new(Lnes::new(window)),
    fill: Some(|window, events, out| fill_lnes(window, events.iter().copied(), out)),
};

/// The LNES of a stream, in continuous time.
#[derive(Debug, Clone)]
pub struct Lnes {
    last_times: LastTimes,
}

impl Lnes {
    /// An LNES without events.
    pub fn new(window: StreamWindow) -> Self {
        Self { last_times: LastTimes::new(window) }
    }
}

impl Representation for Lnes {
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
        let length = self.last_times.length_us() as f32;
        let inverse = 1.0 / length;
        if !fuses() {
            return self.last_times.render(out, move |left_us| left_us as f32 / length);
        }
        self.last_times.render(
            out,
            #[inline(always)]
            move |left_us| {
                // The quotient, a remainder that is exact, and the quotient that is nearest: three
                // operations where vectors divide in sixteen (Markstein, IBM J. Res. Dev. 1990).
                let left = left_us as f32;
                let quotient = left * inverse;
                let rest = (-quotient).mul_add(length, left);
                rest.mul_add(inverse, quotient)
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

/// Whether the processor multiplies and adds at once.
fn fuses() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    cfg!(target_arch = "aarch64")
}

/// Fills `out`, `[2][height][width]`, with the LNES of a window of frames.
///
/// `events` ascend in `frame`; inside a frame their order does not matter.
///
/// # Panics
/// If `out` has another length or an event lies outside the sensor.
pub fn fill_lnes(
    window: &FrameWindow,
    events: impl IntoIterator<Item = FrameEvent>,
    out: &mut [f32],
) {
    let planes = window.planes::<2>(out);
    let frames = window.frames as f32;
    for event in events {
        if window.shows(event.frame) {
            // Later frames overwrite earlier ones: the last event wins.
            planes.values[planes.index(event)] = event.frame as f32 / frames;
        }
    }
}

#[cfg(test)]
mod tests;
