//! Events with the features of the scene at their pixel and time: the input of probes.

use std::ops::Range;

use evpose_core::{EventStream, SensorSize, TimeWindow};

use crate::{Cell, Classes, LightSequence};

/// A scene with its classes and reference events.
#[derive(Debug)]
pub struct ReferenceScene {
    /// Luminance over time.
    pub scene: LightSequence,
    /// Classes of every pixel and time.
    pub classes: Classes,
    /// Events of the reference: the sensor model without noise and delays.
    pub expected: Expected,
}

/// Sorted times of events, by pixel and polarity.
#[derive(Debug, Default)]
pub struct Expected {
    /// Start of list `2 pixel + polarity` in `t_us`.
    starts: Vec<usize>,
    t_us: Vec<i64>,
}

impl Expected {
    /// Sorts events into lists by pixel and polarity.
    pub fn from_events(events: &EventStream) -> Self {
        let lists = 2 * events.sensor().pixels();
        let list = |event: evpose_core::Event| {
            let pixel =
                usize::from(event.y) * usize::from(events.sensor().width) + usize::from(event.x);
            2 * pixel + usize::from(event.polarity.is_on())
        };
        // A counting sort: one array for all lists instead of two allocations a pixel.
        let mut starts = vec![0; lists + 1];
        for event in events.iter() {
            starts[list(event) + 1] += 1;
        }
        for i in 0..lists {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut t_us = vec![0; events.len()];
        for event in events.iter() {
            let slot = &mut next[list(event)];
            t_us[*slot] = event.t.0;
            *slot += 1;
        }
        Self { starts, t_us }
    }

    /// Number of events.
    pub fn events(&self) -> usize {
        self.t_us.len()
    }

    /// Times of the events of a pixel and a polarity, microseconds.
    pub fn times(&self, pixel: usize, is_on: bool) -> &[i64] {
        let list = 2 * pixel + usize::from(is_on);
        &self.t_us[self.starts[list]..self.starts[list + 1]]
    }

    fn cursors(&self) -> Cursors {
        Cursors(self.starts[..self.starts.len().saturating_sub(1)].to_vec())
    }

    /// Lag of `t_us` behind the nearest event of a list; positive if it is later. Calls must be in
    /// order of time, because `cursors` only move forward.
    fn lag_us(&self, cursors: &mut Cursors, pixel: usize, is_on: bool, t_us: i64) -> Option<i64> {
        let list = 2 * pixel + usize::from(is_on);
        let (Some(next), Some(&start)) = (cursors.0.get_mut(list), self.starts.get(list)) else {
            return None;
        };
        let end = self.starts[list + 1];
        while *next < end && self.t_us[*next] <= t_us {
            *next += 1;
        }
        let before = (*next > start).then(|| t_us - self.t_us[*next - 1]);
        let after = (*next < end).then(|| t_us - self.t_us[*next]);
        match (before, after) {
            // Of two equally near, the earlier one: cameras are late rather than early.
            (Some(b), Some(a)) => Some(if b <= -a { b } else { a }),
            (lag, None) | (None, lag) => lag,
        }
    }
}

/// Index of the next event of every list.
struct Cursors(Vec<usize>);

/// An event with the features that probes use. Small, because all probes iterate over all events.
#[derive(Debug, Clone, Copy)]
pub struct EventFeatures {
    /// Time, microseconds.
    pub t_us: i64,
    /// Index of the pixel, row by row.
    pub pixel: u32,
    /// Microseconds since the pixel's previous event, or [`NONE`].
    interval_us: i32,
    /// Lag behind the nearest reference event, microseconds, or [`NONE`].
    lag_us: i32,
    /// Change of log luminance since the pixel's previous event (or since the start), positive in
    /// the direction of this event: one threshold, for the ideal sensor.
    pub log_step: f32,
    /// Change of log luminance per second.
    pub slope: f32,
    /// Classes of the pixel at this time.
    pub cell: Cell,
    /// Polarity of the event, ON if true.
    pub is_on: bool,
    was_on: bool,
}

const NONE: i32 = i32::MIN;

/// Clips a time to 32 bits, about half an hour.
fn clipped(us: i64) -> i32 {
    us.clamp(i64::from(-i32::MAX), i64::from(i32::MAX)) as i32
}

impl EventFeatures {
    /// Interval since the previous event of the same pixel, microseconds, and whether that was ON.
    pub fn before(&self) -> Option<(i64, bool)> {
        (self.interval_us != NONE).then_some((i64::from(self.interval_us), self.was_on))
    }

