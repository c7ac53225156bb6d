//! Batches of events from the tables of a file.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

use evpose_core::{Micros, Polarity};
use hdf5_reader::Hdf5File;
use hdf5_reader::error::Error;

use super::bytes::Bytes;
use super::layout::{self, Column, Layout, LayoutError};
use super::table::{Damage, Table};
use crate::{Columns, EventSource, Header, Input, IoError, OpenOptions, TimeUnit};

/// Minimal count of events in a batch, except at the end.
const MIN_BATCH: usize = 1 << 14;
/// Maximal count of rows that are decoded together.
const MAX_ROWS: u64 = 1 << 16;
/// Times with a fraction are microseconds if they exceed this...
const MAX_RECORDING_S: f64 = 1e5;
/// ...unless they are seconds of the calendar, of the years 2001 to 2096.
const CALENDAR_S: std::ops::Range<f64> = 1e9..4e9;

/// Opens a file.
pub(super) fn open(input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let path = input.path.clone();
    let bytes = Arc::new(Bytes::new(input));
    let failed = |error: LayoutError| match error {
        LayoutError::Structure(Error::Io(source)) => IoError::file(&path, "read", source),
        LayoutError::Structure(error) => {
            let byte = bytes.within(offset(&error).unwrap_or(bytes.last()));
            IoError::damaged(&path, byte, error.to_string())
        }
        LayoutError::Rows(Damage { byte, reason }) => IoError::damaged(&path, byte, reason),
        LayoutError::Camera(reason) => IoError::Stream { path: path.clone(), reason },
    };
    // Chunks of events do not pass through the reader's cache.
    let reader = hdf5_reader::OpenOptions::default().with_chunk_cache_bytes(0);
    let file = Hdf5File::from_storage_with_options(Arc::<Bytes>::clone(&bytes), reader);
    let file = file.map_err(|error| failed(error.into()))?;
    let layout = layout::find(&file, &bytes, options).map_err(failed)?;
    let unit = options.time_unit.or(layout.unit);
    let mut source = Hdf5Source::new(path.clone(), layout);
    if let Some(unit) = unit {
        source.unit = unit;
        source.unit_us = unit.microseconds();
    }
    // Of times that are floats, the first and the last ones decide where no unit is stated.
    source.detect_unit(unit.is_none()).map_err(|damage| source.damaged(damage))?;
    Ok(Box::new(source))
}

/// Offset that an error of the reader states.
fn offset(error: &Error) -> Option<u64> {
    match error {
        Error::UnexpectedEof { offset, .. } => Some(*offset),
        Error::Context { source, .. } => offset(source),
        _ => None,
    }
}

/// A file of events, read chunk by chunk.
struct Hdf5Source {
    path: PathBuf,
    header: Header,
    remarks: Vec<String>,
    tables: Vec<Table>,
    columns: [Column; 4],
    t_offset: i64,
    /// Unit of whole times.
    unit: TimeUnit,
    /// Microseconds in a unit of times with a fraction.
    unit_us: f64,
    /// The row to read next.
    row: u64,
    /// Rows that all tables have.
    rows: u64,
    /// Reported at the end: tables with more rows.
    longer: Option<String>,
}

impl Hdf5Source {
    fn new(path: PathBuf, layout: Layout) -> Self {
        let Layout { tables, columns, t_offset, header, remarks, .. } = layout;
        // A recorder that was stopped leaves columns of unequal lengths: events end with the
        // shortest.
        let rows = tables.iter().map(|table| table.rows).min().unwrap_or(0);
        let lengths = tables.iter().map(|table| format!("{} of {}", table.rows, table.name));
        let is_longer = tables.iter().any(|table| table.rows > rows);
        let longer = is_longer.then(|| {
            format!("columns of unequal lengths: {}", lengths.collect::<Vec<_>>().join(", "))
        });
        Self {
            path,
            header,
            remarks,
            tables,
            columns,
            t_offset,
            unit: TimeUnit::Microseconds,
            unit_us: 1.0,
            row: 0,
            rows,
            longer,
        }
    }

