//! Training progress as plain lines: one every few seconds, for logs, pipes and CI.

use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use burn_train::logger::{EvaluationProgressLogger, TrainingProgressLogger};
use burn_train::metric::{MetricDefinition, MetricId, NumericEntry};
use burn_train::renderer::{
    EvaluationName, MetricState, MetricsRenderer, MetricsRendererEvaluation,
    MetricsRendererTraining,
};

use crate::waiting::WaitMeter;

/// Interval between two lines: often enough to watch, rare enough for the logs of days.
const EVERY: Duration = Duration::from_secs(5);

/// Writes a line every few seconds, and one after each interval and each validation.
pub(crate) struct PlainRenderer<W> {
    out: Mutex<W>,
    names: Vec<(MetricId, String)>,
    intervals: usize,
    interval: usize,
    validating: bool,
    total: usize,
    values: BTreeMap<usize, f64>,
    validation: BTreeMap<usize, (f64, usize)>,
    started: Instant,
    last_line: Instant,
    samples: usize,
    meter: WaitMeter,
}

impl<W: Write + Send> PlainRenderer<W> {
    /// Writes to `out`, also the waiting that `meter` measures in every interval.
    pub(crate) fn new(out: W, meter: WaitMeter) -> Self {
        let now = Instant::now();
        Self {
            out: Mutex::new(out),
            names: Vec::new(),
            intervals: 0,
            interval: 0,
            validating: false,
            total: 0,
            values: BTreeMap::new(),
            validation: BTreeMap::new(),
            started: now,
            last_line: now,
            samples: 0,
            meter,
        }
    }

    fn line(&self, text: &str) {
        let mut out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        // Progress that nobody can read is not worth stopping a training for.
        let _ = writeln!(out, "{text}").and_then(|()| out.flush());
    }

    fn index(&self, state: &MetricState) -> Option<(usize, f64, usize)> {
        let MetricState::Numeric(entry, Some(value)) = state else { return None };
        let index = self.names.iter().position(|(id, _)| *id == entry.metric_id)?;
        match *value {
            NumericEntry::Value(value) => Some((index, value, 1)),
            NumericEntry::Aggregated { aggregated_value, count } => {
                Some((index, aggregated_value, count))
            }
            NumericEntry::Final(_) => None,
        }
    }

    fn describe(&self, values: impl Iterator<Item = (usize, f64)>) -> String {
        values.map(|(i, v)| format!("{} {v:.3}", self.names[i].1)).collect::<Vec<_>>().join("  ")
    }
}

impl<W: Write + Send> MetricsRendererTraining for PlainRenderer<W> {
    fn update_train(&mut self, state: MetricState) {
        if let Some((index, value, _)) = self.index(&state) {
            // A running mean over about the last 20 batches reads better than single batches.
            let smoothed = self.values.entry(index).or_insert(value);
            *smoothed += (value - *smoothed) * 0.05;
        }
    }

    fn update_valid(&mut self, state: MetricState) {
        if let Some((index, value, count)) = self.index(&state) {
            let (sum, samples) = self.validation.entry(index).or_default();
            *sum += value * count as f64;
            *samples += count;
        }
    }
}

impl<W: Write + Send> TrainingProgressLogger for PlainRenderer<W> {
    fn start(&mut self, intervals: usize, interval: usize, _: Option<usize>, _: Option<&str>) {
        (self.intervals, self.interval) = (intervals, interval);
        self.started = Instant::now();
    }

    fn start_split(&mut self, split: &str, total: usize) {
        self.validating = split != "train";
        self.total = total;
        self.validation.clear();
    }

    fn update_split(&mut self, done: usize) {
        if self.validating || self.last_line.elapsed() < EVERY {
            return;
        }
        self.last_line = Instant::now();
        let rate = (self.samples + done) as f64 / self.started.elapsed().as_secs_f64();
        let left = (self.intervals + 1 - self.interval) * self.total - done;
        self.line(&format!(
            "train  interval {}/{}  sample {done}/{}  {}  {rate:.0} samples/s  {:.1} min left",
            self.interval,
            self.intervals,
            self.total,
            self.describe(self.values.iter().map(|(&i, &v)| (i, v))),
            left as f64 / rate / 60.0,
        ));
    }

    fn end_split(&mut self) {
        if self.validating {
            let means = self.validation.iter().map(|(&i, &(sum, n))| (i, sum / n.max(1) as f64));
            self.line(&format!(
                "valid  interval {}/{}  {}",
                self.interval,
                self.intervals,
                self.describe(means)
            ));
        } else {
            self.samples += self.total;
            let waited = self.meter.wait_in_interval(self.interval);
            self.line(&format!("train  interval {}/{}  {waited}", self.interval, self.intervals));
        }
    }

    fn update_epoch(&mut self, interval: usize) {
        self.interval = interval + 1;
    }

    fn end(&mut self) {}

    /// Burn announces every iteration here, which the lines above already show.
    fn log_event_training(&mut self, _: String) {}
}

impl<W: Write + Send> EvaluationProgressLogger for PlainRenderer<W> {
    fn start_global_progress(&mut self, _: usize) {}
    fn start_test(&mut self, _: &str, _: usize) {}
    fn update_test_progress(&mut self, _: usize) {}
    fn end_test(&mut self) {}
    fn end_global_progress(&mut self) {}
    fn log_event_evaluation(&mut self, event: String) {
        self.line(&event);
    }
}

impl<W: Write + Send> MetricsRendererEvaluation for PlainRenderer<W> {
    fn update_test(&mut self, _: EvaluationName, _: MetricState) {}
}

impl<W: Write + Send> MetricsRenderer for PlainRenderer<W> {
    fn manual_close(&mut self) {}

    fn register_metric(&mut self, definition: MetricDefinition) {
        self.names.push((definition.metric_id, definition.name.to_string()));
    }
}
