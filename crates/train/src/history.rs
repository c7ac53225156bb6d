//! `metrics.jsonl`: one line a step and split, written as training goes and read back on resume.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use burn_train::logger::MetricLogger;
use burn_train::metric::store::{EpochSummary, MetricsUpdate, Split};
use burn_train::metric::{MetricDefinition, MetricId, NumericEntry};
use serde::{Deserialize, Deserializer, Serialize};

use crate::TrainError;
use crate::metric::LOSS;

/// The part of the data that a line of the history is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HistorySplit {
    /// One optimiser step.
    Train,
    /// One batch of the validation that follows an interval.
    Valid,
}

/// One line of `metrics.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HistoryLine {
    /// Validation interval, from 1.
    pub interval: usize,
    /// Batch within the interval, from 1.
    pub batch: usize,
    /// Training or validation.
    pub part: HistorySplit,
    /// Samples in the batch.
    pub samples: usize,
    /// Values by metric name. JSON has no infinity and no NaN: both are read back as NaN.
    #[serde(deserialize_with = "values_or_nan")]
    pub values: BTreeMap<String, f64>,
}

fn values_or_nan<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let values = BTreeMap::<String, Option<f64>>::deserialize(from)?;
    Ok(values.into_iter().map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}

/// The lines of a finished or interrupted run.
///
/// A last line that was cut short by a kill is left out; any other damage is an error.
///
/// # Errors
/// If the file cannot be read or a line before the last is not one of ours.
pub fn read_history(path: &Path) -> Result<Vec<HistoryLine>, TrainError> {
    let text = read_text(path)?;
    Ok(parse(path, &text)?.into_iter().map(|(_, line)| line).collect())
}

fn read_text(path: &Path) -> Result<String, TrainError> {
    if !path.exists() {
        return Ok(String::new());
    }
    fs::read_to_string(path).map_err(|source| io_error(path, source))
}

/// Every line as it stands and as it reads.
fn parse<'a>(path: &Path, text: &'a str) -> Result<Vec<(&'a str, HistoryLine)>, TrainError> {
    let mut lines = Vec::new();
    for (number, line) in text.lines().enumerate() {
        match serde_json::from_str(line) {
            Ok(parsed) => lines.push((line, parsed)),
            // A crash may cut the last line off: it counts as not written.
            Err(_) if !text.ends_with('\n') && number + 1 == text.lines().count() => {}
            Err(error) => {
                return Err(TrainError::Config {
                    path: path.to_path_buf(),
                    message: format!("line {}: {error}", number + 1),
                });
            }
        }
    }
    Ok(lines)
}

/// Mean validation loss of every interval that has one.
pub fn validation_losses(history: &[HistoryLine]) -> BTreeMap<usize, f64> {
    validation_means(history, LOSS)
}

/// Mean over the validation of every interval that has one, of the logged value `name`.
pub fn validation_means(history: &[HistoryLine], name: &str) -> BTreeMap<usize, f64> {
    let mut sums: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for line in history.iter().filter(|line| line.part == HistorySplit::Valid) {
        // Batches without the value have no part in the mean.
        let Some(value) = line.values.get(name) else { continue };
        let (sum, samples) = sums.entry(line.interval).or_default();
        *sum += value * line.samples as f64;
        *samples += line.samples;
    }
    sums.into_iter().map(|(interval, (sum, n))| (interval, sum / n as f64)).collect()
}

/// Everything logged so far, shared between Burn's logger thread and the run.
#[derive(Debug, Clone)]
pub(crate) struct History {
    shared: Arc<Mutex<Shared>>,
}

#[derive(Debug)]
struct Shared {
    lines: Vec<HistoryLine>,
    path: PathBuf,
    file: BufWriter<File>,
    names: HashMap<MetricId, String>,
    /// Intervals whose networks cannot be read again.
    lost: BTreeSet<usize>,
    failure: Option<std::io::Error>,
}

