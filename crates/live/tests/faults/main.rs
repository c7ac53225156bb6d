//! What goes wrong around a pipeline: it goes on, or ends with a clear error, and never grows without bound.
#![allow(clippy::unwrap_used, reason = "tests")]

mod dummy;
mod sinks;
mod streams;
