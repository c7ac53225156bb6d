//! Windows of a recording of any length, without holding more of it than they need.

use std::path::{Path, PathBuf};

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};

use super::extent::Extent;
use super::outside::OutsideCount;
use super::whole::sensor_of;
use super::{SensorOrigin, input, source};
use crate::{Columns, EventSource, IoError, OpenOptions};

/// Events of a window, at most: 1.7 GB. A sheet of twelve frames of a minute at ten million a second takes 50 million.
const MAX_WINDOW: usize = 1 << 27;

/// A recording that is read window by window, forward or from place to place.
///
/// Events outside the sensor are counted as that.
pub struct Windows {
    path: PathBuf,
    source: Box<dyn EventSource>,
    sensor: SensorSize,
    sensor_origin: SensorOrigin,
    /// Events that were read and not yet discarded, in the order of time.
    buffer: Columns,
    /// Everything of the file before this time is in `buffer` or was discarded.
    read_to: Micros,
    /// End of the discarded part.
    left_to: Micros,
    is_at_end: bool,
    /// Events read up to a time, each counted once.
    surveyed_to: Micros,
    outside: OutsideCount,
    salvages: bool,
    /// Remark on the lost rest of a damaged file.
    lost: Option<String>,
}

impl Windows {
    /// Opens a file. The sensor of one that does not state it is taken from its first events,
    /// unless `options` say.
    ///
    /// # Errors
    /// As [`crate::open`]; damage further on is found when reading comes there.
    pub fn open(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, IoError> {
        let (_, source) = source(input(path.as_ref())?, options)?;
        Self::new(path.as_ref(), source, options)
    }

    /// Takes a source that nothing was read from, whose events are in the order of time.
    ///
    /// # Errors
    /// If the first events cannot be read.
    pub fn from_source(
        source: Box<dyn EventSource>,
        options: &OpenOptions,
    ) -> Result<Self, IoError> {
        Self::new(Path::new("events"), source, options)
    }

    fn new(
        path: &Path,
        source: Box<dyn EventSource>,
        options: &OpenOptions,
    ) -> Result<Self, IoError> {
        let mut windows = Self {
            path: path.to_owned(),
            source,
            sensor: SensorSize { width: u16::MAX, height: u16::MAX },
            sensor_origin: SensorOrigin::Inferred,
            buffer: Columns::new(),
            read_to: Micros(i64::MIN),
            left_to: Micros(i64::MIN),
            is_at_end: false,
            surveyed_to: Micros(i64::MIN),
            outside: OutsideCount::default(),
            salvages: options.salvage,
            lost: None,
        };
        // The first events are read now: a file that does not state its sensor is sized by them.
        windows.read_on()?;
        let header = windows.source.header();
        // Later events may lie outside of the size: they are rejected.
        (windows.sensor, windows.sensor_origin) =
            sensor_of(path, header, options, || Extent::of(&windows.buffer).size())?;
        // The first events were counted before the sensor was known, so they are counted again.
        (windows.surveyed_to, windows.outside) = (Micros(i64::MIN), OutsideCount::default());
        let first = std::mem::take(&mut windows.buffer);
        windows.survey(0, &first)?;
        windows.buffer = first;
        Ok(windows)
    }

    /// The sensor.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Origin of the size of the sensor.
    pub fn sensor_origin(&self) -> SensorOrigin {
        self.sensor_origin
    }

    /// Time of the first event, if there is one; only before anything was read.
    pub fn start(&self) -> Option<Micros> {
        self.buffer.t.first().copied()
    }

    /// Count of events outside the sensor so far, which were left out.
    pub fn outside(&self) -> usize {
        self.outside.outside()
    }

    /// Time of the latest event. The file is read to its end once, without keeping it.
    ///
    /// # Errors
    /// If it cannot be read, or is damaged.
    pub fn end(&mut self) -> Result<Micros, IoError> {
        let mut latest = self.read_to;
        let mut discarded = Columns::new();
        while !self.is_at_end {
            discarded.clear();
            self.next_batch(&mut discarded)?;
            latest = discarded.t.iter().copied().fold(latest, Micros::max);
        }
        // The source goes back to the start, so that windows can be read afterwards.
        self.go_to(self.start().unwrap_or(latest))?;
        Ok(latest)
    }

    /// Time of the first event at `t` or later among those that were read ahead, or `t`: what lies
    /// between is empty. After [`Windows::is_over_at`] there is one, unless the recording is over.
    pub fn next_after(&self, t: Micros) -> Micros {
        self.buffer.t.get(self.before(t)).copied().unwrap_or(t)
    }

    /// Remarks on the content read so far, in sentences without a full stop.
    pub fn remarks(&self) -> Vec<String> {
        self.source.remarks().into_iter().chain(self.lost.clone()).collect()
    }

    /// Whether there are no events at `t` or later.
    ///
    /// # Errors
    /// If the file cannot be read up to there.
    pub fn is_over_at(&mut self, t: Micros) -> Result<bool, IoError> {
        let is_over = |buffer: &Columns| buffer.t.last().is_none_or(|last| *last < t);
        while !self.is_at_end && is_over(&self.buffer) {
            self.read_on()?;
        }
        Ok(is_over(&self.buffer))
    }

    /// Replaces what is in `events` by the events of `window`.
    ///
    /// Windows that follow each other read the file once; others go to where they are by its index.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged before the end of the window, or more than a tenth of
    /// its events are outside the sensor.
    ///
    /// # Panics
    /// If `events` are of a sensor of another size.
    pub fn read(&mut self, window: TimeWindow, events: &mut EventStream) -> Result<(), IoError> {
        assert_eq!(events.sensor(), self.sensor, "events of a sensor of another size");
        // Backwards, or more than a second ahead: searching is faster than reading on.
        if window.start < self.left_to || window.start.0 > self.read_to.0.saturating_add(1_000_000)
        {
            self.go_to(window.start)?;
        }
        while !self.is_at_end && self.read_to < window.end {
            self.read_on()?;
            // What is before the window takes no room beside it.
            if self.buffer.len() > MAX_WINDOW {
                self.leave_behind(window.start);
                self.check_length(window)?;
            }
        }
        self.leave_behind(window.start);
        events.clear();
        for k in 0..self.before(window.end) {
            // Those outside the sensor were counted when they were read.
            let _ = events.push(self.buffer.event(k));
        }
        Ok(())
    }

    fn check_length(&self, window: TimeWindow) -> Result<(), IoError> {
        if self.before(window.end) <= MAX_WINDOW {
            return Ok(());
        }
        let (start, end) = (window.start.as_seconds(), window.end.as_seconds());
        let reason = format!(
            "more than {MAX_WINDOW} events from {start:.6} s to {end:.6} s: choose a shorter part with \
             --from and --to, or shorter windows"
        );
        Err(IoError::Stream { path: self.path.clone(), reason })
    }

    /// Goes where reading on gives every event from `t` on.
    fn go_to(&mut self, t: Micros) -> Result<(), IoError> {
        self.source.seek(t)?;
        self.buffer.clear();
        (self.read_to, self.left_to) = (Micros(i64::MIN), Micros(i64::MIN));
        self.is_at_end = false;
        Ok(())
    }

    /// Reads a batch.
    fn read_on(&mut self) -> Result<(), IoError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        let read = self.next_batch(&mut buffer);
        self.buffer = buffer;
        self.read_to = self.buffer.t.last().copied().unwrap_or(self.read_to).max(self.read_to);
        read
    }

