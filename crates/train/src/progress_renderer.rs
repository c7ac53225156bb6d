//! Training progress reported to a callback, in place of a terminal.

use std::sync::Arc;

use burn_train::logger::{EvaluationProgressLogger, TrainingProgressLogger};
use burn_train::metric::MetricDefinition;
use burn_train::renderer::{
    EvaluationName, MetricState, MetricsRenderer, MetricsRendererEvaluation,
    MetricsRendererTraining,
};

use crate::passes::TrainingSpan;

/// Progress of a training, the steps before it was resumed included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Training samples seen.
    pub samples: u64,
    /// Training samples of the whole run.
    pub total_samples: u64,
}

/// A function that receives the [`Progress`] of a training after every optimiser step.
#[derive(Clone)]
pub struct ProgressCallback(Arc<dyn Fn(Progress) + Send + Sync>);

impl ProgressCallback {
    /// Wraps `callback`, which runs on the training thread and must be quick.
    pub fn new(callback: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self(Arc::new(callback))
    }
}

impl std::fmt::Debug for ProgressCallback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ProgressCallback").finish_non_exhaustive()
    }
}

/// A renderer that reports progress to a [`ProgressCallback`] and shows nothing.
pub(crate) struct ProgressRenderer {
    callback: ProgressCallback,
    total_samples: u64,
    samples_per_interval: u64,
    /// Validation interval, from 1.
    interval: u64,
    is_validating: bool,
}

impl ProgressRenderer {
    pub(crate) fn new(callback: ProgressCallback, span: TrainingSpan) -> Self {
        let samples = |steps: u64| steps * span.batch_size as u64;
        Self {
            callback,
            total_samples: samples(span.steps),
            samples_per_interval: samples(span.steps_per_validation),
            interval: 1,
            is_validating: false,
        }
    }
}

impl TrainingProgressLogger for ProgressRenderer {
    fn start(&mut self, _: usize, interval: usize, _: Option<usize>, _: Option<&str>) {
        self.interval = interval as u64;
    }

    fn start_split(&mut self, split: &str, _: usize) {
        self.is_validating = split != "train";
    }

    fn update_split(&mut self, done: usize) {
        if !self.is_validating {
            let before = (self.interval - 1) * self.samples_per_interval;
            let total_samples = self.total_samples;
            // The last interval may be a short one.
            let samples = (before + done as u64).min(total_samples);
            (self.callback.0)(Progress { samples, total_samples });
        }
    }

    fn end_split(&mut self) {}

    fn update_epoch(&mut self, interval: usize) {
        self.interval = interval as u64 + 1;
    }

    fn end(&mut self) {}
    fn log_event_training(&mut self, _: String) {}
}

impl MetricsRendererTraining for ProgressRenderer {
    fn update_train(&mut self, _: MetricState) {}
    fn update_valid(&mut self, _: MetricState) {}
}

impl EvaluationProgressLogger for ProgressRenderer {
    fn start_global_progress(&mut self, _: usize) {}
    fn start_test(&mut self, _: &str, _: usize) {}
    fn update_test_progress(&mut self, _: usize) {}
    fn end_test(&mut self) {}
    fn end_global_progress(&mut self) {}
    fn log_event_evaluation(&mut self, _: String) {}
}

impl MetricsRendererEvaluation for ProgressRenderer {
    fn update_test(&mut self, _: EvaluationName, _: MetricState) {}
}

impl MetricsRenderer for ProgressRenderer {
    fn manual_close(&mut self) {}
    fn register_metric(&mut self, _: MetricDefinition) {}
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_resumed_training_counts_what_came_before_and_leaves_validation_out() {
        let received = Arc::new(Mutex::new(Vec::new()));
        let callback = {
            let received = Arc::clone(&received);
            ProgressCallback::new(move |progress| {
                received.lock().expect("not poisoned").push(progress.samples);
            })
        };
        let span = TrainingSpan { batch_size: 4, steps: 5, steps_per_validation: 2 };
        let mut renderer = ProgressRenderer::new(callback, span);
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
        assert_eq!(*received.lock().expect("not poisoned"), [12, 16, 20]);
    }
}
