//! Recording of labelled sequences of people to files.

use std::path::Path;
use std::time::{Duration, Instant};

use evpose_core::{PlacedCamera, SensorSize, atomic_write};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{People, PoseRow, PoseTable};
use crate::set::{SequenceSet, Shard};
use crate::{EventFormat, RecordingTime, SimError, StepWriter};

/// Metadata of a sequence: `0007.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonInfo {
    /// Size of the sensor in pixels.
    pub sensor: SensorSize,
    /// Name of the activity; empty of recordings that were not simulated.
    #[serde(default)]
    pub activity: String,
    /// Shape coefficients of the person; empty where they are not known.
    #[serde(default)]
    pub betas: Vec<f32>,
    /// Offset of the sensor's contrast thresholds, in natural-log intensity.
    #[serde(default)]
    pub threshold_offset: f64,
    /// The scene, where several cameras see it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<u64>,
    /// The camera in the world of the labels; none where it moves or is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<PlacedCamera>,
}

/// The sequences of a run, or of a part of one, on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedPeople {
    /// Number of sequences recorded by this call.
    pub sequences: usize,
    /// Their step count.
    pub steps: u64,
    /// Their event count.
    pub events: u64,
    /// Number of sequences that were complete already.
    pub reused: usize,
    /// Whether the run is complete, other shards included.
    pub finished: bool,
    /// Elapsed time.
    pub elapsed: Duration,
    /// Parts of the time of all threads.
    pub time: RecordingTime,
}

/// Simulates the sequences of one shard into `DIRECTORY/0000.raw` (EVT3: compact, of any size) or
/// another format of the config, `0000.poses.csv` (a [`PoseTable`]) and `0000.toml` (a [`PersonInfo`]), one sequence a thread.
/// Complete sequences are reused: the directory must be that of the same configuration and seed.
///
/// `progress` receives the number of steps simulated since its last call.
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
    let set = SequenceSet::of_people(directory, people.config())?;
    set.remove_leftovers(shard)?;
    let unfinished = set.unfinished(shard);
    let reused = shard.sequences_of(set.sequences()).count() - unfinished.len();
    let counts = unfinished
        .into_par_iter()
        // Sequences take minutes each: longer pieces would leave threads without work at the end.
        .with_max_len(1)
        .map(|sequence| {
            let begun = Instant::now();
            let (events, time) = record(people, sequence, &set, progress)?;
            // Sealed only when its files are complete: a sealed sequence is reused.
            set.seal(sequence)?;
            Ok((events, time.of_whole(begun.elapsed())))
        })
        .collect::<Result<Vec<(u64, RecordingTime)>, SimError>>()?;
    // The shard that finishes last writes it for all.
    let finished = set.write_manifest()?;
    Ok(RecordedPeople {
        sequences: counts.len(),
        steps: counts.len() as u64 * people.config().steps(),
        events: counts.iter().map(|(events, _)| events).sum(),
        reused,
        finished,
        elapsed: start.elapsed(),
        time: counts.iter().map(|(_, time)| *time).sum(),
    })
}

/// Records one sequence and returns its event count, and the time of its scene and its steps.
fn record(
    people: &People,
    sequence: u64,
    set: &SequenceSet,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(u64, RecordingTime), SimError> {
    let begun = Instant::now();
    let mut simulator = people.sequence(sequence)?;
    let prepared = begun.elapsed();
    let stem = set.stem(sequence);
    let info = PersonInfo {
        sensor: simulator.sensor(),
        activity: simulator.activity().to_owned(),
        betas: simulator.betas().to_vec(),
        threshold_offset: simulator.threshold_offset(),
        scene: (people.config().cameras() > 1).then_some(people.config().scene_of(sequence).0),
        camera: simulator.placed_camera(),
    };
    let format = EventFormat::of_people(people.config())?;
    let mut events = StepWriter::create(&stem, format, info.sensor)?;
    let mut table = PoseTable::default();
    // Written step by step: the events of a sequence need not fit in memory.
    for _ in 0..people.config().steps() {
        let step = simulator.advance()?;
        events.step(step.events)?;
        if step.is_labelled {
            let (joints_px, joints_m) = (step.joints_px, step.joints_m);
            table.rows.push(PoseRow { t: step.t, joints_px, joints_m });
        }
        progress(1);
    }
    // The events come last: a recording that is there has its labels.
    table.write(&stem.with_extension("poses.csv"))?;
    let info_path = stem.with_extension("toml");
    let text = toml::to_string(&info).map_err(|error| SimError::SequenceInfo {
        path: info_path.clone(),
        reason: error.to_string(),
    })?;
    atomic_write(&info_path, text.as_bytes())
        .map_err(|source| SimError::file(&info_path, "write", source))?;
    // Counted before `finish`, which consumes the writer.
    let count = events.events();
    events.finish()?;
    let mut time = simulator.time();
    time.rendering += prepared;
    Ok((count, time))
}
