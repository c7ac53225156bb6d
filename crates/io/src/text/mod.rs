//! Events as lines of text, `t x y p`, as the data sets of the Robotics and Perception Group.
//!
//! * The first line may be `width height`, or `%geometry:width,height` as Prophesee's programs write
//!   it; without it the sensor is the smallest that holds every event, and the recording says so.
//! * A line of names before the first event, such as `x,y,p,t`, says in which order the columns
//!   are, among others that are passed over, such as the row index of pandas. Without it they are `t x y p`, or `x y p t` where only that leaves a polarity in its
//!   place.
//! * Times are **seconds** where the first event's time has a `.` or an exponent
//!   (`0.003811 96 133 0`), integer **microseconds** otherwise (`3811 96 133 0`). The first event
//!   that is not at `0` decides for the file.
//! * `p` is 1 for ON and 0 or -1 for OFF. Fields are separated by spaces, tabs, commas or
//!   semicolons. What follows a `#` is a comment, and so is a line that begins with `%`; empty lines
//!   are skipped.
//!
//! Tables separated by commas or semicolons are a format of their own, `csv`. They are written with
//! a line of names, as pandas expects it, and state no sensor.

mod digits;
mod line;
mod quick;
mod reader;
mod writer;

pub use reader::Lines;

use line::TextFault;

use crate::open::{Format, no_labels};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "text",
    summary: "lines of t x y p, t in seconds or microseconds",
    endings: &[".txt", ".text"],
    probe: reader::probe,
    open: reader::open,
    create: Some(writer::create),
    labels: no_labels,
};

/// The registry's entry of tables.
pub(crate) const CSV: Format = Format {
    name: "csv",
    summary: "a line t,x,y,p and such lines; Metavision's x,y,p,t; other orders by names",
    endings: &[".csv"],
    probe: reader::probe_csv,
    open: reader::open,
    create: Some(writer::create_csv),
    labels: no_labels,
};

#[cfg(test)]
mod tests;
