//! Assignment of the arrays of an archive to time, column, row and polarity.

use evpose_core::{Micros, Polarity};

use super::NpzFault;
use super::array::Array;
use super::column::Column;
use crate::names::{Places, places};
use crate::sniff::{ORDERS, fitting_orders};
use crate::{Columns, OpenOptions, TimeUnit};

/// Times from which on their values show their type.
const MANY: usize = 20;
/// Times of this many seconds are none: they are microseconds.
const LONGEST_S: f64 = 1e5;

/// The columns of events: times, columns, rows, polarities.
pub(super) struct Named {
    pub(super) columns: [Column; 4],
    /// Unit of times, where it is stated.
    pub(super) unit: Option<TimeUnit>,
}

/// Events, and a remark on them.
pub(super) type Read = (Columns, Option<String>);

/// A fault and the number of values before it.
type Fault = (NpzFault, usize);

/// Columns of time, column, row and polarity of a recording.
pub(crate) const REQUIRED: [&str; 4] = ["t", "x", "y", "p"];

impl Named {
    /// The columns of one array that holds all.
    pub(super) fn of_table(mut table: Array, options: &OpenOptions) -> Result<Self, NpzFault> {
        let indices = options.columns.indices();
        let (places, unit) = match (table.names.as_slice(), indices) {
            ([], Some(indices)) if indices.iter().all(|n| *n < table.columns.len()) => {
                (indices, None)
            }
            ([], _) => (places_by_content(&table)?, None),
            (names, _) => {
                let found = places(&names.iter().map(String::as_str), &options.columns);
                let Places { places, unit } = found.map_err(|missing| {
                    let (missing, found) = (REQUIRED[missing[0]], names.join(", "));
                    NpzFault::Columns(format!(
                        "no field {missing} (found: {found}): say which it is, as --columns \
                         {missing}=NAME"
                    ))
                })?;
                (places, unit)
            }
        };
        // No name is that of two, and no place in an order either.
        let mut column =
            |place: usize| std::mem::replace(&mut table.columns[place], Column::Bytes(Vec::new()));
        Ok(Self { columns: places.map(&mut column), unit: options.time_unit.or(unit) })
    }

    /// A remark on times that were stored as floats of 32 bits, if these are coarser than 1 µs.
    fn coarse_times(&self) -> Option<String> {
        let column = &self.columns[0];
        if !matches!(column, Column::Real(_)) {
            return None;
        }
        let values = || (0..column.len()).map(|k| column.real(k));
        let is_short = column.len() >= MANY
            && values().all(|value| f64::from(value as f32).to_bits() == value.to_bits());
        let longest = values().fold(0.0, |longest: f64, value| longest.max(value.abs()));
        let has_fraction = values().any(|value| value.fract() != 0.0);
        let usual = if has_fraction && longest <= LONGEST_S { 1e6 } else { 1.0 };
        let unit_us = self.unit.map_or(usual, TimeUnit::microseconds);
        // A float of 32 bits has 24 binary digits.
        let step_us = longest * unit_us / f64::from(1 << 23);
        (is_short && step_us > 1.0).then(|| {
            format!("times are floats of 32 bits, which are {step_us:.0} µs apart: store them as f8 or i8")
        })
    }

    /// The events, and a remark on them. A fault comes with the place of its column and the number of
    /// values before it.
    ///
    /// Times are microseconds if they are integers, or floats that all have no fraction; else
    /// seconds, unless that were days.
    pub(super) fn events(self) -> Result<Read, (usize, NpzFault, usize)> {
        let remark = self.coarse_times();
        let of = self.columns[0].len();
        for (what, column) in self.columns.iter().enumerate() {
            let got = column.len();
            if got != of {
                return Err((what, NpzFault::Length { got, of }, got.min(of)));
            }
        }
        let [t, x, y, p] = self.columns;
        let of_column = |what| move |(fault, values): Fault| (what, fault, values);
        let columns = Columns {
            t: times(t, self.unit).map_err(of_column(0))?,
            x: coordinates(x).map_err(of_column(1))?,
            y: coordinates(y).map_err(of_column(2))?,
            polarity: polarities(p).map_err(of_column(3))?,
        };
        Ok((columns, remark))
    }
}

