//! Burn's dashboard, with ends that a run knows from its own.
//!
//! The dashboard forgets at the end of a training that somebody stopped it, panics at the key to stop at once,
//! and takes Ctrl-C as any other key. Here all three, and SIGTERM and SIGHUP, interrupt the training: it ends after
//! its batch, with the error that says how to go on.

use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, Once, PoisonError};

use burn_train::logger::{EvaluationProgressLogger, TrainingProgressLogger};
use burn_train::metric::MetricDefinition;
use burn_train::renderer::{
    EvaluationName, MetricState, MetricsRenderer, MetricsRendererEvaluation,
    MetricsRendererTraining, default_renderer,
};
use burn_train::{Interrupter, LearnerSummary};

/// The training that a signal interrupts; none before and after it.
static RUNNING: Mutex<Option<Interrupter>> = Mutex::new(None);

/// The dashboard of one training.
pub(crate) struct Dashboard {
    /// None once it was stopped at once.
    shown: Option<Box<dyn MetricsRenderer>>,
    /// The interrupter of its keys.
    keys: Interrupter,
    /// That of the training.
    training: Interrupter,
    hears_signals: bool,
}

impl Dashboard {
    /// Takes the terminal.
    pub(crate) fn new(training: Interrupter) -> Self {
        static LISTEN: Once = Once::new();
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(training.clone());
        // Where another handler listens already, that one decides.
        LISTEN.call_once(|| drop(ctrlc::set_handler(interrupt)));
        let keys = Interrupter::new();
        let shown = default_renderer(keys.clone(), None);
        Self { shown: Some(shown), keys, training, hears_signals: false }
    }

    /// Shows something, and passes on what keys have stopped.
    fn show(&mut self, act: impl FnOnce(&mut dyn MetricsRenderer)) {
        let Some(shown) = &mut self.shown else { return };
        // It panics when it is to stop at once, and whenever it is called after that.
        if catch_unwind(AssertUnwindSafe(|| act(shown.as_mut()))).is_err() {
            let shown = self.shown.take();
            let _ = catch_unwind(AssertUnwindSafe(|| drop(shown)));
            self.training.stop(Some("stopped at once"));
        } else if self.keys.should_stop() {
            self.training.stop(Some("stopped"));
        }
        if !self.hears_signals {
            self.hears_signals = let_keys_signal();
        }
    }
}

/// Ends the running training after its batch, or the program, where none is.
fn interrupt() {
    match &*RUNNING.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(training) => training.stop(Some("interrupted")),
        // 128 plus the number of SIGINT, as shells report it.
        None => std::process::exit(130),
    }
}

impl Drop for Dashboard {
    fn drop(&mut self) {
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Lets Ctrl-C be a signal again, once the dashboard has made a key of it. Returns whether it has.
#[cfg(unix)]
fn let_keys_signal() -> bool {
    use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
    let input = std::io::stdin();
    let Ok(mut modes) = tcgetattr(&input) else { return true };
    let is_raw = !modes.local_modes.contains(LocalModes::ICANON);
    if is_raw {
        modes.local_modes.insert(LocalModes::ISIG);
        let _ = tcsetattr(&input, OptionalActions::Now, &modes);
    }
    is_raw
}

#[cfg(not(unix))]
fn let_keys_signal() -> bool {
    true
}

impl MetricsRendererTraining for Dashboard {
    fn update_train(&mut self, state: MetricState) {
        self.show(|shown| shown.update_train(state));
    }

    fn update_valid(&mut self, state: MetricState) {
        self.show(|shown| shown.update_valid(state));
    }

    fn on_train_end(&mut self, summary: Option<LearnerSummary>) -> Result<(), Box<dyn Error>> {
        let mut ended = Ok(());
        self.show(|shown| ended = shown.on_train_end(summary));
        ended
    }
}

impl TrainingProgressLogger for Dashboard {
    fn start(&mut self, total: usize, first: usize, items: Option<usize>, label: Option<&str>) {
        self.show(|shown| TrainingProgressLogger::start(shown, total, first, items, label));
    }

    fn update_epoch(&mut self, interval: usize) {
        self.show(|shown| shown.update_epoch(interval));
    }

    fn start_split(&mut self, split: &str, items: usize) {
        self.show(|shown| shown.start_split(split, items));
    }

    fn update_split(&mut self, items: usize) {
        self.show(|shown| shown.update_split(items));
    }

    fn end_split(&mut self) {
        self.show(|shown| shown.end_split());
    }

    fn end(&mut self) {
        self.show(|shown| TrainingProgressLogger::end(shown));
    }

    fn log_event_training(&mut self, event: String) {
        self.show(|shown| shown.log_event_training(event));
    }
}

/// Trainings evaluate nothing.
impl EvaluationProgressLogger for Dashboard {
    fn start_global_progress(&mut self, _: usize) {}
    fn start_test(&mut self, _: &str, _: usize) {}
    fn update_test_progress(&mut self, _: usize) {}
    fn end_test(&mut self) {}
    fn end_global_progress(&mut self) {}
    fn log_event_evaluation(&mut self, _: String) {}
}

impl MetricsRendererEvaluation for Dashboard {
    fn update_test(&mut self, _: EvaluationName, _: MetricState) {}
}

impl MetricsRenderer for Dashboard {
    fn manual_close(&mut self) {
        self.show(|shown| shown.manual_close());
    }

    fn register_metric(&mut self, definition: MetricDefinition) {
        self.show(|shown| shown.register_metric(definition));
    }
}
