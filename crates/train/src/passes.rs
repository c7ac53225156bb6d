//! The passes of a training over its data: an interval after the other, each followed by a
//! validation.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use evpose_task::body::BodyTrainingConfig;
use evpose_task::hand::TrainingConfig;
use serde::{Deserialize, Serialize};

use crate::order::SampleOrder;

/// Length of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingSpan {
    /// Samples per optimiser step, those of all devices together.
    pub batch_size: usize,
    /// Optimiser steps of the whole run.
    pub steps: u64,
    /// Optimiser steps between validations.
    pub steps_per_validation: u64,
}

impl From<&TrainingConfig> for TrainingSpan {
    fn from(config: &TrainingConfig) -> Self {
        let &TrainingConfig { batch_size, steps, steps_per_validation, .. } = config;
        Self { batch_size, steps, steps_per_validation }
    }
}

impl From<&BodyTrainingConfig> for TrainingSpan {
    fn from(config: &BodyTrainingConfig) -> Self {
        let &BodyTrainingConfig { batch_size, steps, steps_per_validation, .. } = config;
        Self { batch_size, steps, steps_per_validation }
    }
}

impl TrainingSpan {
    /// Validation intervals of the whole run; the last may be a short one.
    pub(crate) fn intervals(&self) -> usize {
        self.steps.div_ceil(self.steps_per_validation) as usize
    }

    /// Optimiser steps of the first `intervals` intervals.
    pub(crate) fn steps_by(&self, intervals: usize) -> u64 {
        (intervals as u64 * self.steps_per_validation).min(self.steps)
    }
}

/// The passes of a loader: the positions of the samples that each yields.
#[derive(Debug, Clone)]
pub enum Passes {
    /// Pass `i` (from 1) is validation interval `i` of a training.
    Training {
        /// Of the pass that starts next.
        next: Arc<AtomicUsize>,
        /// Length of the training.
        span: TrainingSpan,
    },
    /// Every pass is the same samples, spread evenly over the data.
    Validation {
        /// How many.
        samples: u64,
    },
}

impl Passes {
    /// The passes of a training, from validation interval `interval` (from 1) on.
    pub(crate) fn training(interval: usize, span: TrainingSpan) -> Self {
        Self::Training { next: Arc::new(AtomicUsize::new(interval)), span }
    }

    /// Interval and positions (in samples) of the pass that starts now.
    pub(crate) fn start(&self) -> (usize, Range<u64>) {
        match self {
            Self::Training { next, span } => {
                let interval = next.fetch_add(1, Ordering::SeqCst);
                let position = |intervals| span.steps_by(intervals) * span.batch_size as u64;
                (interval, position(interval - 1)..position(interval))
            }
            Self::Validation { samples } => (1, 0..*samples),
        }
    }

    /// The sample of `len` at a position: in the order of a training, evenly spread in validation.
    pub fn sample(&self, order: &SampleOrder, len: usize, position: u64) -> usize {
        match self {
            Self::Training { .. } => order.at(position) as usize,
            Self::Validation { samples } => (position * len as u64 / samples) as usize,
        }
    }

    /// Samples of a whole pass.
    pub(crate) fn samples(&self) -> u64 {
        match self {
            Self::Training { span, .. } => span.steps_by(1) * span.batch_size as u64,
            Self::Validation { samples } => *samples,
        }
    }

    /// The same passes with a counter of their own.
    pub(crate) fn detached(&self) -> Self {
        match self {
            Self::Training { next, span } => Self::training(next.load(Ordering::SeqCst), *span),
            Self::Validation { .. } => self.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_cover_a_training_once_and_validations_are_equal() {
        let span = TrainingSpan { batch_size: 4, steps: 5, steps_per_validation: 2 };
        assert_eq!(span.intervals(), 3);
        let passes = Passes::training(2, span);
        let detached = passes.detached();
        assert_eq!([passes.start(), passes.start()], [(2, 8..16), (3, 16..20)]);
        assert_eq!((detached.start(), passes.samples()), ((2, 8..16), 8));
        let validation = Passes::Validation { samples: 7 };
        assert_eq!([validation.start(), validation.start()], [(1, 0..7), (1, 0..7)]);
    }
}
