//! What can be asked for that is not there.

use evpose_core::Micros;

use crate::{REPRESENTATIONS, StreamWindow};

/// A request this crate cannot serve.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReprError {
    /// No representation has this name.
    #[error(
        "no representation is called `{name}`; there are {}",
        REPRESENTATIONS.iter().map(|spec| spec.name).collect::<Vec<_>>().join(", ")
    )]
    UnknownRepresentation {
        /// The name.
        name: String,
    },
    /// A window of a stream that is empty or too long.
    #[error("a window of {length} is not within 1 µs to {}", StreamWindow::LONGEST)]
    WindowLength {
        /// Its length.
        length: Micros,
    },
}