    /// Count of the first events of the buffer, those before `t`.
    fn before(&self, t: Micros) -> usize {
        self.buffer.t.partition_point(|at| *at < t)
    }

    /// Appends a batch, and notes the end: that of the file, or of what is readable of it.
    fn next_batch(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        match self.source.next(columns) {
            Err(damage) if self.salvages && damage.is_damage() => {
                self.lost = Some(format!("the rest is lost: {damage}"));
                self.is_at_end = true;
            }
            read => {
                read?;
                self.is_at_end = columns.len() == before;
            }
        }
        self.survey(before, columns)
    }

    /// Counts the events from `begin` on that were not read before, and those outside the sensor.
    fn survey(&mut self, begin: usize, columns: &Columns) -> Result<(), IoError> {
        let new = begin + columns.t[begin..].partition_point(|t| *t <= self.surveyed_to);
        self.outside.add(columns, new, self.sensor);
        self.surveyed_to =
            columns.t.last().copied().unwrap_or(self.surveyed_to).max(self.surveyed_to);
        self.outside.check(&self.path, self.sensor, self.is_at_end)
    }

    /// Forgets what is before `t`.
    fn leave_behind(&mut self, t: Micros) {
        self.left_to = self.left_to.max(t);
        self.buffer.discard_first(self.before(t));
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Event;
    use proptest::prelude::*;

    use super::*;
    use crate::{Input, open::read_as};

    fn windows(text: &str, salvage: bool) -> Result<Windows, IoError> {
        let options = OpenOptions { salvage, ..OpenOptions::default() };
        let input = Input::memory("events.txt", text.as_bytes().to_vec());
        Windows::from_source(source(input, &options)?.1, &options)
    }

    fn within(windows: &mut Windows, start: i64, end: i64) -> Vec<Event> {
        let mut events = EventStream::empty(windows.sensor());
        windows.read(TimeWindow { start: Micros(start), end: Micros(end) }, &mut events).unwrap();
        events.iter().collect()
    }

    /// Longer than one block of bytes, with gaps of up to three seconds.
    fn long() -> String {
        let mut text = "4 3\n".to_owned();
        let mut t = 5_000_000;
        for k in 0..40_000_i64 {
            t += if k % 9_000 == 8_999 { 3_000_000 } else { (k * k) % 50 };
            text += &format!("{t} {} {} {}\n", k % 4, k % 3, k % 2);
        }
        text
    }

    #[test]
    fn windows_in_a_row_give_every_event_once() {
        let text = long();
        let input = Input::memory("events.txt", text.clone().into_bytes());
        let whole: Vec<Event> =
            read_as(input, &OpenOptions::default()).unwrap().stream.iter().collect();
        let mut windows = windows(&text, false).unwrap();
        let (mut found, mut start) = (Vec::new(), windows.start().unwrap().0);
        while !windows.is_over_at(Micros(start)).unwrap() {
            found.extend(within(&mut windows, start, start + 70_000));
            start += 70_000;
        }
        assert!(found == whole && windows.outside() == 0);
        assert_eq!(windows.end().unwrap(), whole.last().unwrap().t);
    }

    #[test]
    fn windows_in_any_order_give_what_the_whole_recording_has_there() {
        let text = long();
        let input = Input::memory("events.txt", text.clone().into_bytes());
        let whole = read_as(input, &OpenOptions::default()).unwrap().stream;
        let windows = std::cell::RefCell::new(windows(&text, false).unwrap());
        let mut runner = proptest::test_runner::TestRunner::default();
        runner
            .run(&(4_900_000..18_000_000_i64, 1..400_000_i64), |(start, length)| {
                let window = TimeWindow { start: Micros(start), end: Micros(start + length) };
                let want: Vec<Event> = whole.slice(window).iter().collect();
                prop_assert_eq!(within(&mut windows.borrow_mut(), start, start + length), want);
                Ok(())
            })
            .unwrap();
    }

    #[test]
    fn windows_behind_a_wraparound_are_those_of_the_whole_recording() {
        let times = (0..60_000_i64).map(|k| ((1 << 32) - 3_000_000 + 100 * k) % (1 << 32));
        let lines = times.map(|t| format!("{t} 1 1 1\n"));
        let text = "4 3\n".to_owned() + &lines.collect::<String>();
        let mut windows = windows(&text, false).unwrap();
        let late = (1 << 32) + 2_000_000;
        assert_eq!(within(&mut windows, late, late + 1_000).len(), 10);
        assert_eq!(windows.end().unwrap(), Micros((1 << 32) + 2_999_900));
        assert_eq!(within(&mut windows, late, late + 1_000).len(), 10);
    }

    #[test]
    fn what_is_readable_of_a_damaged_file_is_given_where_that_is_asked() {
        let text = "4 3\n1 1 1 1\n2 1 1 1\n3 1";
        assert!(windows(text, false).is_err());
        let mut windows = windows(text, true).unwrap();
        assert_eq!(within(&mut windows, 0, 10).len(), 2);
        assert!(windows.remarks()[0].starts_with("the rest is lost"), "{:?}", windows.remarks());
    }
}
