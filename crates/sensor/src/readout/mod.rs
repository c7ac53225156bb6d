//! Requests to events: which request is served, and when.

use std::fmt::Debug;

use crate::Request;

pub(crate) mod ideal;

/// The bus that all pixels share.
pub trait Readout: Send + Sync + Debug {
    /// How many `f64` values the readout keeps between requests; they start at zero.
    fn state_len(&self) -> usize {
        0
    }

    /// The time in seconds at which `request` is served, not before it was made. Requests come in
    /// order of time, and at equal times in order of pixels.
    fn acknowledge(&self, request: &Request, state: &mut [f64]) -> f64;
}
