//! Training progress for whoever shows it in their own way.

use std::sync::Arc;

use burn_train::logger::{EvaluationProgressLogger, TrainingProgressLogger};
use burn_train::metric::MetricDefinition;
use burn_train::renderer::{
    EvaluationName, MetricState, MetricsRenderer, MetricsRendererEvaluation,
    MetricsRendererTraining,
};

/// How far a training is, those steps included that it was resumed after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HowFar {
    /// Training windows seen.
    pub samples: u64,
    /// Training windows in all.
    pub of: u64,
}

/// A function that is told after every optimiser step.
#[derive(Clone)]
pub struct Told(Arc<dyn Fn(HowFar) + Send + Sync>);

impl Told {
    /// Calls `tell`, which must be quick.
    pub fn new(tell: impl Fn(HowFar) + Send + Sync + 'static) -> Self {
        Self(Arc::new(tell))
    }
}

impl std::fmt::Debug for Told {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Told").finish_non_exhaustive()
    }
}

/// How long a training is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrainingSpan {
    /// Samples per optimiser step.
    pub(crate) batch_size: usize,
    /// Optimiser steps in all.
    pub(crate) steps: u64,
    /// Optimiser steps between validations.
    pub(crate) steps_per_interval: u64,
}

/// Passes on how far it is, and nothing else.
pub(crate) struct ToldRenderer {
    told: Told,
    of: u64,
    per_interval: u64,
    /// From 1.
    interval: u64,
    validating: bool,
}

impl ToldRenderer {
    pub(crate) fn new(told: Told, span: TrainingSpan) -> Self {
        let samples = |steps: u64| steps * span.batch_size as u64;
        Self {
            told,
            of: samples(span.steps),
            per_interval: samples(span.steps_per_interval),
            interval: 1,
            validating: false,
        }
    }
}

impl TrainingProgressLogger for ToldRenderer {
    fn start(&mut self, _: usize, interval: usize, _: Option<usize>, _: Option<&str>) {
        self.interval = interval as u64;
    }

    fn start_split(&mut self, split: &str, _: usize) {
        self.validating = split != "train";
    }

    fn update_split(&mut self, done: usize) {
        if !self.validating {
            let before = (self.interval - 1) * self.per_interval;
            (self.told.0)(HowFar { samples: (before + done as u64).min(self.of), of: self.of });
        }
    }

    fn end_split(&mut self) {}

    fn update_epoch(&mut self, interval: usize) {
        self.interval = interval as u64 + 1;
    }

    fn end(&mut self) {}
    fn log_event_training(&mut self, _: String) {}
}

impl MetricsRendererTraining for ToldRenderer {
    fn update_train(&mut self, _: MetricState) {}
    fn update_valid(&mut self, _: MetricState) {}
}

impl EvaluationProgressLogger for ToldRenderer {
    fn start_global_progress(&mut self, _: usize) {}
    fn start_test(&mut self, _: &str, _: usize) {}
    fn update_test_progress(&mut self, _: usize) {}
    fn end_test(&mut self) {}
    fn end_global_progress(&mut self) {}
    fn log_event_evaluation(&mut self, _: String) {}
}

impl MetricsRendererEvaluation for ToldRenderer {
    fn update_test(&mut self, _: EvaluationName, _: MetricState) {}
}

impl MetricsRenderer for ToldRenderer {
    fn manual_close(&mut self) {}
    fn register_metric(&mut self, _: MetricDefinition) {}
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_resumed_training_counts_what_came_before_and_leaves_validation_out() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let told = {
            let heard = Arc::clone(&heard);
            Told::new(move |how_far| heard.lock().expect("not poisoned").push(how_far.samples))
        };
        let span = TrainingSpan { batch_size: 4, steps: 5, steps_per_interval: 2 };
        let mut renderer = ToldRenderer::new(told, span);
        // Resumed after the first of three intervals, the last of which has one step.
        renderer.start(3, 2, None, None);
        for (split, done, ended) in
            [("train", vec![4, 8], None), ("valid", vec![4], Some(2)), ("train", vec![4], None)]
        {
            renderer.start_split(split, 8);
            done.into_iter().for_each(|done| renderer.update_split(done));
            renderer.end_split();
            ended.into_iter().for_each(|interval| renderer.update_epoch(interval));
        }
        assert_eq!(*heard.lock().expect("not poisoned"), [12, 16, 20]);
    }
}
