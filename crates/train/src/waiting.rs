//! Time for which a training waits for data: `loading.jsonl`, one line an interval.
//!
//! It is a file of its own because times differ from run to run, and `metrics.jsonl` does not.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use evpose_core::atomic_write;
use serde::{Deserialize, Serialize};

use crate::TrainError;

/// Time of training loops, without validation and checkpoints, and the part of it that was spent
/// blocked because the next windows were not ready. Of several devices, the sum.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DataWait {
    /// All of it.
    pub training: Duration,
    /// The part that was waiting.
    pub waited: Duration,
}

impl DataWait {
    /// The part as a share from 0 to 1; 0 where there was no training.
    pub fn share(&self) -> f64 {
        match self.training.as_secs_f64() {
            0.0 => 0.0,
            training_s => self.waited.as_secs_f64() / training_s,
        }
    }

    fn add(&mut self, other: Self) {
        self.training += other.training;
        self.waited += other.waited;
    }
}

impl std::fmt::Display for DataWait {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "waited for data {:.2}% of the time", 100.0 * self.share())
    }
}

/// One line of `loading.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Line {
    /// Validation interval, from 1.
    interval: usize,
    training_s: f64,
    waited_s: f64,
    waited_share: f64,
}

/// Collects the waiting of all loaders of a run.
#[derive(Debug, Clone)]
pub(crate) struct WaitMeter(Arc<Mutex<Shared>>);

#[derive(Debug)]
struct Shared {
    path: PathBuf,
    /// Lines of earlier processes of this run.
    earlier: Vec<Line>,
    intervals: BTreeMap<usize, DataWait>,
    failure: Option<std::io::Error>,
}

impl WaitMeter {
    /// Keeps the lines of `path` up to and including `interval`, the one resumed from. Lines that
    /// are none are left out: nothing depends on them.
    pub(crate) fn resume(path: &Path, interval: usize) -> Result<Self, TrainError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            Err(source) => return Err(TrainError::Io { path: path.to_owned(), source }),
        };
        let lines = text.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok());
        let shared = Shared {
            path: path.to_owned(),
            earlier: lines.filter(|line| line.interval <= interval).collect(),
            intervals: BTreeMap::new(),
            failure: None,
        };
        Ok(Self(Arc::new(Mutex::new(shared))))
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds what a loader saw in an interval, and writes the file anew.
    pub(crate) fn add(&self, interval: usize, wait: DataWait) {
        let mut shared = self.lock();
        // Several loaders report on one interval.
        shared.intervals.entry(interval).or_default().add(wait);
        let now = shared.intervals.iter().map(|(&interval, wait)| Line {
            interval,
            training_s: wait.training.as_secs_f64(),
            waited_s: wait.waited.as_secs_f64(),
            waited_share: wait.share(),
        });
        let text: String = shared
            .earlier
            .iter()
            .cloned()
            .chain(now)
            .map(|line| serde_json::json!(line).to_string() + "\n")
            .collect();
        // Training goes on; the first failure is reported at its end.
        if let Err(error) = atomic_write(&shared.path, text.as_bytes()) {
            shared.failure.get_or_insert(error);
        }
    }

    /// Waiting of this process in an interval.
    pub(crate) fn wait_in_interval(&self, interval: usize) -> DataWait {
        self.lock().intervals.get(&interval).copied().unwrap_or_default()
    }

    /// Waiting of this process in all intervals.
    ///
    /// # Errors
    /// The first write of the file that failed.
    pub(crate) fn total(&self) -> Result<DataWait, TrainError> {
        let mut shared = self.lock();
        if let Some(source) = shared.failure.take() {
            return Err(TrainError::Io { path: shared.path.clone(), source });
        }
        let mut total = DataWait::default();
        shared.intervals.values().for_each(|wait| total.add(*wait));
        Ok(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(training_ms: u64, waited_ms: u64) -> DataWait {
        let [training, waited] = [training_ms, waited_ms].map(Duration::from_millis);
        DataWait { training, waited }
    }

    #[test]
    fn devices_add_up_and_shares_are_of_the_sum() {
        let directory = tempfile::tempdir().unwrap();
        let meter = WaitMeter::resume(&directory.path().join("loading.jsonl"), 0).unwrap();
        meter.add(1, wait(1_000, 100));
        meter.add(1, wait(3_000, 300));
        meter.add(2, wait(4_000, 0));
        assert_eq!(meter.wait_in_interval(1), wait(4_000, 400));
        assert_eq!(meter.wait_in_interval(1).to_string(), "waited for data 10.00% of the time");
        assert_eq!(meter.total().unwrap(), wait(8_000, 400));
        assert_eq!(
            (meter.wait_in_interval(3).share(), meter.total().unwrap().share()),
            (0.0, 0.05)
        );
    }

    #[test]
    fn a_resumed_run_keeps_the_lines_before_it_and_counts_only_itself() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("loading.jsonl");
        let meter = WaitMeter::resume(&path, 0).unwrap();
        (1..=3).for_each(|interval| meter.add(interval, wait(1_000, 500)));
        // Interval 3 has no checkpoint: it is trained again.
        let resumed = WaitMeter::resume(&path, 2).unwrap();
        resumed.add(3, wait(1_000, 250));
        assert_eq!(resumed.total().unwrap(), wait(1_000, 250));
        let lines: Vec<Line> = fs::read_to_string(&path)
            .unwrap()
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        let read: Vec<_> = lines.iter().map(|line| (line.interval, line.waited_share)).collect();
        assert_eq!(read, [(1, 0.5), (2, 0.5), (3, 0.25)]);
    }

    #[test]
    fn a_file_that_cannot_be_written_is_an_error_at_the_end() {
        let directory = tempfile::tempdir().unwrap();
        let parent = directory.path().join("run");
        let meter = WaitMeter::resume(&parent.join("loading.jsonl"), 0).unwrap();
        fs::write(parent, "not a directory").unwrap();
        meter.add(1, wait(1, 0));
        assert!(meter.total().unwrap_err().to_string().contains("loading.jsonl"));
    }
}