    /// Lag behind the nearest reference event of the same pixel and polarity, microseconds.
    pub fn lag_us(&self) -> Option<i64> {
        (self.lag_us != NONE).then_some(i64::from(self.lag_us))
    }
}

/// The events of a window of a recording, with their features.
#[derive(Debug)]
pub struct View<'a> {
    /// Scene, classes and reference events.
    pub reference_scene: &'a ReferenceScene,
    /// Time window of the compared events.
    pub window: TimeWindow,
    events: Vec<EventFeatures>,
    range: Range<usize>,
}

impl<'a> View<'a> {
    /// Computes the features of all events. Events before the window count as previous events.
    pub fn new(
        reference_scene: &'a ReferenceScene,
        events: &EventStream,
        window: TimeWindow,
    ) -> Self {
        let size = reference_scene.scene.size();
        let width = usize::from(size.width);
        // Time, polarity and log luminance of the last event of every pixel.
        let mut last: Vec<Option<(i64, bool, f32)>> = vec![None; size.pixels()];
        let mut of_events = Vec::with_capacity(events.len());
        let classes = &reference_scene.classes;
        let mut cursors = reference_scene.expected.cursors();
        // In a loop of its own, since nearly every access to the scene waits for memory.
        let features = events.iter().map(|event| {
            let pixel = usize::from(event.y) * width + usize::from(event.x);
            let t_s = event.t.as_seconds();
            let (log, slope) = (classes.log_at(pixel, t_s), classes.slope_at(pixel, t_s));
            (pixel, log, slope, classes.cell(pixel, t_s))
        });
        let features: Vec<_> = features.collect();
        for (event, (pixel, log, slope, cell)) in events.iter().zip(features) {
            let (t_us, is_on) = (event.t.0, event.polarity.is_on());
            let before = last[pixel].replace((t_us, is_on, log));
            // Before its first event, a pixel remembers the beginning.
            let change = log - before.map_or_else(|| classes.log_at(pixel, 0.0), |(.., log)| log);
            let lag_us = reference_scene.expected.lag_us(&mut cursors, pixel, is_on, t_us);
            of_events.push(EventFeatures {
                t_us,
                pixel: pixel as u32,
                is_on,
                cell,
                interval_us: before.map_or(NONE, |(t, ..)| clipped(t_us - t)),
                was_on: before.is_some_and(|(_, on, _)| on),
                // In the direction of the event, where an ideal sensor has its threshold.
                log_step: if is_on { change } else { -change },
                slope,
                lag_us: lag_us.map_or(NONE, clipped),
            });
        }
        let range = events.range(window);
        Self { reference_scene, window, events: of_events, range }
    }

    /// The events of the window, in order of time.
    pub fn events(&self) -> &[EventFeatures] {
        &self.events[self.range.clone()]
    }

    /// Width and height in pixels.
    pub fn size(&self) -> SensorSize {
        self.reference_scene.scene.size()
    }

    /// Length of the window in seconds.
    pub fn seconds(&self) -> f64 {
        self.window.length().as_seconds()
    }

    /// Time since the start of the window, microseconds.
    pub fn since_start_us(&self, t_us: i64) -> i64 {
        t_us - self.window.start.0
    }
}
