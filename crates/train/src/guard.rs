//! What stops a training that came to nothing.

use std::sync::{Arc, Mutex, PoisonError};

use burn_train::Interrupter;

/// A loss that is no longer a number, and where it happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Divergence {
    pub(crate) loss: f64,
    pub(crate) step: u64,
}

/// Stops a training whose loss is no longer a number, before anything of it is saved.
#[derive(Clone)]
pub(crate) struct Guard {
    interrupter: Interrupter,
    seen: Arc<Mutex<Option<Divergence>>>,
}

impl std::fmt::Debug for Guard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guard").field("seen", &self.seen).finish_non_exhaustive()
    }
}

impl Guard {
    pub(crate) fn new(interrupter: Interrupter) -> Self {
        Self { interrupter, seen: Arc::default() }
    }

    pub(crate) fn check(&self, loss: f64, step: u64) {
        if !loss.is_finite() {
            let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
            seen.get_or_insert(Divergence { loss, step });
            self.interrupter.stop(Some("the loss is no longer a number"));
        }
    }

    pub(crate) fn divergence(&self) -> Option<Divergence> {
        *self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