    /// Detects the unit of times by the first and the last of them, if they may have a fraction and it is not stated;
    /// remarks on floats of 32 bits that are coarser than 1 µs.
    fn detect_unit(&mut self, is_unknown: bool) -> Result<(), Damage> {
        let Column { table, number } = self.columns[0];
        let table = &mut self.tables[table];
        if !number.is_real() || self.rows == 0 {
            return Ok(());
        }
        let (mut times, mut damage) = (Vec::new(), None);
        // The last row has the longest time, and of a cut file only the first can be read.
        for row in [0, self.rows - 1] {
            match table.load_row(row) {
                Ok(rows) => {
                    times.extend(number.values(table.rows(row, rows.min(MAX_ROWS)), table.row));
                }
                Err(error) => damage = Some(error),
            }
        }
        let longest = times.iter().fold(0.0, |longest: f64, t| longest.max(t.abs()));
        let has_fraction = times.iter().any(|t| t.fract() != 0.0);
        let is_seconds = longest <= MAX_RECORDING_S || CALENDAR_S.contains(&longest);
        if is_unknown {
            self.unit_us = if has_fraction && is_seconds { 1e6 } else { 1.0 };
        }
        // A float of 32 bits has 24 binary digits.
        let step_us = longest * self.unit_us / f64::from(1 << 23);
        if number.size() == 4 && step_us > 1.0 {
            self.remarks.push(format!(
                "times are floats of 32 bits, which are {step_us:.0} µs apart: store them as f8 or i8"
            ));
        }
        match damage {
            // Too few rows are readable for a decision.
            Some(damage) if is_unknown && is_seconds && !has_fraction => Err(damage),
            // Reported when reading comes there.
            _ => Ok(()),
        }
    }

    fn damaged(&self, Damage { byte, reason }: Damage) -> IoError {
        IoError::damaged(&self.path, byte, reason).behind(self.row)
    }

    /// Appends the rows from here on whose chunks are loaded in all tables.
    fn part(&mut self, columns: &mut Columns) -> Result<(), Damage> {
        let mut rows = MAX_ROWS.min(self.rows - self.row);
        for table in &mut self.tables {
            // Chunks of the columns may end at different rows.
            rows = rows.min(table.load_row(self.row)?);
        }
        let packed = self.tables.iter().find_map(|table| Some((table, table.events(self.row)?)));
        if let Some((table, (events, at))) = packed {
            // ECF packs whole events: a dataset of one column cannot be of that.
            if self.tables.len() > 1 {
                return Err(table.damage(self.row, "one column, packed as whole events"));
            }
            let to = at + rows as usize;
            columns.t.extend_from_slice(&events.t[at..to]);
            columns.x.extend_from_slice(&events.x[at..to]);
            columns.y.extend_from_slice(&events.y[at..to]);
            columns.polarity.extend_from_slice(&events.polarity[at..to]);
            self.row += rows;
            return Ok(());
        }
        let before = columns.len();
        let faulty = self.decode(rows, columns);
        self.row += (columns.len() - before) as u64;
        match faulty {
            Some((what, reason)) => {
                Err(self.tables[self.columns[what].table].damage(self.row, &reason))
            }
            None => Ok(()),
        }
    }

    /// Appends loaded rows up to the first with a value that no event has; returns the column of
    /// that value and the reason.
    fn decode(&self, rows: u64, columns: &mut Columns) -> Option<(usize, String)> {
        let (before, rows) = (columns.len(), rows as usize);
        columns.t.resize(before + rows, Micros(0));
        columns.x.resize(before + rows, 0);
        columns.y.resize(before + rows, 0);
        columns.polarity.resize(before + rows, Polarity::Off);
        self.fill(self.row, before, columns)?;
        // Row by row, to find the faulty one.
        for k in 0..rows {
            let mut one = Columns::new();
            one.push(columns.event(before + k));
            if let Some(what) = self.fill(self.row + k as u64, 0, &mut one) {
                columns.truncate(before + k);
                let name = ["time", "column", "row", "polarity"][what];
                let Column { table, number } = self.columns[what];
                let table = &self.tables[table];
                let value = number.values(table.rows(self.row + k as u64, 1), table.row);
                let value = value.first().copied().unwrap_or_default();
                return Some((what, format!("{value} is no {name} of an event")));
            }
        }
        None
    }

