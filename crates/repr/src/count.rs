//! ECI and ECI-S, the event count images: how often each pixel fired.
//!
//! # Model
//! ECI is the number of events of a pixel and polarity within the window; ECI-S, in one channel,
//! their number whatever the polarity. [`Counting`] holds the published program's departures.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Eq. 2 and 3.

use std::collections::VecDeque;

use evpose_core::{EventStream, Micros};

use crate::clock::Clock;
use crate::{FrameEvent, FrameWindow, Representation, StreamWindow};

/// What an event adds.
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

/// Events of a sliding window, counted per pixel and polarity.
#[derive(Debug, Clone)]
struct Counts {
    window: StreamWindow,
    counting: Counting,
    /// `[2][height][width]`.
    counts: Vec<u32>,
    /// The counted events, by time, and where they count.
    queue: VecDeque<(Micros, u32)>,
    /// Frame in which each pixel and polarity was last counted; empty where every event counts.
    last_frame: Vec<i64>,
    clock: Clock,
}

const NO_FRAME: i64 = i64::MIN;

impl Counts {
    fn new(window: StreamWindow, counting: Counting) -> Self {
        let values = 2 * window.sensor.pixels();
        let last_frame = match counting {
            Counting::EveryEvent => Vec::new(),
            Counting::OncePerFrame => vec![NO_FRAME; values],
        };
        let (counts, queue) = (vec![0; values], VecDeque::new());
        Self { window, counting, counts, queue, last_frame, clock: Clock::default() }
    }

    fn push(&mut self, events: &EventStream) {
        self.window.check(events);
        if events.t().first().is_some_and(|&first| self.clock.jumps_back(first)) {
            self.reset();
        }
        for event in events.iter() {
            let channel = self.window.order.channel(event.polarity);
            let index = self.window.index(event.x, event.y, channel);
            if let Some(last) = self.last_frame.get_mut(index) {
                let frame = event.t.0.div_euclid(Micros::MILLISECOND.0);
                if std::mem::replace(last, frame) == frame {
                    continue;
                }
            }
            self.counts[index] += 1;
            // Two planes of at most 2^32 pixels each: sensors are 65535 wide and high at most.
            self.queue.push_back((event.t, index as u32));
        }
        if let Some(&last) = events.t().last() {
            self.clock.see(last);
            self.expire();
        }
    }

    fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
        self.expire();
    }

    fn expire(&mut self) {
        let Some(now) = self.clock.now else { return };
        let oldest = Micros(now.0.saturating_sub(self.window.length_us.into()));
        while let Some((_, index)) = self.queue.pop_front_if(|&mut (t, _)| t <= oldest) {
            self.counts[index as usize] -= 1;
        }
    }

    fn reset(&mut self) {
        self.counts.fill(0);
        self.queue.clear();
        self.last_frame.fill(NO_FRAME);
        self.clock = Clock::default();
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
        assert_eq!(out.len(), self.counts.counts.len(), "planes of another size");
        let weight = self.counts.counting.weight();
        for (out, &count) in out.iter_mut().zip(&self.counts.counts) {
            *out = count as f32 * weight;
        }
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
        match self.counts.counting {
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
        let pixels = self.counts.window.sensor.pixels();
        assert_eq!(out.len(), self.channels() * pixels, "planes of another size");
        let weight = self.counts.counting.weight();
        let (first, second) = self.counts.counts.split_at(pixels);
        for plane in out.chunks_exact_mut(pixels) {
            for (out, (&a, &b)) in plane.iter_mut().zip(first.iter().zip(second)) {
                *out = (a + b) as f32 * weight;
            }
        }
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
