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
//! one array `events`: of records with such fields, or of four columns in the order `t x y p`, `x y
//! t p`, `x y p t` or `t p x y`, detected by their content. A single such array in an `.npy` file
//! is read as well. Floating-point times without any fraction are microseconds.

mod array;
mod events;
mod fault;
mod reader;
mod writer;

pub(crate) use array::header;
#[cfg(feature = "hdf5")]
pub(crate) use events::{ORDERS, REQUIRED, array_by_name};
pub use fault::NpzFault;

use crate::open::{Format, no_labels};

/// The archive's entry in the registry of formats.
pub(crate) const FORMAT: Format = Format {
    name: "npz",
    summary: "NumPy archive: t, x, y, p, width, height",
    endings: &[".npz"],
    probe: |head| {
        [b"PK\x03\x04", b"PK\x05\x06"].iter().any(|begin| head.starts_with(*begin))
            || head.starts_with(ARRAY)
    },
    open: reader::open,
    create: Some(writer::create),
    labels: no_labels,
};

/// How a single array begins.
const ARRAY: &[u8; 6] = b"\x93NUMPY";

#[cfg(test)]
mod tests;
