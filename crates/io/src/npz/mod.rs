//! Events as a NumPy archive, the format every Python tool reads and writes.
//!
//! | array | type written | also read | meaning |
//! |---|---|---|---|
//! | `t` | `i64`, microseconds | any integer; `f4`, `f8` in seconds | ascending |
//! | `x`, `y` | `u16` | any type, without a fraction | column from the left, row from the top |
//! | `p` | `u8` | any type, `bool` | 1 = ON, 0 or -1 = OFF |
//! | `width`, `height` | `i64`, a scalar | any integer; may both be missing | the sensor in pixels |
//!
//! Other programs call the arrays `ts`, `xs`, `ys`, `ps`, or `timestamps` and `polarity`, or have
//! one array: of records with such fields, in any order and of any of these types, or of four
//! columns in the order `t x y p`, `x y t p`, `x y p t` or `t p x y`, detected by their content. It
//! is called `events`, or has any name if it is the only one, such as the `arr_0` of `numpy.savez`.
//! Floating-point times without any fraction are microseconds.
//!
//! EVIMO2's archives have `dataset_events_t`, `_xy` and `_p`; as three `.npy` files, any of them, or
//! their folder, stands for all.
//!
//! A single such array in an `.npy` file is a format of its own, `npy`. It is written as records
//! of `t` (`<i8`), `x`, `y` (`<u2`) and `p` (`|u1`), and states no sensor.

mod array;
mod column;
mod events;
mod fault;
mod header_writer;
mod npy_writer;
mod reader;
mod writer;

pub(crate) use array::header;
#[cfg(feature = "hdf5")]
pub(crate) use events::REQUIRED;
pub use fault::NpzFault;
pub(crate) use header_writer::header_for;
pub(crate) use reader::EVIMO;
pub(crate) use writer::start_array;

use crate::open::{Format, no_labels};

/// The archive's entry in the registry of formats.
pub(crate) const FORMAT: Format = Format {
    name: "npz",
    summary: "NumPy archive: t, x, y, p, width, height",
    endings: &[".npz"],
    probe: |head| [b"PK\x03\x04", b"PK\x05\x06"].iter().any(|begin| head.starts_with(*begin)),
    open: reader::open,
    create: Some(writer::create),
    labels: no_labels,
};

/// The single array's entry in the registry of formats.
pub(crate) const NPY: Format = Format {
    name: "npy",
    summary: "NumPy array of records t, x, y, p, or of four columns",
    endings: &[".npy"],
    probe: |head| head.starts_with(ARRAY),
    open: reader::open_array,
    create: Some(npy_writer::create),
    labels: no_labels,
};

/// How a single array begins.
const ARRAY: &[u8; 6] = b"\x93NUMPY";

#[cfg(test)]
mod tests;
