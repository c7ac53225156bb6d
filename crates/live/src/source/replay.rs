//! A recording, at the speed of its clock or faster.

use std::path::Path;
use std::time::{Duration, Instant};

use evpose_core::{Micros, SensorSize};
use evpose_io::{Columns, EventSource, IoError, OpenOptions};

use super::{FARTHEST, JUMP, Source};
use crate::LiveError;

/// Events that come together at most, whatever their times.
const MOST_EVENTS: usize = 1 << 18;

/// A recording that cannot be read as fast as it should be played is this late at most: then its clock is
/// set back. No camera is late; whoever makes us wait for less is part of the latency.
const LATEST: Duration = Duration::from_millis(100);

/// How a recording is played.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayOptions {
    /// Seconds of the recording in a second; infinite for as fast as it goes.
    pub speed: f64,
    /// Events of so much time of the recording come together.
    pub packet: Micros,
    /// How often it is played.
    pub times: u64,
    /// Where its file leaves a choice.
    pub open: OpenOptions,
}

impl Default for ReplayOptions {
    /// Once, as it happened, in packets of a millisecond.
    fn default() -> Self {
        Self { speed: 1.0, packet: Micros(1_000), times: 1, open: OpenOptions::default() }
    }
}

/// Plays a recording.
///
/// A recording that is played again goes on where it ended: its times do not jump back. Where they do in the
/// recording itself, what is behind is played from then on.
pub struct Replay {
    name: String,
    source: Box<dyn EventSource>,
    sensor: SensorSize,
    options: ReplayOptions,
    /// Read, and given up to `given`.
    ahead: Columns,
    given: usize,
    /// When the first event was due, and its time.
    began: Option<(Instant, Micros)>,
    /// Where the packet that comes next ends, as the recording counts.
    packet_end: Micros,
    /// What is added to times of the recording: it has been played before.
    shift: Micros,
    last: Micros,
    first: Option<Micros>,
    left: u64,
    /// By how much its clock was set back.
    slipped: Duration,
    /// What the recording failed of behind what is ahead.
    failure: Option<IoError>,
}

impl Replay {
    /// Opens a recording.
    ///
    /// # Errors
    /// If it cannot be read, does not say its sensor, or an option makes no sense.
    pub fn open(path: &Path, options: ReplayOptions) -> Result<Self, LiveError> {
        let setting = |what, value: String, rule| Err(LiveError::Setting { what, value, rule });
        if options.speed.is_nan() || options.speed <= 0.0 {
            return setting("speed", options.speed.to_string(), "above zero");
        }
        if options.packet.0 <= 0 {
            return setting("packet", options.packet.0.to_string(), "at least a microsecond");
        }
        let (_, source) = evpose_io::source(evpose_io::input(path)?, &options.open)?;
        let header = source.header();
        let known = options.open.sensor.or(header.sensor).or(header.usual_sensor);
        let sensor = known.ok_or_else(|| LiveError::Source {
            what: path.display().to_string(),
            reason: "the file does not state its sensor: give it, as 346x260".to_owned(),
        })?;
        Ok(Self {
            name: path.display().to_string(),
            source,
            sensor,
            left: options.times,
            options,
            ahead: Columns::new(),
            given: 0,
            began: None,
            packet_end: Micros(i64::MIN),
            shift: Micros(0),
            last: Micros(i64::MIN),
            first: None,
            slipped: Duration::ZERO,
            failure: None,
        })
    }

    /// Reads on until there is an event; whether there is one.
    fn fill(&mut self) -> Result<bool, LiveError> {
        while self.given == self.ahead.len() {
            self.ahead.clear();
            self.given = 0;
            if let Some(failure) = self.failure.take() {
                return Err(failure.into());
            }
            // Events before a fault are given before it is told.
            self.failure = self.source.next(&mut self.ahead).err();
            let is_noise = |t: &&Micros| t.0.unsigned_abs() > FARTHEST.0.unsigned_abs();
            if let Some(t) = self.ahead.t.iter().find(is_noise) {
                let reason = format!("an event at {t}: no recording lasts so long");
                return Err(LiveError::Source { what: self.name.clone(), reason });
            }
            if self.ahead.is_empty() && self.failure.is_none() {
                self.left = self.left.saturating_sub(1);
                let Some(first) = self.first.filter(|_| self.left > 0) else { return Ok(false) };
                self.source.seek(Micros(i64::MIN))?;
                // The first event of the next time comes a packet after the last of this.
                self.shift = Micros(self.last.0 - first.0 + self.options.packet.0);
            }
        }
        Ok(true)
    }
}

impl Source for Replay {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn sensor(&self) -> SensorSize {
        self.sensor
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        if !self.fill()? {
            return Ok(None);
        }
        let start = columns.len();
        let first = self.ahead.t[self.given] + self.shift;
        self.first.get_or_insert(first);
        if self.began.is_some() && first + JUMP < self.last {
            (self.began, self.packet_end) = (None, Micros(i64::MIN));
        }
        if self.packet_end <= first {
            let next = Micros(self.packet_end.0.saturating_add(self.options.packet.0));
            self.packet_end = if next > first { next } else { first + self.options.packet };
        }
        let mut last = first;
        while self.fill()? {
            let waiting = &self.ahead.t[self.given..];
            let (back, end) = (first - JUMP - self.shift, self.packet_end - self.shift);
            let fit = waiting.iter().position(|t| *t >= end || *t < back);
            let fit = fit.unwrap_or(waiting.len()).min(MOST_EVENTS - (columns.len() - start));
            if fit == 0 {
                break;
            }
            let range = self.given..self.given + fit;
            last = self.ahead.t[range.end - 1] + self.shift;
            columns.t.extend(self.ahead.t[range.clone()].iter().map(|t| *t + self.shift));
            columns.x.extend_from_slice(&self.ahead.x[range.clone()]);
            columns.y.extend_from_slice(&self.ahead.y[range.clone()]);
            columns.polarity.extend_from_slice(&self.ahead.polarity[range.clone()]);
            self.given = range.end;
            self.last = last;
        }
        debug_assert!(columns.len() > start, "a packet begins with its first event");
        let (began, origin) = *self.began.get_or_insert_with(|| (Instant::now(), first));
        let passed_s = (last - origin).as_seconds() / self.options.speed;
        let passed = Duration::try_from_secs_f64(passed_s.max(0.0)).unwrap_or_default();
        let due = began.checked_add(passed).unwrap_or(began);
        let now = Instant::now();
        let late = now.saturating_duration_since(due);
        if late > LATEST {
            self.began = Some((began + late, origin));
            self.slipped += if self.options.speed.is_finite() { late } else { Duration::ZERO };
            return Ok(Some(now));
        }
        if let Some(early) = due.checked_duration_since(now) {
            std::thread::sleep(early);
        }
        // As fast as it goes, an event happens when it is read.
        Ok(Some(if self.options.speed.is_finite() { due } else { now }))
    }

    fn slipped(&self) -> Duration {
        self.slipped
    }

    fn pace(&self) -> Option<f64> {
        Some(self.options.speed).filter(|speed| speed.is_finite())
    }
}

#[cfg(test)]
mod tests;
