//! The source of a file, its events in the order of time.

use std::path::PathBuf;

use evpose_core::{Micros, SensorSize};

use super::order::{ClockFault, Disorder, MAX_DELAY, Order, is_in_order};
use super::time_check::{TimeCheck, TimeFault};
use super::{EventSource, Header, MemorySource, OpenOptions, Restarts, read_batches};
use crate::{Columns, IoError};

/// Years since 1970 that no clock of a camera has reached.
const MAX_YEARS: f64 = 130.0;
/// Events from which on fewer than ten a second are doubted, and from which on the rates below are.
const MANY: u64 = 100;
const VERY_MANY: u64 = 10_000;
/// Rate of a whole sensor below which a long recording is rather of another unit: noise alone has more.
const FEW_HZ: f64 = 300.0;
/// No bus has sent as many on average.
const MAX_HZ: f64 = 1e8;

/// Whether the first events lie on the sensor, but for a tenth.
fn fits(source: &mut dyn EventSource, sensor: SensorSize) -> bool {
    let mut first = Columns::new();
    // What cannot be read is said by the reader of the events.
    let _ = source.next(&mut first);
    let outside = first.iter().filter(|event| !sensor.contains(event.x, event.y)).count();
    10 * outside <= first.len()
}

/// Wraps the source of a format.
pub(crate) struct OrderedSource {
    inner: Box<dyn EventSource>,
    path: PathBuf,
    restarts: Restarts,
    order: Order,
    batch: Columns,
    is_at_end: bool,
    /// Whether stamps of the file were changed, so that its index does not lead to them.
    is_shifted: bool,
    /// Whether this pass began at the beginning.
    is_whole_pass: bool,
    header: Header,
    swaps_xy: bool,
    /// Whether times count from the first event, and the time of that.
    is_zeroed: bool,
    first: Option<Micros>,
    /// The latest time, and the count of events of this pass.
    last: Micros,
    events: u64,
    time_check: TimeCheck,
    /// Remark on the times of the whole recording.
    doubt: Option<String>,
    /// Of the pass that read most.
    disorder: Disorder,
}

impl OrderedSource {
    /// The events of `inner` in order; those of a file that is to be sorted are read now.
    ///
    /// # Errors
    /// Only where the file is to be sorted: if it cannot be read.
    pub(crate) fn open(
        mut inner: Box<dyn EventSource>,
        path: PathBuf,
        options: &OpenOptions,
    ) -> Result<Box<dyn EventSource>, IoError> {
        let mut header = inner.header().clone();
        if options.swap_xy {
            let swapped = |size: SensorSize| SensorSize { width: size.height, height: size.width };
            // A size that coordinates fit only when they are exchanged is right as it is stated.
            let fits_as_it_is = header.sensor.is_none_or(|stated| fits(&mut *inner, stated));
            inner.seek(Micros(i64::MIN))?;
            header.sensor =
                header.sensor.map(|size| if fits_as_it_is { swapped(size) } else { size });
            header.usual_sensor = header.usual_sensor.map(swapped);
        }
        if options.restarts == Restarts::Sort {
            let mut all = inner.take_all().unwrap_or_default();
            let (mut before, mut lost) = (usize::MAX, None);
            while all.len() != before && lost.is_none() {
                before = all.len();
                match inner.next(&mut all) {
                    Err(damage) if options.salvage && damage.is_damage() => {
                        lost = Some(format!("the rest is lost: {damage}"));
                    }
                    read => read?,
                }
            }
            let early = all.t.windows(2).filter(|pair| pair[1] < pair[0]).count();
            let mut remarks = inner.remarks();
            remarks.extend(lost);
            if early > 0 {
                all.sort();
                remarks.push(format!(
                    "{early} events are earlier than the one before: all are sorted by time"
                ));
            }
            inner = Box::new(MemorySource::new(inner.header().clone(), all, remarks));
        }
        Ok(Box::new(Self {
            inner,
            path,
            restarts: options.restarts,
            order: Order::new(options.restarts),
            batch: Columns::new(),
            is_at_end: false,
            is_shifted: false,
            is_whole_pass: true,
            header,
            swaps_xy: options.swap_xy,
            is_zeroed: options.zero_time,
            first: None,
            last: Micros(i64::MIN),
            events: 0,
            time_check: TimeCheck::default(),
            doubt: None,
            disorder: Disorder::default(),
        }))
    }

