//! Events beside the scene that they came from: what probes look at.

use std::ops::Range;

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};

use crate::{Cell, Classes, Scene};

/// A scene with its classes and the events that the model without any effect makes of it.
#[derive(Debug)]
pub struct Stage {
    /// Luminance over time.
    pub scene: Scene,
    /// What the scene does at every pixel and time.
    pub classes: Classes,
    /// Events of the reference model, by pixel and polarity.
    pub expected: Expected,
}

/// Times of the reference model's events, sorted, by pixel and polarity.
#[derive(Debug, Default)]
pub struct Expected {
    /// Where the times of list `2 pixel + polarity` begin.
    starts: Vec<usize>,
    t_us: Vec<i64>,
}

impl Expected {
    /// Sorts events into lists.
    pub fn of(events: &EventStream) -> Self {
        let lists = 2 * events.sensor().pixels();
        let list = |event: evpose_core::Event| {
            let pixel =
                usize::from(event.y) * usize::from(events.sensor().width) + usize::from(event.x);
            2 * pixel + usize::from(event.polarity.is_on())
        };
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

    /// How many there are.
    pub fn events(&self) -> usize {
        self.t_us.len()
    }

    /// Times of the events of a pixel and a polarity, in microseconds.
    pub fn times(&self, pixel: usize, is_on: bool) -> &[i64] {
        let list = 2 * pixel + usize::from(is_on);
        &self.t_us[self.starts[list]..self.starts[list + 1]]
    }

    /// Where all lists begin.
    fn places(&self) -> Places {
        Places(self.starts[..self.starts.len().saturating_sub(1)].to_vec())
    }

    /// From the nearest event of the reference to `t_us`: positive where that is later. Calls are
    /// in order of time, for which `places` keeps how far each list has been passed.
    fn lag_us(&self, places: &mut Places, pixel: usize, is_on: bool, t_us: i64) -> Option<i64> {
        let list = 2 * pixel + usize::from(is_on);
        let (Some(next), Some(&start)) = (places.0.get_mut(list), self.starts.get(list)) else {
            return None;
        };
        let end = self.starts[list + 1];
        while *next < end && self.t_us[*next] <= t_us {
            *next += 1;
        }
        let before = (*next > start).then(|| t_us - self.t_us[*next - 1]);
        let after = (*next < end).then(|| t_us - self.t_us[*next]);
        match (before, after) {
            (Some(b), Some(a)) => Some(if b <= -a { b } else { a }),
            (found, None) | (None, found) => found,
        }
    }
}

/// How far lists were passed.
struct Places(Vec<usize>);

/// One event and what the scene says about it. Small, since there are many, and all probes go
/// through all of them.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// When, in microseconds.
    pub t_us: i64,
    /// Which pixel, row by row.
    pub pixel: u32,
    /// Microseconds since the event before, [`NONE`] where there is none.
    pause_us: i32,
    /// Microseconds from the nearest event of the reference, [`NONE`] where there is none.
    lag_us: i32,
    /// Change of log luminance since the event before in the same pixel (or since the start), in
    /// the direction of this event: one threshold, for the ideal sensor.
    pub swing: f32,
    /// Change of log luminance per second.
    pub slope: f32,
    /// The classes of the pixel then.
    pub cell: Cell,
    /// Its polarity.
    pub is_on: bool,
    was_on: bool,
}

/// A time that is not there.
const NONE: i32 = i32::MIN;

/// Times beyond half an hour are as good as half an hour.
fn short(us: i64) -> i32 {
    us.clamp(i64::from(-i32::MAX), i64::from(i32::MAX)) as i32
}

impl Sight {
    /// Microseconds since the event before in the same pixel, and whether that was ON.
    pub fn before(&self) -> Option<(i64, bool)> {
        (self.pause_us != NONE).then_some((i64::from(self.pause_us), self.was_on))
    }

    /// Microseconds from the nearest event of the reference in the same pixel and polarity.
    pub fn lag_us(&self) -> Option<i64> {
        (self.lag_us != NONE).then_some(i64::from(self.lag_us))
    }
}

/// Events of a part of a recording.
#[derive(Debug)]
pub struct View<'a> {
    /// The scene.
    pub stage: &'a Stage,
    /// The part of time.
    pub window: TimeWindow,
    /// All events of the recording.
    sights: Vec<Sight>,
    range: Range<usize>,
}

impl<'a> View<'a> {
    /// Looks at the events of a window. Events before it count as what came before.
    pub fn new(stage: &'a Stage, events: &EventStream, window: TimeWindow) -> Self {
        let size = stage.scene.size();
        let width = usize::from(size.width);
        // Time, polarity and log light of the last event of every pixel.
        let mut last: Vec<Option<(i64, bool, f32)>> = vec![None; size.pixels()];
        let mut sights = Vec::with_capacity(events.len());
        let classes = &stage.classes;
        let mut places = stage.expected.places();
        // In a loop of its own, since nearly every look at a scene waits for memory.
        let seen = events.iter().map(|event| {
            let pixel = usize::from(event.y) * width + usize::from(event.x);
            let t_s = event.t.as_seconds();
            let (log, slope) = (classes.log_at(pixel, t_s), classes.slope_at(pixel, t_s));
            (pixel, log, slope, classes.cell(pixel, t_s))
        });
        let seen: Vec<_> = seen.collect();
        for (event, (pixel, log, slope, cell)) in events.iter().zip(seen) {
            let (t_us, is_on) = (event.t.0, event.polarity.is_on());
            let before = last[pixel].replace((t_us, is_on, log));
            let change = log - before.map_or_else(|| classes.log_at(pixel, 0.0), |(.., log)| log);
            let lag_us = stage.expected.lag_us(&mut places, pixel, is_on, t_us);
            sights.push(Sight {
                t_us,
                pixel: pixel as u32,
                is_on,
                cell,
                pause_us: before.map_or(NONE, |(t, ..)| short(t_us - t)),
                was_on: before.is_some_and(|(_, on, _)| on),
                swing: if is_on { change } else { -change },
                slope,
                lag_us: lag_us.map_or(NONE, short),
            });
        }
        let range = events.range(window);
        Self { stage, window, sights, range }
    }

    /// The events of the window, in order of time.
    pub fn events(&self) -> &[Sight] {
        &self.sights[self.range.clone()]
    }

    /// Width and height in pixels.
    pub fn size(&self) -> SensorSize {
        self.stage.scene.size()
    }

    /// Length of the window in seconds.
    pub fn seconds(&self) -> f64 {
        self.window.length().as_seconds()
    }

    /// The time since the window began, in microseconds.
    pub fn since_start_us(&self, t_us: i64) -> i64 {
        t_us - self.window.start.0
    }

    /// The same view of another window.
    #[must_use]
    pub fn over(mut self, window: TimeWindow) -> Self {
        let at = |t: Micros| self.sights.partition_point(|sight| sight.t_us < t.0);
        self.range = at(window.start)..at(window.end);
        self.window = window;
        self
    }
}