    /// Overwrites the events from `at` on with the rows from `row` on; returns the first column
    /// with a value that no event has.
    fn fill(&self, row: u64, at: usize, columns: &mut Columns) -> Option<usize> {
        let rows = (columns.len() - at) as u64;
        let [t, x, y, p] = self.columns.map(|Column { table, number }| {
            let table = &self.tables[table];
            (table.rows(row, rows), table.row, number)
        });
        let mut is_good = [true; 4];
        let (bytes, size, number) = t;
        let times = &mut columns.t[at..];
        if number.is_real() {
            let (unit_us, offset) = (self.unit_us, self.t_offset);
            let mut is_time = true;
            number.floats(bytes, size, times, |value| {
                let us = (value * unit_us).round();
                // Little above this a cast to 64 bits would saturate.
                is_time &= us.abs() < 9e18;
                Micros((us as i64).wrapping_add(offset))
            });
            is_good[0] = is_time;
        } else {
            let (unit, offset) = (self.unit, self.t_offset);
            let time = |value: i64| Some(Micros(unit.whole(value)?.0.wrapping_add(offset)));
            // No clock reaches the value that stands for none.
            is_good[0] = number
                .whole(bytes, size, times, |value| time(value).unwrap_or(Micros(i64::MIN)))
                && times.iter().all(|t| t.0 > i64::MIN);
        }
        // A coordinate that fits no sensor becomes one that lies outside every sensor.
        let pixel = |value: i64| u16::try_from(value).unwrap_or(u16::MAX);
        is_good[1] = x.2.whole(x.0, x.1, &mut columns.x[at..], pixel);
        is_good[2] = y.2.whole(y.0, y.1, &mut columns.y[at..], pixel);
        let mut is_polarity = true;
        let is_whole = p.2.whole(p.0, p.1, &mut columns.polarity[at..], |value| {
            // Off is 0 or -1, which as an integer without a sign is the largest.
            let is_off = [0, -1, 0xff, 0xffff_ffff].contains(&value);
            is_polarity &= is_off || value == 1;
            Polarity::from_on(!is_off)
        });
        is_good[3] = is_polarity && is_whole;
        is_good.iter().position(|is_good| !is_good)
    }

    /// The time of a row; none where the file is damaged.
    fn time(&mut self, row: u64) -> Option<Micros> {
        let Column { table, number } = self.columns[0];
        let table = &mut self.tables[table];
        table.load_row(row).ok()?;
        // A chunk of ECF was decoded as it was loaded: its bytes are no rows.
        if let Some((events, at)) = table.events(row) {
            return events.t.get(at).copied();
        }
        let (bytes, size, unit_us) = (table.rows(row, 1), table.row, self.unit_us);
        let mut us = [0];
        if number.is_real() {
            number.floats(bytes, size, &mut us, |value| (value * unit_us).round() as i64);
        } else {
            number.whole(bytes, size, &mut us, |value| value);
            let t = self.unit.whole(us[0])?;
            return Some(Micros(t.0.wrapping_add(self.t_offset)));
        }
        Some(Micros(us[0].wrapping_add(self.t_offset)))
    }
}

impl EventSource for Hdf5Source {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        while columns.len() - before < MIN_BATCH && self.row < self.rows {
            self.part(columns).map_err(|damage| self.damaged(damage))?;
        }
        match &self.longer {
            // Only when all whole rows have been given: the fault is what follows them.
            Some(reason) if columns.len() == before => {
                let byte = self.tables.first().map_or(0, Table::chunk_byte);
                let reason = Cow::Owned(reason.clone());
                Err(self.damaged(Damage { byte, reason }))
            }
            _ => Ok(()),
        }
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        // Bisection by the first event of chunks. Damage is reported when reading comes there.
        let step = self.tables[self.columns[0].table].chunk_rows();
        let (mut low, mut high) = (0, self.rows.div_ceil(step));
        while low < high {
            let middle = low + (high - low) / 2;
            match self.time(middle * step) {
                Some(first) if first < t => low = middle + 1,
                _ => high = middle,
            }
        }
        self.row = low.saturating_sub(1) * step;
        Ok(())
    }

    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }
}
