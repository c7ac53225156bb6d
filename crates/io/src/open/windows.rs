//! Windows of a recording of any length, without holding more of it than they need.

use std::path::Path;

use evpose_core::{EventStream, Micros, Rejected, SensorSize, TimeWindow};

use super::whole::{extent, sensor_of};
use super::{SensorOrigin, input, source};
use crate::{Columns, EventSource, IoError, OpenOptions};

/// Maximal delay of an event in the file behind its place in time, up to which it is sorted.
const MAX_DELAY_US: i64 = 10_000;

/// A recording that is read window by window, forward or from place to place.
///
/// Events that stand up to 10 ms behind where they belong in time are put there; those that come
/// when their window has been given are counted as out of order, and those outside the sensor as
/// that.
pub struct Windows {
    source: Box<dyn EventSource>,
    sensor: SensorSize,
    sensor_origin: SensorOrigin,
    /// Events that were read and not yet discarded, in the order of the file.
    buffer: Columns,
    /// Everything of the file before this time is in `buffer` or was discarded.
    read_to: Micros,
    /// End of the discarded part.
    left_to: Micros,
    is_at_end: bool,
    rejected: Rejected,
    straggling: u64,
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
        Self::from_source(source, options)
    }

    /// Takes a source that nothing was read from.
    ///
    /// # Errors
    /// If the first events cannot be read.
    pub fn from_source(
        source: Box<dyn EventSource>,
        options: &OpenOptions,
    ) -> Result<Self, IoError> {
        let mut windows = Self {
            source,
            sensor: SensorSize { width: 1, height: 1 },
            sensor_origin: SensorOrigin::Inferred,
            buffer: Columns::new(),
            read_to: Micros(i64::MIN),
            left_to: Micros(i64::MIN),
            is_at_end: false,
            rejected: Rejected::default(),
            straggling: 0,
            salvages: options.salvage,
            lost: None,
        };
        // The first events are read now: a file that does not state its sensor is sized by them.
        windows.read_on()?;
        let header = windows.source.header();
        // Later events may lie outside of the size: they are rejected.
        (windows.sensor, windows.sensor_origin) =
            sensor_of(header, options, || extent(&windows.buffer));
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
        self.buffer.t.iter().copied().min()
    }

    /// Events left out so far.
    pub fn rejected(&self) -> Rejected {
        self.rejected
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
        self.go_to(self.start().unwrap_or(latest))?;
        Ok(latest)
    }

    /// Time of the first event at `t` or later among those that were read ahead, or `t`: what lies
    /// between is empty. After [`Windows::is_over_at`] there is one, unless the recording is over.
    pub fn next_after(&self, t: Micros) -> Micros {
        self.buffer.t.iter().copied().filter(|&at| at >= t).min().unwrap_or(t)
    }

    /// Remarks on the content read so far, in sentences without a full stop.
    pub fn remarks(&self) -> Vec<String> {
        self.source.remarks().into_iter().chain(self.lost.clone()).collect()
    }

    /// Events read so far that stood more than 10 ms behind an earlier one, whether or not they
    /// could be put where they belong. Where there are any, reading the recording whole may give
    /// more.
    pub fn straggling(&self) -> u64 {
        self.straggling
    }

    /// Whether there are no events at `t` or later.
    ///
    /// # Errors
    /// If the file cannot be read up to there.
    pub fn is_over_at(&mut self, t: Micros) -> Result<bool, IoError> {
        while !self.is_at_end && self.buffer.t.iter().all(|&at| at < t) {
            self.read_on()?;
        }
        Ok(self.buffer.t.iter().all(|&at| at < t))
    }

    /// Replaces what is in `events` by the events of `window`.
    ///
    /// Windows that follow each other read the file once; others go to where they are by its index.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged before the end of the window.
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
        // Events may stand behind later ones, by this much.
        while !self.is_at_end && self.read_to.0 < window.end.0.saturating_add(MAX_DELAY_US) {
            self.read_on()?;
        }
        self.leave_behind(window.start);
        let mut inside: Vec<usize> =
            (0..self.buffer.len()).filter(|&k| window.contains(self.buffer.t[k])).collect();
        // Stable: events of one time keep their order.
        inside.sort_by_key(|&k| self.buffer.t[k]);
        events.clear();
        for k in inside {
            if events.push(self.buffer.event(k)).is_err() {
                self.rejected.outside_sensor += 1;
            }
        }
        Ok(())
    }

    /// Goes where reading on gives every event from `t` on.
    fn go_to(&mut self, t: Micros) -> Result<(), IoError> {
        self.source.seek(Micros(t.0.saturating_sub(MAX_DELAY_US)))?;
        self.buffer.clear();
        // Events before `t` are not out of order behind a seek.
        (self.read_to, self.left_to) = (Micros(i64::MIN), Micros(i64::MIN));
        self.is_at_end = false;
        Ok(())
    }

    /// Reads a batch.
    fn read_on(&mut self) -> Result<(), IoError> {
        let before = self.buffer.len();
        let mut buffer = std::mem::take(&mut self.buffer);
        let read = self.next_batch(&mut buffer);
        self.buffer = buffer;
        read?;
        for &t in &self.buffer.t[before..] {
            // Windows up to `left_to` have been given away: an event before that comes too late.
            self.rejected.out_of_order += usize::from(t < self.left_to);
            self.straggling += u64::from(t.0 < self.read_to.0.saturating_sub(MAX_DELAY_US));
            self.read_to = self.read_to.max(t);
        }
        Ok(())
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
        Ok(())
    }

    /// Forgets what is before `t`.
    fn leave_behind(&mut self, t: Micros) {
        self.left_to = self.left_to.max(t);
        if self.buffer.t.iter().any(|&at| at < t) {
            self.buffer = self.buffer.iter().filter(|event| event.t >= t).collect();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

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
        assert!(found == whole && windows.rejected().total() == 0 && windows.straggling() == 0);
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
    fn an_event_a_little_late_is_put_where_it_belongs_and_a_straggler_is_reported() {
        let mut few = windows("4 3\n0 1 1 1\n9000 1 1 1\n4000 2 1 1\n", false).unwrap();
        let times: Vec<i64> = within(&mut few, 0, 10_000).iter().map(|event| event.t.0).collect();
        assert_eq!((times, few.straggling()), (vec![0, 4_000, 9_000], 0));
        let far = windows("4 3\n90000 1 1 1\n5 1 1 1\n", false).unwrap();
        assert_eq!(far.straggling(), 1);
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
