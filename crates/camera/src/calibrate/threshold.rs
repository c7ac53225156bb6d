//! Contrast thresholds from frames and events of one moving pattern.
//!
//! # Model
//! By totals: every event stands for one threshold of change, so that
//! `C = sum over pixels and frames of |ln max(I', floor) - ln max(I, floor)| / events`; rises over
//! ON events and falls over OFF events alike. What is left in pixels at the end, noise events, and
//! frames that are too slow for the motion all go into it.
//!
//! By steps: the level that a pixel follows light with is a staircase, and the height of a step is
//! the change of log light since the event before. Light runs in a line of time between frames. The
//! median of heights does not mind single events of noise.
//!
//! Intervals of 95 % are bootstrapped over 8 x 8 tiles of the image.
//!
//! # Source
//! By totals: Rudnev et al., *EventHands* (ICCV 2021), supplement, eqs. 7 and 8, with a floor of 10
//! of 255.

use evpose_core::stats::bootstrap::{BootstrapConfig, bootstrap};
use evpose_core::stats::interval::Interval;
use evpose_core::{Event, EventStream, Micros, Plane, SensorSize};
use serde::Serialize;

use crate::calibrate::CalibrateError;
use crate::calibrate::steps::{Heights, median};
use crate::calibrate::tiles::Tiles;

/// Light below this share of white is taken to be this: 10 of 255, where cameras show noise.
pub const FLOOR: f32 = 10.0 / 255.0;
/// Fewer events are no ground for a threshold.
const MIN_EVENTS: usize = 200;
/// Draws of the bootstrap.
const RESAMPLES: usize = 1_000;

/// Thresholds in units of log light.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Thresholds {
    /// Of both polarities together, by totals.
    pub by_totals: Interval,
    /// Of ON events, by totals.
    pub by_totals_on: Interval,
    /// Of OFF events, by totals.
    pub by_totals_off: Interval,
    /// Of ON events, by steps.
    pub by_steps_on: Interval,
    /// Of OFF events, by steps.
    pub by_steps_off: Interval,
    /// ON events.
    pub on: usize,
    /// OFF events.
    pub off: usize,
    /// Frames.
    pub frames: usize,
}

/// Accumulated statistics of one tile.
#[derive(Debug, Clone)]
struct Tile {
    rise: f64,
    fall: f64,
    on: usize,
    off: usize,
    on_steps: Heights,
    off_steps: Heights,
}

/// Frames, one after the other, beside the events between them.
#[derive(Debug)]
pub struct ThresholdRun<'a> {
    events: &'a EventStream,
    /// Events that have been looked at.
    next: usize,
    size: SensorSize,
    fps: f64,
    /// Seconds of every frame, where they are not at a constant rate.
    times_s: Option<Vec<f64>>,
    floor: f32,
    tiles: Tiles,
    tile_states: Vec<Tile>,
    /// Log light of the frame before.
    before: Option<Vec<f32>>,
    /// Log light at the last event of every pixel.
    last: Vec<Option<f32>>,
    frames: usize,
}

impl<'a> ThresholdRun<'a> {
    /// Frames of `size` at `fps` frames per second, the first at time 0 of `events`; light below
    /// `floor`, relative to white, is taken to be `floor`.
    ///
    /// # Errors
    /// Sizes that differ.
    pub fn new(
        size: SensorSize,
        fps: f64,
        floor: f32,
        events: &'a EventStream,
    ) -> Result<Self, CalibrateError> {
        if size != events.sensor() {
            return Err(CalibrateError::Size { frames: size, events: events.sensor() });
        }
        let tiles = Tiles::for_sensor(size);
        let (on_steps, off_steps) = (Heights::new(), Heights::new());
        let tile = Tile { rise: 0.0, fall: 0.0, on: 0, off: 0, on_steps, off_steps };
        Ok(Self {
            events,
            next: 0,
            size,
            fps,
            times_s: None,
            floor,
            tiles,
            tile_states: vec![tile; tiles.count()],
            before: None,
            last: vec![None; size.pixels()],
            frames: 0,
        })
    }

    /// Frames at times of their own, in increasing seconds on the clock of the events, in place of a rate.
    /// Events before the first are skipped.
    ///
    /// Frames behind the last time go on at the rate.
    #[must_use]
    pub fn at_times(self, times_s: Vec<f64>) -> Self {
        let start = times_s.first().map_or(Micros(0), |start_s| Micros::from_seconds(*start_s));
        let next = self.events.t().partition_point(|t| *t < start);
        Self { times_s: Some(times_s), next, ..self }
    }

    fn time_s(&self, frame: usize) -> f64 {
        let stated = self.times_s.as_ref().and_then(|times| times.get(frame).copied());
        stated.unwrap_or(frame as f64 / self.fps)
    }