fn places_by_content(table: &Array) -> Result<[usize; 4], NpzFault> {
    if table.columns.len() < 4 {
        let columns = table.columns.len();
        return Err(NpzFault::Columns(format!("{columns} columns, an event has four: t, x, y, p")));
    }
    let real = |column: &Column| (0..column.len()).map(|k| column.real(k)).collect();
    let columns: Vec<Vec<f64>> = table.columns.iter().map(real).collect();
    fitting_orders(&columns).last().copied().ok_or_else(|| {
        let known = ORDERS.map(|(_, name)| name).join("; ");
        NpzFault::Columns(format!(
            "its columns are in none of the usual orders ({known}): say where they are, as --columns \
             t=2,x=0,y=1,p=3"
        ))
    })
}

fn times(column: Column, unit: Option<TimeUnit>) -> Result<Vec<Micros>, Fault> {
    if let Some(unit) = unit {
        let time = |k: usize| match column.whole(k) {
            Some(value) => unit.whole(value),
            None => unit.real(column.real(k)),
        };
        return (0..column.len()).map(|k| time(k).ok_or_else(|| fault(&column, k))).collect();
    }
    let seconds = match column {
        // The same memory, of another type.
        Column::Whole(values) => return Ok(values.into_iter().map(Micros).collect()),
        Column::Real(values) => values,
        other => return all(&other, |us| us.map(Micros)),
    };
    // Reals may be whole microseconds, or seconds with a fraction.
    let column = Column::Real(seconds);
    let n = column.len();
    let is_whole = (0..n).all(|k| column.whole(k).is_some());
    let longest = (0..n).map(|k| column.real(k).abs()).fold(0.0, f64::max);
    if is_whole {
        return all(&column, |us| us.map(Micros));
    }
    // No recording lasts this many seconds: such values are microseconds.
    let unit_us = if longest > LONGEST_S { 1.0 } else { 1e6 };
    let time = |k: usize| {
        let us = (column.real(k) * unit_us).round();
        (us.abs() < 9e18).then_some(Micros(us as i64)).ok_or_else(|| fault(&column, k))
    };
    (0..n).map(time).collect()
}

/// A coordinate that fits no sensor becomes one that lies outside every sensor.
fn coordinates(column: Column) -> Result<Vec<u16>, Fault> {
    let outside = |value: i64| u16::try_from(value).unwrap_or(u16::MAX);
    match column {
        Column::Short(values) => Ok(values),
        Column::Whole(values) => Ok(values.iter().map(|&value| outside(value)).collect()),
        other => all(&other, |value| value.map(outside)),
    }
}

fn polarities(column: Column) -> Result<Vec<Polarity>, Fault> {
    match column {
        Column::Bytes(values) if values.iter().fold(0, |any, &value| any | value) <= 1 => {
            Ok(values.into_iter().map(|value| Polarity::from_on(value == 1)).collect())
        }
        other => all(&other, |value| match value {
            // -1 as integers without a sign, of 8 and of 32 bits, too.
            Some(0 | -1 | 255 | 4_294_967_295) => Some(Polarity::Off),
            Some(1) => Some(Polarity::On),
            _ => None,
        }),
    }
}

/// All values of a column, or the fault of the first that is none.
fn all<T>(column: &Column, value: impl Fn(Option<i64>) -> Option<T>) -> Result<Vec<T>, Fault> {
    let value = |k| value(column.whole(k)).ok_or_else(|| fault(column, k));
    (0..column.len()).map(value).collect()
}

/// The fault of value number `k`.
fn fault(column: &Column, k: usize) -> Fault {
    let fault = match column.whole(k) {
        Some(value) => NpzFault::Value(value),
        None => NpzFault::Real(column.real(k).to_string()),
    };
    (fault, k)
}
