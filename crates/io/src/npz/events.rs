//! Assignment of the arrays of an archive to time, column, row and polarity.

use evpose_core::{Micros, Polarity};

use super::NpzFault;
use super::array::{Array, Column};
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
pub(super) struct Named<'a>(pub(super) [&'a Column; 4]);

/// The first of `names` that is a usual one of column `what` (0 time, 1 column, 2 row, 3 polarity).
pub(crate) fn array_by_name<'n>(
    what: usize,
    names: &(impl Iterator<Item = &'n str> + Clone),
) -> Option<&'n str> {
    NAMES[what].iter().find_map(|name| names.clone().find(|known| known == name))
}

/// Columns of time, column, row and polarity of a recording.
pub(crate) const REQUIRED: [&str; 4] = ["t", "x", "y", "p"];

impl<'a> Named<'a> {
    /// The columns of one array that holds all.
    pub(super) fn of_table(table: &'a Array) -> Result<Self, NpzFault> {
        if !table.names.is_empty() {
            let mut places = [0; 4];
            for (what, place) in places.iter_mut().enumerate() {
                let names = table.names.iter().map(String::as_str);
                let name = array_by_name(what, &names).ok_or_else(|| {
                    let (missing, found) = (REQUIRED[what], table.names.join(", "));
                    NpzFault::Columns(format!("no field {missing} (found: {found})"))
                })?;
                *place = names.clone().position(|found| found == name).unwrap_or(0);
            }
            return Ok(Self(places.map(|place| &table.columns[place])));
        }
        if table.columns.len() < 4 {
            return Err(NpzFault::Columns(format!(
                "{} columns, an event has four: t, x, y, p",
                table.columns.len()
            )));
        }
        let values = |column: &'a Column| (0..column.len()).map(|k| column.real(k));
        let fits = |(order, _): &&([usize; 4], &str)| {
            let [t, x, y, p] = order.map(|place| &table.columns[place]);
            let is_pixel = |column| values(column).all(|v| (0.0..65_536.0).contains(&v));
            values(p).all(|value| [0.0, 1.0, -1.0].contains(&value))
                && is_pixel(x)
                && is_pixel(y)
                && is_time(&values(t))
        };
        // Of several that fit, the one whose times reach furthest: few columns go from one end of
        // a sensor to the other.
        let span = |(order, _): &([usize; 4], &str)| {
            let t = &table.columns[order[0]];
            let ends = |pick: fn(f64, f64) -> f64, from| values(t).fold(from, pick);
            ends(f64::max, f64::MIN) - ends(f64::min, f64::MAX)
        };
        let fitting = ORDERS.iter().rev().filter(fits);
        let found = fitting.max_by(|a, b| span(a).total_cmp(&span(b))).ok_or_else(|| {
            let known = ORDERS.map(|(_, name)| name).join("; ");
            NpzFault::Columns(format!("its columns are in none of the usual orders: {known}"))
        })?;
        Ok(Self(found.0.map(|place| &table.columns[place])))
    }

    /// The events. A fault comes with the place of its column and the number of values before it.
    ///
    /// Times are microseconds if they are integers, or floats that all have no fraction; else
    /// seconds, unless that were days.
    pub(super) fn events(&self) -> Result<Columns, (usize, NpzFault, usize)> {
        let [t, x, y, p] = self.0;
        for (what, column) in self.0.iter().enumerate() {
            if column.len() != t.len() {
                let fault = NpzFault::Length { got: column.len(), of: t.len() };
                return Err((what, fault, column.len().min(t.len())));
            }
        }
        let n = t.len();
        let is_whole = (0..n).all(|k| t.whole(k).is_some());
        let longest = (0..n).map(|k| t.real(k).abs()).fold(0.0, f64::max);
        let unit_us = if is_whole || longest > LONGEST_S { 1.0 } else { 1e6 };
        let time = |k: usize| match t.whole(k).filter(|_| is_whole) {
            Some(us) => Some(Micros(us)),
            None => {
                let us = (t.real(k) * unit_us).round();
                (us.abs() < 9e18).then_some(Micros(us as i64))
            }
        };
        // A coordinate that fits no sensor becomes one that lies outside every sensor.
        let place = |column: &Column, k: usize| {
            column.whole(k).map(|value| u16::try_from(value).unwrap_or(u16::MAX))
        };
        let polarity = |k: usize| match p.whole(k) {
            Some(0 | -1) => Some(Polarity::Off),
            Some(1) => Some(Polarity::On),
            _ => None,
        };
        let read = || {
            let (t, x) = (all(0, n, time)?, all(1, n, |k| place(x, k))?);
            let (y, polarity) = (all(2, n, |k| place(y, k))?, all(3, n, polarity)?);
            Ok(Columns { t, x, y, polarity })
        };
        read().map_err(|(what, k): (usize, usize)| {
            let fault = match self.0[what].whole(k) {
                Some(value) => NpzFault::Value(value),
                None => NpzFault::Real(self.0[what].real(k).to_string()),
            };
            (what, fault, k)
        })
    }
}

/// All `n` values of a column, or which of them is none.
fn all<T>(
    what: usize,
    n: usize,
    value: impl Fn(usize) -> Option<T>,
) -> Result<Vec<T>, (usize, usize)> {
    (0..n).map(|k| value(k).ok_or((what, k))).collect()
}
