//! Input that cannot be used.

use std::fmt;

/// The input cannot be used; the program ends with code 2.
#[derive(Debug)]
pub(crate) struct BadInput;

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the input cannot be used")
    }
}

impl std::error::Error for BadInput {}
