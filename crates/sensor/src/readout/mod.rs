//! Requests to events: which request is served, and when.

use std::fmt::Debug;

use evpose_core::SensorSize;

use crate::{ChoiceSpec, Request, Settings};

pub(crate) mod arbiter;
pub(crate) mod event_rate_control;
pub(crate) mod ideal;
pub(crate) mod scanned;

/// What a pixel does between its request and its service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Waiting {
    /// It is blind, and its memory becomes the voltage when it is served: what has changed in the
    /// meantime is lost.
    #[default]
    Reset,
    /// It is blind, and its memory keeps the level that it asked at: what has changed in the
    /// meantime makes its next event.
    Kept,
    /// It goes on: its requests queue, and only stamps are late.
    Free,
}

/// The choice of what pixels do.
pub(crate) const WAITING: ChoiceSpec = ChoiceSpec {
    name: "waiting",
    allowed: &["reset", "kept", "free"],
    doc: "a pixel that waits is blind and then sees what there is, is blind but forgets nothing, \
          or goes on making requests",
};

impl Waiting {
    /// The one that was chosen.
    pub(crate) fn of(settings: &Settings) -> Self {
        match settings.word(&WAITING) {
            "kept" => Self::Kept,
            "free" => Self::Free,
            _ => Self::Reset,
        }
    }
}

/// The bus that all pixels share.
pub trait Readout: Send + Sync + Debug {
    /// Whether every request is served when it is made, so that nobody needs to ask.
    fn is_immediate(&self) -> bool {
        false
    }

    /// What pixels do while they wait.
    fn waiting(&self) -> Waiting {
        Waiting::Reset
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
    pub(crate) fn waiting(&self) -> Waiting {
        self.readout.waiting()
    }

    pub(crate) fn acknowledge(&mut self, request: &Request) -> Option<f64> {
        self.readout.acknowledge(request, self.size, self.state)
    }
}
