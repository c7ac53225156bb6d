//! Errors with exit codes of their own.

use std::fmt;

/// The input cannot be used; the command ends with code 2.
#[derive(Debug)]
pub struct BadInput;

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the input cannot be used")
    }
}

impl std::error::Error for BadInput {}

/// An inference found nobody, in the words of its message; the command ends with code 3.
#[derive(Debug)]
pub struct NobodyInView(pub String);

impl fmt::Display for NobodyInView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NobodyInView {}
