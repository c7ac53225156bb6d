//! Replay of a recording, in real time or at another speed.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

use evpose_core::{Micros, SensorSize};
use evpose_io::{Columns, EventSource, IoError, OpenOptions, OutsideCount};

use super::{MAX_TIME, Source};
use crate::LiveError;

/// Upper bound of the events in a packet, so that a burst at one time stamp fills no memory.
const MAX_EVENTS: usize = 1 << 18;

/// Lag at which the clock of a recording that cannot be read at its playback speed is set back: a
/// camera is never late. A smaller lag is part of the latency.
const MAX_REPLAY_LAG: Duration = Duration::from_millis(100);

/// Options of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayOptions {
    /// Playback speed: event time per host time; infinite for as fast as possible.
    pub speed: f64,
    /// Event time of a packet.
    pub packet: Micros,
    /// Number of repetitions.
    pub times: u64,
    /// Event time after which the replay ends, all repetitions together; none for all of it.
    pub span: Option<Micros>,
    /// Whether events that are not processed in time are lost, as with a camera; otherwise the
    /// replay waits.
    pub is_real_time: bool,
    /// Options of the file format.
    pub open: OpenOptions,
}

impl Default for ReplayOptions {
    /// Once, at its own speed and without losses, in packets of a millisecond.
    fn default() -> Self {
        let open = OpenOptions::default();
        Self { speed: 1.0, packet: Micros(1_000), times: 1, span: None, is_real_time: false, open }
    }
}

/// A recording as a source.
///
/// Repetitions continue the time stamps by a whole number of packets, so that each has the packets
/// of the first. Events come in the order of time, as from [`evpose_io::source`].
pub struct Replay {
    name: String,
    source: Box<dyn EventSource>,
    sensor: SensorSize,
    options: ReplayOptions,
    /// Events that were read, of which the first `sent` were returned.
    buffer: Columns,
    sent: usize,
    /// Host time and event time of the first event.
    began: Option<(Instant, Micros)>,
    /// Event time at which the next packet ends.
    packet_end: Micros,
    /// Offset of the time stamps in this repetition.
    shift: Micros,
    last: Micros,
    first: Option<Micros>,
    left: u64,
    /// Index of the repetition in the buffer, and that of the events that were returned.
    read_repetition: u64,
    repetition: u64,
    /// Total time by which the clock was set back.
    slipped: Duration,
    /// Error of the recording after the buffered events.
    failure: Option<IoError>,
    /// Of the first repetition.
    outside: OutsideCount,
    /// Event time that has been read.
    horizon: Arc<AtomicI64>,
}

impl Replay {
    /// Opens a recording.
    ///
    /// # Errors
    /// If it cannot be read, does not state its sensor, or an option is out of range.
    pub fn open(path: &Path, options: ReplayOptions) -> Result<Self, LiveError> {
        let invalid =
            |setting, value: String, rule| Err(LiveError::Setting { setting, value, rule });
        // Infinity is allowed: no event is waited for.
        if options.speed.is_nan() || options.speed <= 0.0 {
            return invalid("speed", options.speed.to_string(), "above zero");
        }
        if options.packet.0 <= 0 {
            return invalid("packet", options.packet.0.to_string(), "at least a microsecond");
        }
        let (_, source) = evpose_io::source(evpose_io::input(path)?, &options.open)?;
        let header = source.header();
        // What the user gives comes before what the file states, and that before what its format
        // implies.
        let known = options.open.sensor.or(header.sensor).or(header.usual_sensor);
        let sensor = known.ok_or_else(|| LiveError::Source {
            name: path.display().to_string(),
            reason: "the file does not state its sensor: give it, as 346x260".to_owned(),
        })?;
        Ok(Self {
            name: path.display().to_string(),
            source,
            sensor,
            left: options.times,
            options,
            buffer: Columns::new(),
            sent: 0,
            began: None,
            packet_end: Micros(i64::MIN),
            shift: Micros(0),
            last: Micros(i64::MIN),
            first: None,
            read_repetition: 0,
            repetition: 0,
            slipped: Duration::ZERO,
            failure: None,
            outside: OutsideCount::default(),
            horizon: Arc::new(AtomicI64::new(i64::MIN)),
        })
    }