impl History {
    /// Opens `path` and keeps the lines up to and including `interval`, the one resumed from.
    pub(crate) fn resume(path: &Path, interval: usize) -> Result<Self, TrainError> {
        let text = read_text(path)?;
        let mut lines = Vec::new();
        let mut kept = String::new();
        for (raw, line) in parse(path, &text)? {
            if line.interval <= interval {
                // As it stands: a number printed, read and printed again may differ in its last
                // digit.
                kept += raw;
                kept.push('\n');
                lines.push(line);
            }
        }
        // A crash here must not lose the lines of intervals that have a checkpoint.
        evpose_core::atomic_write(path, kept.as_bytes()).map_err(|e| io_error(path, e))?;
        let file = File::options().append(true).open(path).map_err(|e| io_error(path, e))?;
        let shared = Shared {
            lines,
            path: path.to_path_buf(),
            file: BufWriter::new(file),
            names: HashMap::new(),
            lost: BTreeSet::new(),
            failure: None,
        };
        Ok(Self { shared: Arc::new(Mutex::new(shared)) })
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Shared> {
        // A panic while logging leaves whole lines behind: nothing to distrust.
        self.shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    pub(crate) fn validation_losses(&self) -> BTreeMap<usize, f64> {
        validation_losses(&self.lock().lines)
    }

    /// Excludes the network of an interval from the choice of the best.
    pub(crate) fn lose_network(&self, interval: usize) {
        self.lock().lost.insert(interval);
    }

    /// Validation losses of the intervals whose network may be the best.
    pub(crate) fn losses_of_networks(&self) -> BTreeMap<usize, f64> {
        let shared = self.lock();
        let mut losses = validation_losses(&shared.lines);
        losses.retain(|interval, _| !shared.lost.contains(interval));
        losses
    }

    /// Writes what is buffered.
    ///
    /// # Errors
    /// The first write that failed, if any.
    pub(crate) fn flush(&self) -> Result<(), TrainError> {
        let mut shared = self.lock();
        let result = match shared.failure.take() {
            Some(failure) => Err(failure),
            None => shared.file.flush(),
        };
        result.map_err(|source| io_error(&shared.path, source))
    }
}

fn io_error(path: &Path, source: std::io::Error) -> TrainError {
    TrainError::Io { path: path.to_path_buf(), source }
}

fn to_json(line: &HistoryLine) -> String {
    serde_json::json!(line).to_string() + "\n"
}

impl MetricLogger for History {
    fn log(&mut self, update: MetricsUpdate, interval: usize, split: &Split) {
        let mut shared = self.lock();
        let part = if *split == Split::Train { HistorySplit::Train } else { HistorySplit::Valid };
        let mut samples = 0;
        let mut values = BTreeMap::new();
        for numeric in update.entries_numeric {
            let name = shared.names.get(&numeric.entry.metric_id).cloned();
            let (value, count) = match numeric.numeric_entry {
                Some(NumericEntry::Value(value)) => (value, 1),
                Some(NumericEntry::Aggregated { aggregated_value, count }) => {
                    (aggregated_value, count)
                }
                // The mean over the interval: it follows from the lines.
                Some(NumericEntry::Final(_)) | None => continue,
            };
            samples = count;
            values.extend(name.map(|name| (name, value)));
        }
        if values.is_empty() {
            return;
        }
        // Batches are counted from 1 in each interval, training and validation apart.
        let batch = 1 + shared
            .lines
            .iter()
            .rev()
            .find(|line| line.part == part && line.interval == interval)
            .map_or(0, |line| line.batch);
        let line = HistoryLine { interval, batch, part, samples, values };
        // Training goes on: the first failure is reported at its end.
        if let Err(error) = shared.file.write_all(to_json(&line).as_bytes()) {
            shared.failure.get_or_insert(error);
        }
        shared.lines.push(line);
    }

    fn read_numeric(
        &mut self,
        name: &str,
        interval: usize,
        split: &Split,
    ) -> Result<Vec<NumericEntry>, String> {
        let part = if *split == Split::Train { HistorySplit::Train } else { HistorySplit::Valid };
        let shared = self.lock();
        let lines = shared.lines.iter().filter(|l| l.part == part && l.interval == interval);
        Ok(lines
            .filter_map(|line| {
                let aggregated_value = *line.values.get(name)?;
                Some(NumericEntry::Aggregated { aggregated_value, count: line.samples })
            })
            .collect())
    }

    fn log_metric_definition(&mut self, definition: MetricDefinition) {
        self.lock().names.insert(definition.metric_id, definition.name.to_string());
    }

    fn log_epoch_summary(&mut self, _: EpochSummary) {
        let mut shared = self.lock();
        if let Err(error) = shared.file.flush() {
            shared.failure.get_or_insert(error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(interval: usize, part: HistorySplit, loss: f64) -> HistoryLine {
        let values = BTreeMap::from([("loss".to_owned(), loss)]);
        HistoryLine { interval, batch: 1, part, samples: 2, values }
    }

    #[test]
    fn resuming_forgets_the_interval_that_was_cut_short() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("metrics.jsonl");
        let kept = [line(1, HistorySplit::Train, 0.1 + 0.2), line(1, HistorySplit::Valid, 3.0)];
        let lost = line(2, HistorySplit::Train, 9.0);
        let text: String = kept.iter().chain([&lost]).map(to_json).collect();
        // Killed in the middle of a line.
        fs::write(&path, format!("{text}{}", "{\"interval\":2,\"ba")).unwrap();
        let history = History::resume(&path, 1).unwrap();
        assert_eq!(history.lock().lines, kept);
        assert_eq!(read_history(&path).unwrap(), kept);
        assert_eq!(history.validation_losses(), BTreeMap::from([(1, 3.0)]));
    }

    #[test]
    fn a_loss_that_was_no_number_is_read_back() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("metrics.jsonl");
        let lines =
            [1.0, f64::NAN, f64::INFINITY].map(|loss| to_json(&line(1, HistorySplit::Train, loss)));
        fs::write(&path, lines.concat()).unwrap();
        let losses: Vec<f64> =
            read_history(&path).unwrap().iter().map(|line| line.values["loss"]).collect();
        assert!(losses[0] == 1.0 && losses[1].is_nan() && losses[2].is_nan(), "{losses:?}");
    }

    #[test]
    fn damage_in_the_middle_is_an_error_that_names_the_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("metrics.jsonl");
        fs::write(&path, format!("nonsense\n{}", to_json(&line(1, HistorySplit::Train, 1.0))))
            .unwrap();
        let message = read_history(&path).unwrap_err().to_string();
        assert!(message.contains("line 1"), "{message}");
    }
}
