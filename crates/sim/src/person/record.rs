//! Sequences of people written to files, labelled.

use std::path::Path;
use std::time::{Duration, Instant};

use evpose_core::{SensorSize, atomic_write};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{People, PoseRow, PoseTable};
use crate::SimError;
use crate::set::{PEOPLE, SequenceSet, Shard};

/// What was drawn for a sequence: `0007.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonInfo {
    /// Size of the sensor in pixels.
    pub sensor: SensorSize,
    /// What is done.
    pub activity: String,
    /// Shape coefficients of the person.
    pub betas: Vec<f32>,
    /// What was added to the sensor's contrast thresholds, in natural-log intensity.
    pub threshold_offset: f64,
}

/// The sequences of a run, or of a part of one, on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedPeople {
    /// Sequences that were recorded now.
    pub sequences: usize,
    /// Their steps.
    pub steps: u64,
    /// Their events.
    pub events: u64,
    /// How many sequences were whole already.
    pub kept: usize,
    /// Whether the whole run is there now, those of other shards included.
    pub finished: bool,
    /// How long it took.
    pub elapsed: Duration,
}

/// Simulates the sequences of one shard into `DIRECTORY/0000.raw` (EVT3: compact, of any size), `0000.poses.csv` (a
/// [`PoseTable`]) and `0000.toml` (a [`PersonInfo`]), one sequence a thread. Sequences that are whole are
/// kept: the directory must be that of the same configuration and seed.
///
/// `progress` is told how many steps were simulated since it was last called.
///
/// # Errors
/// If the sensor refuses its configuration or a file cannot be written.
pub fn record_people(
    people: &People,
    directory: &Path,
    shard: Shard,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordedPeople, SimError> {
    let start = Instant::now();
    std::fs::create_dir_all(directory)
        .map_err(|source| SimError::file(directory, "create", source))?;
    let set = SequenceSet::new(directory, people.config().sequences).holding(PEOPLE);
    set.remove_leftovers(shard)?;
    let unfinished = set.unfinished(shard);
    let kept = shard.of(set.sequences()).count() - unfinished.len();
    let counts = unfinished
        .into_par_iter()
        .with_max_len(1)
        .map(|sequence| {
            let events = record(people, sequence, &set, progress)?;
            set.seal(sequence)?;
            Ok(events)
        })
        .collect::<Result<Vec<u64>, SimError>>()?;
    let finished = set.write_manifest()?;
    Ok(RecordedPeople {
        sequences: counts.len(),
        steps: counts.len() as u64 * people.config().steps(),
        events: counts.iter().sum(),
        kept,
        finished,
        elapsed: start.elapsed(),
    })
}

/// Records one sequence, and says how many events it has.
fn record(
    people: &People,
    sequence: u64,
    set: &SequenceSet,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<u64, SimError> {
    let mut simulator = people.sequence(sequence)?;
    let stem = set.stem(sequence);
    let info = PersonInfo {
        sensor: simulator.sensor(),
        activity: simulator.activity().to_owned(),
        betas: simulator.betas().to_vec(),
        threshold_offset: simulator.threshold_offset(),
    };
    let path = stem.with_extension("raw");
    let mut sink = evpose_io::create(&path, info.sensor)?;
    let (mut table, mut count) = (PoseTable::default(), 0);
    for _ in 0..people.config().steps() {
        let step = simulator.advance()?;
        sink.write(step.events)?;
        count += step.events.len() as u64;
        if step.is_labelled {
            let (joints_px, joints_m) = (step.joints_px, step.joints_m);
            table.rows.push(PoseRow { t: step.t, joints_px, joints_m });
        }
        progress(1);
    }
    table.write(&stem.with_extension("poses.csv"))?;
    let info_path = stem.with_extension("toml");
    let text = toml::to_string(&info).map_err(|error| SimError::SequenceInfo {
        path: info_path.clone(),
        reason: error.to_string(),
    })?;
    atomic_write(&info_path, text.as_bytes())
        .map_err(|source| SimError::file(&info_path, "write", source))?;
    sink.finish()?;
    Ok(count)
}