    /// Fills the buffer. Returns false at the end of the last repetition.
    fn fill(&mut self) -> Result<bool, LiveError> {
        while self.sent == self.buffer.len() {
            self.buffer.clear();
            self.sent = 0;
            if let Some(failure) = self.failure.take() {
                return Err(failure.into());
            }
            // Events before a fault are returned before its error.
            self.failure = self.source.next(&mut self.buffer).err();
            let is_noise = |t: &&Micros| t.0.unsigned_abs() > MAX_TIME.0.unsigned_abs();
            if let Some(t) = self.buffer.t.iter().find(is_noise) {
                let reason = format!("an event at {t}: no recording lasts so long");
                return Err(LiveError::Source { name: self.name.clone(), reason });
            }
            // Repetitions hold the same events, so that those outside the sensor are counted once.
            if self.read_repetition == 0 {
                self.outside.add(&self.buffer, 0, self.sensor);
                let is_at_end = self.buffer.is_empty() && self.failure.is_none();
                self.outside.check(Path::new(&self.name), self.sensor, is_at_end)?;
            }
            if self.buffer.is_empty() && self.failure.is_none() {
                self.left = self.left.saturating_sub(1);
                let Some(first) = self.first.filter(|_| self.left > 0) else { return Ok(false) };
                self.source.seek(Micros(i64::MIN))?;
                // A repetition starts at least one packet after the end of the last.
                let packet = self.options.packet.0;
                self.shift = Micros(((self.last.0 - first.0) / packet + 1) * packet);
                self.read_repetition += 1;
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
        let first = self.buffer.t[self.sent] + self.shift;
        let origin = *self.first.get_or_insert(first);
        let span_end = self.options.span.map_or(i64::MAX, |span| origin.0.saturating_add(span.0));
        if first.0 >= span_end {
            return Ok(None);
        }
        // A repetition begins with a packet of its own.
        if std::mem::replace(&mut self.repetition, self.read_repetition) != self.read_repetition {
            self.packet_end = Micros(i64::MIN);
        }
        if self.packet_end <= first {
            let next = Micros(self.packet_end.0.saturating_add(self.options.packet.0));
            // Behind a gap packets begin at the next event, not in the gap.
            self.packet_end = if next > first { next } else { first + self.options.packet };
        }
        let mut last = first;
        while self.fill()? {
            // Packets after a gap may end within the next repetition.
            if self.repetition != self.read_repetition {
                break;
            }
            let waiting = &self.buffer.t[self.sent..];
            let end = Micros(self.packet_end.0.min(span_end)) - self.shift;
            let fit = waiting.partition_point(|t| *t < end);
            let fit = fit.min(MAX_EVENTS - (columns.len() - start));
            if fit == 0 {
                break;
            }
            let range = self.sent..self.sent + fit;
            last = self.buffer.t[range.end - 1] + self.shift;
            columns.t.extend(self.buffer.t[range.clone()].iter().map(|t| *t + self.shift));
            columns.x.extend_from_slice(&self.buffer.x[range.clone()]);
            columns.y.extend_from_slice(&self.buffer.y[range.clone()]);
            columns.polarity.extend_from_slice(&self.buffer.polarity[range.clone()]);
            self.sent = range.end;
            self.last = last;
        }
        assert!(columns.len() > start, "a packet begins with its first event");
        // Before it is waited for: poses may be propagated until there, and not beyond the end.
        self.horizon.store(last.0, Ordering::Relaxed);
        let (began, origin) = *self.began.get_or_insert_with(|| (Instant::now(), first));
        let passed_s = (last - origin).as_seconds() / self.options.speed;
        let passed = Duration::try_from_secs_f64(passed_s.max(0.0)).unwrap_or_default();
        // A time beyond what the clock holds is due at once.
        let due = began.checked_add(passed).unwrap_or(began);
        let now = Instant::now();
        let late = now.saturating_duration_since(due);
        if late > MAX_REPLAY_LAG {
            // The clock is moved: lost time is not caught up with.
            self.began = Some((began + late, origin));
            self.slipped += if self.options.speed.is_finite() { late } else { Duration::ZERO };
            return Ok(Some(now));
        }
        if let Some(early) = due.checked_duration_since(now) {
            std::thread::sleep(early);
        }
        // Without a speed, the host time of an event is that of reading it.
        Ok(Some(if self.options.speed.is_finite() { due } else { now }))
    }

    fn slipped(&self) -> Duration {
        self.slipped
    }

    fn remarks(&self) -> Vec<String> {
        self.source.remarks()
    }

    fn is_lossless(&self) -> bool {
        !self.options.is_real_time
    }

    fn horizon(&self) -> Option<Arc<AtomicI64>> {
        Some(self.horizon.clone())
    }

    fn repetition(&self) -> u64 {
        self.repetition
    }

    fn pace(&self) -> Option<f64> {
        Some(self.options.speed).filter(|speed| speed.is_finite())
    }
}

#[cfg(test)]
mod tests;
