//! ECI and ECI-S, the event count images: how often each pixel fired.
//!
//! # Model
//! ECI is the number of events of a pixel and polarity within the window; ECI-S, in one channel,
//! their number whatever the polarity. [`Counting`] holds the published program's departures.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Eq. 2 and 3.

use evpose_core::{EventStream, Micros};

use crate::counts::Counts;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{FrameEvent, FrameWindow, Grey, Representation, StreamWindow};

pub(crate) static ECI: RepresentationSpec =
    spec::<false, false>("eci", "how often a pixel fired, per polarity");
pub(crate) static ECI_S: RepresentationSpec =
    spec::<true, false>("eci-s", "how often a pixel fired");
pub(crate) static ECI_PARITY: RepresentationSpec = spec::<false, true>(
    "eci-parity",
    "eci as the published program computes it: 0.01 per millisecond that fired",
);
pub(crate) static ECI_S_PARITY: RepresentationSpec = spec::<true, true>(
    "eci-s-parity",
    "eci-s as the published program computes it: two equal channels",
);

/// ECI or ECI-S, by its definition or with the departures of the published program.
const fn spec<const IS_S: bool, const IS_PARITY: bool>(
    name: &'static str,
    summary: &'static str,
) -> RepresentationSpec {
    RepresentationSpec {
        name,
        summary,
        parameters: &[],
        memory: Memory::Window,
        polarity: if IS_S { PolarityUse::Ignored } else { PolarityUse::Channels },
        any_order_at_once: true,
        channels: |_| if IS_S && !IS_PARITY { 1 } else { 2 },
        start: |window, _| match IS_S {
            true => Box::new(EciS::new(window, counting(IS_PARITY))),
            false => Box::new(Eci::new(window, counting(IS_PARITY))),
        },
        fill: Some(|window, events, out| match IS_S {
            true => fill_eci_s(window, counting(IS_PARITY), events.iter().copied(), out),
            false => fill_eci(window, counting(IS_PARITY), events.iter().copied(), out),
        }),
    }
}

fn counting(is_parity: bool) -> Counting {
    if is_parity { Counting::OncePerFrame } else { Counting::EveryEvent }
}

/// Contribution of an event to a count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Counting {
    /// Every event counts 1: the definition.
    #[default]
    EveryEvent,
    /// As the published program: a pixel and polarity counts at most once per frame of 1 ms, and
    /// counts 0.01 whatever the length of the window; ECI-S comes as two equal channels.
    OncePerFrame,
}

impl Counting {
    fn weight(self) -> f32 {
        match self {
            Self::EveryEvent => 1.0,
            Self::OncePerFrame => 0.01,
        }
    }
}

/// The ECI of a stream.
#[derive(Debug, Clone)]
pub struct Eci {
    counts: Counts,
}

impl Eci {
    /// An image without events.
    pub fn new(window: StreamWindow, counting: Counting) -> Self {
        Self { counts: Counts::new(window, counting) }
    }
}

impl Representation for Eci {
    fn channels(&self) -> usize {
        2
    }

    fn push(&mut self, events: &EventStream) {
        self.counts.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.counts.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.counts.per_polarity().len(), "planes of another size");
        let weight = self.counts.counting().weight();
        for (out, &count) in out.iter_mut().zip(self.counts.per_polarity()) {
            *out = count as f32 * weight;
        }
    }

    fn grey(&self) -> Grey {
        Grey::Largest
    }

    fn reset(&mut self) {
        self.counts.reset();
    }
}

/// The ECI-S of a stream.
#[derive(Debug, Clone)]
pub struct EciS {
    counts: Counts,
}

impl EciS {
    /// An image without events.
    pub fn new(window: StreamWindow, counting: Counting) -> Self {
        Self { counts: Counts::new(window, counting) }
    }
}

impl Representation for EciS {
    fn channels(&self) -> usize {
        match self.counts.counting() {
            Counting::EveryEvent => 1,
            Counting::OncePerFrame => 2,
        }
    }

    fn push(&mut self, events: &EventStream) {
        self.counts.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.counts.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        let pixels = self.counts.per_polarity().len() / 2;
        assert_eq!(out.len(), self.channels() * pixels, "planes of another size");
        let weight = self.counts.counting().weight();
        for plane in out.chunks_exact_mut(pixels.max(1)) {
            for (out, count) in plane.iter_mut().zip(self.counts.per_pixel()) {
                *out = count as f32 * weight;
            }
        }
    }

    fn grey(&self) -> Grey {
        Grey::Largest
    }

    fn reset(&mut self) {
        self.counts.reset();
    }
}

/// Fills `out`, `[2][height][width]`, with the ECI of a window of frames.
///
/// `events` ascend in `frame`.
///
/// # Panics
/// If `out` has another length or an event lies outside the sensor.
pub fn fill_eci(
    window: &FrameWindow,
    counting: Counting,
    events: impl IntoIterator<Item = FrameEvent>,
    out: &mut [f32],
) {
    count::<2>(window, counting, events, out);
    weigh(counting, out);
}

/// Fills `out` with the ECI-S of a window of frames: `[1][height][width]`, or two equal channels
/// with [`Counting::OncePerFrame`].
///
/// `events` ascend in `frame`.
///
/// # Panics
/// If `out` has another length or an event lies outside the sensor.
pub fn fill_eci_s(
    window: &FrameWindow,
    counting: Counting,
    events: impl IntoIterator<Item = FrameEvent>,
    out: &mut [f32],
) {
    match counting {
        Counting::EveryEvent => count::<1>(window, counting, events, out),
        Counting::OncePerFrame => {
            count::<2>(window, counting, events, out);
            // Polarities were counted apart, since a pixel counts once per frame and polarity.
            let (first, second) = out.split_at_mut(window.sensor.pixels());
            for (a, b) in first.iter_mut().zip(second) {
                *a += *b;
                *b = *a;
            }
        }
    }
    weigh(counting, out);
}

fn count<const CHANNELS: usize>(
    window: &FrameWindow,
    counting: Counting,
    events: impl IntoIterator<Item = FrameEvent>,
    out: &mut [f32],
) {
    let planes = window.planes::<CHANNELS>(out);
    // One past the frame in which each pixel was last counted.
    let mut counted = match counting {
        Counting::EveryEvent => Vec::new(),
        Counting::OncePerFrame => vec![0; planes.values.len()],
    };
    for event in events {
        if !window.shows(event.frame) {
            continue;
        }
        let index = planes.index(event);
        if let Some(last) = counted.get_mut(index)
            && std::mem::replace(last, event.frame + 1) == event.frame + 1
        {
            continue;
        }
        planes.values[index] += 1.0;
    }
}

/// Once, after counting: sums of 0.01 would round at every step.
fn weigh(counting: Counting, out: &mut [f32]) {
    let weight = counting.weight();
    out.iter_mut().for_each(|value| *value *= weight);
}

#[cfg(test)]
mod tests;