    fn fault(&self, fault: ClockFault) -> IoError {
        let path = self.path.clone();
        match fault {
            ClockFault::Restart { event, from, to } => {
                IoError::ClockRestart { path, event, from, to }
            }
            ClockFault::None { strays, events } => IoError::NoOrder { path, strays, events },
        }
    }

    fn note(&mut self) {
        self.is_shifted |= !self.order.is_of_file();
        if self.is_whole_pass {
            self.disorder = self.order.disorder();
        }
    }
}

impl EventSource for OrderedSource {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        let read = self.read_on(columns);
        self.check(&columns.t[before..])?;
        self.adjust(before, columns);
        read
    }

    fn take_all(&mut self) -> Option<Columns> {
        // In order and in one piece: there is nothing to do.
        let mut all = self.inner.take_all()?;
        if is_in_order(&all.t) && !matches!(self.restarts, Restarts::Part(_)) {
            // What is refused is refused by the reader that gets it in batches.
            if self.check(&all.t).is_ok() {
                self.is_at_end = true;
                self.adjust(0, &mut all);
                return Some(all);
            }
            self.time_check = TimeCheck::default();
        }
        let (header, remarks) = (self.inner.header().clone(), self.inner.remarks());
        self.inner = Box::new(MemorySource::new(header, all, remarks));
        None
    }

    fn read_rest(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let is_begun = !self.is_whole_pass || !self.order.is_untouched() || self.is_at_end;
        if is_begun || !columns.is_empty() || matches!(self.restarts, Restarts::Part(_)) {
            return read_batches(self, columns);
        }
        // Most recordings are in order: one look at all is faster than many at a little.
        let (mut read, mut before) = (Ok(()), usize::MAX);
        while read.is_ok() && columns.len() != before {
            before = columns.len();
            read = self.inner.next(columns);
            // In the order of the file, to stop before a crowd fills the memory.
            let checked = self.time_check.check_end(&columns.t[before..]);
            checked.map_err(|fault| self.refused(fault))?;
        }
        // All times are checked once more below, in order, so that this check starts anew.
        self.time_check = TimeCheck::default();
        if !is_in_order(&columns.t) {
            let all = std::mem::take(columns);
            let pushed = self.order.push(&all);
            let given = pushed.and_then(|()| self.order.finish(columns));
            if given.is_err() {
                self.order.give_all(columns);
            }
            self.note();
            if read.is_ok() {
                given.map_err(|fault| self.fault(fault))?;
            }
        }
        self.check(&columns.t)?;
        self.is_at_end = true;
        self.adjust(0, columns);
        read
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        let t = match (self.is_zeroed, self.first) {
            (true, None) => Micros(i64::MIN),
            (true, Some(first)) => Micros(t.0.saturating_add(first.0)),
            (false, _) => t,
        };
        // The index of a file knows its own stamps alone.
        let is_direct = !self.is_shifted && self.order.is_of_file() && t.0 > i64::MIN;
        if !is_direct {
            return self.begin_again();
        }
        self.inner.seek(Micros(t.0.saturating_sub(MAX_DELAY.0)))?;
        self.order = Order::behind_seek(self.restarts);
        (self.is_at_end, self.is_whole_pass) = (false, false);
        self.time_check = TimeCheck::default();
        Ok(())
    }

    fn duration(&self) -> Option<Micros> {
        self.inner.duration()
    }

    fn remarks(&self) -> Vec<String> {
        let doubt = self.doubt.clone();
        self.inner.remarks().into_iter().chain(self.disorder.remarks()).chain(doubt).collect()
    }
}