    /// The next frame, linear light relative to white.
    ///
    /// # Errors
    /// A frame of another size.
    pub fn push(&mut self, frame: &Plane<f32>) -> Result<(), CalibrateError> {
        let size = SensorSize { width: frame.width() as u16, height: frame.height() as u16 };
        if size != self.size {
            return Err(CalibrateError::Size { frames: size, events: self.size });
        }
        // The floor also keeps the logarithm of black finite.
        let log: Vec<f32> = frame.data().iter().map(|y| y.max(self.floor).ln()).collect();
        if let Some(before) = self.before.take() {
            self.change(&before, &log);
            self.steps(&before, &log);
        }
        self.before = Some(log);
        self.frames += 1;
        Ok(())
    }

    /// Accumulates the change of light between two frames.
    fn change(&mut self, before: &[f32], after: &[f32]) {
        let width = usize::from(self.size.width);
        for (pixel, (a, b)) in before.iter().zip(after).enumerate() {
            let tile = &mut self.tile_states[self.tiles.at(pixel % width, pixel / width)];
            // A net change would cancel: ON events count what rises, OFF events what falls.
            let change = f64::from(b - a);
            tile.rise += change.max(0.0);
            tile.fall += (-change).max(0.0);
        }
    }

    /// Events between two frames.
    fn steps(&mut self, before: &[f32], after: &[f32]) {
        let (start_s, end_s) = (self.time_s(self.frames - 1), self.time_s(self.frames));
        let end = Micros::from_seconds(end_s);
        while let Some(event) = self.events.get(self.next).filter(|event| event.t <= end) {
            self.next += 1;
            // Events before the first frame would otherwise extrapolate the light.
            let share =
                ((event.t.as_seconds() - start_s) / (end_s - start_s)).clamp(0.0, 1.0) as f32;
            self.step(event, share, before, after);
        }
    }

    fn step(&mut self, event: Event, share: f32, before: &[f32], after: &[f32]) {
        let (x, y) = (usize::from(event.x), usize::from(event.y));
        let pixel = y * usize::from(self.size.width) + x;
        let light = before[pixel] + (after[pixel] - before[pixel]) * share;
        let last = self.last[pixel].replace(light);
        let tile = &mut self.tile_states[self.tiles.at(x, y)];
        let (count, steps, sign) = match event.polarity.is_on() {
            true => (&mut tile.on, &mut tile.on_steps, 1.0),
            false => (&mut tile.off, &mut tile.off_steps, -1.0),
        };
        *count += 1;
        // Where the staircase stood before its first step is not known.
        if let Some(last) = last {
            steps.add(sign * (light - last));
        }
    }

    /// The thresholds; `seed` draws the intervals.
    ///
    /// # Errors
    /// Too few frames or events, or light that does not change.
    pub fn finish(self, seed: u64) -> Result<Thresholds, CalibrateError> {
        if self.frames < 2 {
            return Err(CalibrateError::TooFewFrames(self.frames));
        }
        let on: usize = self.tile_states.iter().map(|tile| tile.on).sum();
        let off: usize = self.tile_states.iter().map(|tile| tile.off).sum();
        if self.tile_states.iter().all(|tile| tile.rise + tile.fall == 0.0) {
            return Err(CalibrateError::NoChange);
        }
        for (what, actual) in [("ON events while frames last", on), ("OFF events", off)] {
            if actual < MIN_EVENTS {
                return Err(CalibrateError::TooFewEvents { what, actual, needed: MIN_EVENTS });
            }
        }
        let tiles = &self.tile_states;
        let config = BootstrapConfig { resamples: RESAMPLES, seed };
        // Tiles of the image are drawn: pixels next to each other see the same edges.
        let of = |statistic: &dyn Fn(&[usize]) -> f64| bootstrap(tiles.len(), &config, statistic);
        let ratio = |light: fn(&Tile) -> f64, events: fn(&Tile) -> usize| {
            of(&|drawn| {
                // An event is one threshold of change: the light per event is the threshold.
                let light: f64 = drawn.iter().map(|i| light(&tiles[*i])).sum();
                light / drawn.iter().map(|i| events(&tiles[*i])).sum::<usize>() as f64
            })
        };
        let steps = |heights: fn(&Tile) -> &Heights| {
            of(&|drawn| median(drawn.iter().map(|i| heights(&tiles[*i]))))
        };
        Ok(Thresholds {
            by_totals: ratio(|t| t.rise + t.fall, |t| t.on + t.off),
            by_totals_on: ratio(|t| t.rise, |t| t.on),
            by_totals_off: ratio(|t| t.fall, |t| t.off),
            by_steps_on: steps(|t| &t.on_steps),
            by_steps_off: steps(|t| &t.off_steps),
            on,
            off,
            frames: self.frames,
        })
    }
}
