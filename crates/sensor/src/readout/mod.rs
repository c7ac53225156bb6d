//! Requests to events: which request is served, and when.

use std::fmt::Debug;

use evpose_core::SensorSize;

use crate::{Parameter, Request, Settings, Traits, WordSpec};

pub(crate) mod arbiter;
pub(crate) mod event_rate_control;
pub(crate) mod ideal;
mod row_bus;
pub(crate) mod scanned;

pub use row_bus::RowTimes;
pub(crate) use row_bus::{RowBus, Turn};

/// The behaviour of a pixel between its request and its service.
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
    /// It goes on, but what it asks for while a request waits is lost: a bit per visit.
    Latched,
}

/// The choice of what pixels do.
pub(crate) const WAITING: Parameter = Parameter::Word(WordSpec {
    name: "waiting",
    allowed: &["reset", "kept", "free"],
    default: Some("reset"),
    doc: "a pixel that waits is blind and then sees what there is, is blind but forgets nothing, \
          or goes on making requests",
});

impl Waiting {
    pub(crate) fn from_settings(settings: &Settings) -> Self {
        match settings.word(&WAITING) {
            Some("kept") => Self::Kept,
            Some("free") => Self::Free,
            Some("latched") => Self::Latched,
            _ => Self::Reset,
        }
    }
}

/// The reset of a pixel when its request is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ServeAction {
    /// Its memory becomes the voltage.
    Reset,
    /// It goes on from the level that it has kept.
    Keep,
    /// It has gone on long since, or knows nothing of the request.
    Nothing,
}

/// The bus that all pixels share.
pub trait Readout: Send + Sync + Debug {
    /// Properties from which the chain chooses the path of a step.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// Behaviour of pixels that wait.
    fn waiting(&self) -> Waiting {
        Waiting::Reset
    }

    /// How many `f64` values the readout of so large a sensor keeps between requests; they start at
    /// zero.
    fn state_len(&self, _size: SensorSize) -> usize {
        0
    }

    /// The times of a bus that reads whole rows. Where there are any, requests wait for the turn
    /// of their row, and [`Readout::acknowledge`] is not called.
    fn row_times(&self) -> Option<RowTimes> {
        None
    }

    /// The time in seconds at which `request` is served, not before it was made; nothing if it is
    /// lost. Requests come in order of time, and at equal times in order of pixels.
    fn acknowledge(&self, request: &Request, size: SensorSize, state: &mut [f64]) -> Option<f64>;
}

#[derive(Debug)]
pub(crate) struct Service<'a> {
    readout: &'a dyn Readout,
    row_times: Option<RowTimes>,
    size: SensorSize,
    memory: &'a mut ReadoutMemory,
}

#[derive(Debug)]
pub(crate) struct ReadoutMemory {
    state: Vec<f64>,
    bus: RowBus<ServeAction>,
}

impl ReadoutMemory {
    /// Of a readout that has never been used.
    pub(crate) fn new(readout: &dyn Readout, size: SensorSize) -> Self {
        Self { state: vec![0.0; readout.state_len(size)], bus: RowBus::new() }
    }
}

impl<'a> Service<'a> {
    pub(crate) fn new(
        readout: &'a dyn Readout,
        size: SensorSize,
        memory: &'a mut ReadoutMemory,
    ) -> Self {
        Self { readout, row_times: readout.row_times(), size, memory }
    }

    pub(crate) fn waiting(&self) -> Waiting {
        self.readout.waiting()
    }

    /// When `request` is served, of a readout that does not [read rows](Service::reads_rows).
    pub(crate) fn acknowledge(&mut self, request: &Request) -> Option<f64> {
        self.readout.acknowledge(request, self.size, &mut self.memory.state)
    }

    pub(crate) fn reads_rows(&self) -> bool {
        self.row_times.is_some()
    }

    /// The bus that reads rows. What waits for it is served even where no more is asked of it.
    pub(crate) fn bus(&mut self) -> &mut RowBus<ServeAction> {
        &mut self.memory.bus
    }

    /// Lets a request wait for the turn of its row.
    pub(crate) fn enqueue(&mut self, request: Request, then: ServeAction) {
        if let Some(times) = self.row_times {
            let row = request.pixel / u32::from(self.size.width);
            self.memory.bus.enqueue(times, row, request, then);
        }
    }

    /// Serves requests that pixels do not wait for, in order, as far as rows are selected by
    /// `end_s`.
    pub(crate) fn serve(&mut self, end_s: f64, requests: &mut Vec<Request>) {
        if self.reads_rows() {
            // Rows are selected as time goes on: those due before a request do not read it.
            for request in std::mem::take(requests) {
                self.read_rows(|selects_s| selects_s < request.t_s, requests);
                self.enqueue(request, ServeAction::Nothing);
            }
        } else {
            requests.retain_mut(|request| match self.acknowledge(request) {
                Some(t_s) => {
                    request.t_s = t_s;
                    true
                }
                None => false,
            });
        }
        self.read_rows(|selects_s| selects_s <= end_s, requests);
    }

    fn read_rows(&mut self, is_due: impl Fn(f64) -> bool, out: &mut Vec<Request>) {
        while self.bus().selects_s().is_some_and(&is_due) {
            self.bus().select(|request, _, turn| {
                if turn == Turn::Read {
                    out.push(request);
                }
            });
        }
    }
}