impl OrderedSource {
    /// Goes to the beginning.
    fn begin_again(&mut self) -> Result<(), IoError> {
        self.inner.seek(Micros(i64::MIN))?;
        self.order = Order::new(self.restarts);
        (self.is_at_end, self.is_whole_pass, self.events) = (false, true, 0);
        self.time_check = TimeCheck::default();
        Ok(())
    }

    /// Appends the next events in order.
    fn read_on(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        while columns.len() == before && !self.is_at_end {
            self.batch.clear();
            let read = self.inner.next(&mut self.batch);
            // What could be read before damage counts.
            let pushed = self.order.push(&self.batch);
            let is_last = (read.is_ok() && self.batch.is_empty()) || self.order.is_over();
            let given = match pushed {
                Ok(()) if is_last || read.is_err() => self.order.finish(columns),
                Ok(()) => {
                    let ready = self.order.ready();
                    // Half of it at least, so that what stays is not moved again and again.
                    if 2 * ready >= self.order.waiting() {
                        self.order.give(ready, columns);
                    }
                    Ok(())
                }
                Err(fault) => {
                    self.order.give_all(columns);
                    Err(fault)
                }
            };
            self.note();
            // Damage explains times without sense.
            read?;
            given.map_err(|fault| self.fault(fault))?;
            if is_last && !self.is_whole_pass && self.order.is_untouched() {
                // Perhaps behind a wraparound, where the index of the file does not lead.
                self.begin_again()?;
                continue;
            }
            self.is_at_end = is_last;
            if let Restarts::Part(part) = self.restarts
                && is_last
                && part > self.order.parts()
            {
                let (path, parts) = (self.path.clone(), self.order.parts());
                return Err(IoError::NoSuchPart { path, part, parts });
            }
        }
        Ok(())
    }

    /// Refuses times in order that no clock has, and crowds.
    fn check(&mut self, times: &[Micros]) -> Result<(), IoError> {
        self.time_check.check(times).map_err(|fault| self.refused(fault))
    }

    fn refused(&self, fault: TimeFault) -> IoError {
        IoError::Stream { path: self.path.clone(), reason: fault.to_string() }
    }

    /// Exchanges coordinates and moves times of the events from `begin` on, as asked.
    fn adjust(&mut self, begin: usize, columns: &mut Columns) {
        if self.swaps_xy {
            for k in begin..columns.len() {
                std::mem::swap(&mut columns.x[k], &mut columns.y[k]);
            }
        }
        let times = &mut columns.t[begin..];
        if let (Some(first), Some(last)) = (times.first(), times.last()) {
            let first = *self.first.get_or_insert(*first);
            self.last = self.last.max(*last);
            self.events += times.len() as u64;
            if self.is_zeroed {
                times.iter_mut().for_each(|t| *t = Micros(t.0.saturating_sub(first.0)));
            }
        }
        // It stays when the reader goes elsewhere.
        if self.is_at_end && self.is_whole_pass {
            self.doubt = self.doubtful();
        }
    }

    /// Whether times can be those of a camera.
    fn doubtful(&self) -> Option<String> {
        let first = self.first?;
        let (seconds, events) = (self.last.as_seconds() - first.as_seconds(), self.events);
        let years = self.last.as_seconds() / (365.25 * 86_400.0);
        let how = "another unit is stated with --time-unit";
        if years > MAX_YEARS {
            return Some(format!("time stamps are of the year {:.0}: {how}", 1970.0 + years));
        }
        let rate_hz = events as f64 / seconds.max(1e-6);
        let doubt = match events {
            ..=MANY => None,
            // A wrong unit makes rates a thousand times too low or too high.
            _ if rate_hz < 10.0 => Some("fewer than ten a second"),
            VERY_MANY.. if rate_hz < FEW_HZ => Some("few for so many"),
            VERY_MANY.. if rate_hz > MAX_HZ => Some("more than any camera sends"),
            _ => None,
        };
        doubt.map(|doubt| format!("{events} events in {seconds:.3} s are {doubt}: {how}"))
    }
}
