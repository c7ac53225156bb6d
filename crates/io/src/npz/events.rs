//! Assignment of the arrays of an archive to time, column, row and polarity.

use evpose_core::{Micros, Polarity};

use super::NpzFault;
use super::array::Array;
use super::column::Column;
use crate::Columns;
use crate::sniff::is_time;

/// The names that programs give to what an event has.
const NAMES: [&[&str]; 4] = [
    &["t", "ts", "timestamp", "timestamps", "time", "times"],
    &["x", "xs", "col", "cols"],
    &["y", "ys", "row", "rows"],
    &["p", "ps", "pol", "polarity", "polarities"],
];
/// Orders of columns without names, as places of t, x, y and p.
pub(crate) const ORDERS: [([usize; 4], &str); 4] = [
    ([0, 1, 2, 3], "t x y p"),
    ([2, 0, 1, 3], "x y t p"),
    ([3, 0, 1, 2], "x y p t"),
    ([0, 2, 3, 1], "t p x y"),
];
/// Times of this many seconds are none: they are microseconds.
const LONGEST_S: f64 = 1e5;

/// The columns of events: times, columns, rows, polarities.
pub(super) struct Named(pub(super) [Column; 4]);

/// A fault and the number of values before it.
type Fault = (NpzFault, usize);

/// The first of `names` that is a usual one of column `what` (0 time, 1 column, 2 row, 3 polarity).
pub(crate) fn array_by_name<'n>(
    what: usize,
    names: &(impl Iterator<Item = &'n str> + Clone),
) -> Option<&'n str> {
    NAMES[what].iter().find_map(|name| names.clone().find(|known| known == name))
}

/// Columns of time, column, row and polarity of a recording.
pub(crate) const REQUIRED: [&str; 4] = ["t", "x", "y", "p"];

impl Named {
    /// The columns of one array that holds all.
    pub(super) fn of_table(mut table: Array) -> Result<Self, NpzFault> {
        let places = match table.names.as_slice() {
            [] => places_by_content(&table)?,
            names => places_by_name(names)?,
        };
        // No name is that of two, and no place in an order either.
        let mut column =
            |place: usize| std::mem::replace(&mut table.columns[place], Column::Bytes(Vec::new()));
        Ok(Self(places.map(&mut column)))
    }

    /// The events. A fault comes with the place of its column and the number of values before it.
    ///
    /// Times are microseconds if they are integers, or floats that all have no fraction; else
    /// seconds, unless that were days.
    pub(super) fn events(self) -> Result<Columns, (usize, NpzFault, usize)> {
        let of = self.0[0].len();
        for (what, column) in self.0.iter().enumerate() {
            let got = column.len();
            if got != of {
                return Err((what, NpzFault::Length { got, of }, got.min(of)));
            }
        }
        let [t, x, y, p] = self.0;
        let of_column = |what| move |(fault, values): Fault| (what, fault, values);
        Ok(Columns {
            t: times(t).map_err(of_column(0))?,
            x: coordinates(x).map_err(of_column(1))?,
            y: coordinates(y).map_err(of_column(2))?,
            polarity: polarities(p).map_err(of_column(3))?,
        })
    }
}

fn places_by_name(names: &[String]) -> Result<[usize; 4], NpzFault> {
    let mut places = [0; 4];
    for (what, place) in places.iter_mut().enumerate() {
        let known = names.iter().map(String::as_str);
        let name = array_by_name(what, &known).ok_or_else(|| {
            let (missing, found) = (REQUIRED[what], names.join(", "));
            NpzFault::Columns(format!("no field {missing} (found: {found})"))
        })?;
        *place = names.iter().position(|found| found == name).unwrap_or(0);
    }
    Ok(places)
}

fn places_by_content(table: &Array) -> Result<[usize; 4], NpzFault> {
    if table.columns.len() < 4 {
        let columns = table.columns.len();
        return Err(NpzFault::Columns(format!("{columns} columns, an event has four: t, x, y, p")));
    }
    let values = |column: usize| {
        let column = &table.columns[column];
        (0..column.len()).map(|k| column.real(k))
    };
    let fits = |(order, _): &&([usize; 4], &str)| {
        let [t, x, y, p] = *order;
        let is_pixel = |column| values(column).all(|v| (0.0..65_536.0).contains(&v));
        values(p).all(|value| [0.0, 1.0, -1.0].contains(&value))
            && is_pixel(x)
            && is_pixel(y)
            && is_time(&values(t))
    };
    // Of several that fit, the one whose times reach furthest: few columns go from one end of
    // a sensor to the other.
    let span = |(order, _): &([usize; 4], &str)| {
        let ends = |pick: fn(f64, f64) -> f64, from| values(order[0]).fold(from, pick);
        ends(f64::max, f64::MIN) - ends(f64::min, f64::MAX)
    };
    let fitting = ORDERS.iter().rev().filter(fits);
    let found = fitting.max_by(|a, b| span(a).total_cmp(&span(b))).ok_or_else(|| {
        let known = ORDERS.map(|(_, name)| name).join("; ");
        NpzFault::Columns(format!("its columns are in none of the usual orders: {known}"))
    })?;
    Ok(found.0)
}

fn times(column: Column) -> Result<Vec<Micros>, Fault> {
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
            Some(0 | -1) => Some(Polarity::Off),
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
