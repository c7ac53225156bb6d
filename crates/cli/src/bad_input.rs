//! Errors with exit codes of their own.

/// The input cannot be used; the command ends with code 2.
#[derive(Debug, thiserror::Error)]
#[error("the input cannot be used")]
pub struct BadInput;

/// An inference found nobody, in the words of its message; the command ends with code 3.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct NobodyInView(pub String);
