//! Faults of sources, networks and sinks: the pipeline goes on or ends with a clear error, in
//! bounded memory.
#![allow(clippy::unwrap_used, reason = "tests")]

mod dummy;
mod sinks;
mod streams;
