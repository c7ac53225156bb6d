//! The divergence check of a training.

use std::sync::{Arc, Mutex, PoisonError};

use burn_train::Interrupter;

/// A loss that is not finite, and its step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Divergence {
    pub(crate) loss: f64,
    pub(crate) step: u64,
}

/// Stops a training whose loss is no longer finite, before a checkpoint of it is saved.
#[derive(Clone)]
pub(crate) struct Guard {
    interrupter: Interrupter,
    divergence: Arc<Mutex<Option<Divergence>>>,
}

impl std::fmt::Debug for Guard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guard").field("divergence", &self.divergence).finish_non_exhaustive()
    }
}

impl Guard {
    pub(crate) fn new(interrupter: Interrupter) -> Self {
        Self { interrupter, divergence: Arc::default() }
    }

    pub(crate) fn check(&self, loss: f64, step: u64) {
        if !loss.is_finite() {
            let mut divergence = self.divergence.lock().unwrap_or_else(PoisonError::into_inner);
            divergence.get_or_insert(Divergence { loss, step });
            self.interrupter.stop(Some("the loss is no longer a number"));
        }
    }

    pub(crate) fn divergence(&self) -> Option<Divergence> {
        *self.divergence.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
