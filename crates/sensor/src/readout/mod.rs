//! Requests to events: which request is served, and when.

use std::fmt::Debug;

use evpose_core::SensorSize;

use crate::Request;

pub(crate) mod arbiter;
pub(crate) mod event_rate_control;
pub(crate) mod ideal;
pub(crate) mod scanned;

/// The bus that all pixels share.
pub trait Readout: Send + Sync + Debug {
    /// Whether every request is served when it is made, so that nobody needs to ask.
    fn is_immediate(&self) -> bool {
        false
    }

    /// How many `f64` values the readout keeps between requests; they start at zero.
    fn state_len(&self) -> usize {
        0
    }

    /// The time in seconds at which `request` is served, not before it was made; nothing if it is
    /// lost. Requests come in order of time, and at equal times in order of pixels.
    fn acknowledge(&self, request: &Request, size: SensorSize, state: &mut [f64]) -> Option<f64>;
}

/// A readout at work.
#[derive(Debug)]
pub(crate) struct Service<'a> {
    pub(crate) readout: &'a dyn Readout,
    pub(crate) size: SensorSize,
    pub(crate) state: &'a mut [f64],
}

impl Service<'_> {
    pub(crate) fn acknowledge(&mut self, request: &Request) -> Option<f64> {
        self.readout.acknowledge(request, self.size, self.state)
    }
}
