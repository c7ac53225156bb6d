//! The divergence check of a training.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use burn_train::Interrupter;

/// A loss that is not finite, and its step: that before a validation, if the loss is of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Divergence {
    pub(crate) loss: f64,
    pub(crate) step: u64,
    pub(crate) is_validation: bool,
}

/// Stops a training whose loss is no longer finite, before a checkpoint of it is saved.
#[derive(Clone)]
pub(crate) struct Guard {
    interrupter: Interrupter,
    divergence: Arc<Mutex<Option<Divergence>>>,
    /// The latest optimiser step.
    step: Arc<AtomicU64>,
}

impl std::fmt::Debug for Guard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guard").field("divergence", &self.divergence).finish_non_exhaustive()
    }
}

impl Guard {
    pub(crate) fn new(interrupter: Interrupter) -> Self {
        Self { interrupter, divergence: Arc::default(), step: Arc::default() }
    }

    pub(crate) fn check(&self, loss: f64, step: u64) {
        self.step.fetch_max(step, Ordering::Relaxed);
        self.check_divergence(Divergence { loss, step, is_validation: false });
    }

    /// Checks the loss of a batch of the validation after the latest step.
    pub(crate) fn check_validation(&self, loss: f64) {
        let step = self.step.load(Ordering::Relaxed);
        self.check_divergence(Divergence { loss, step, is_validation: true });
    }

    fn check_divergence(&self, divergence: Divergence) {
        if !divergence.loss.is_finite() {
            let mut first = self.divergence.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(divergence);
            self.interrupter.stop(Some("the loss is no longer a number"));
        }
    }

    pub(crate) fn divergence(&self) -> Option<Divergence> {
        *self.divergence.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
