//! Recording of labelled sequences to files.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use evpose_io::{HAND_JOINTS_ENDING, HandJointsWriter, MetaWriter};
use rayon::prelude::*;

use crate::set::{SequenceSet, Shard};
use crate::{
    EpisodeInfo, EventFormat, RecordingTime, SequenceInfo, SimError, Simulation, Simulator,
    StepWriter, with_ending,
};

/// Steps per second of the labels of a `.meta` file.
const META_STEP_HZ: u32 = 1_000;

/// Frames between two reports of progress.
const REPORT_EVERY: u64 = 64;

/// A sequence on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SequenceFiles {
    /// File of the events.
    pub events_path: PathBuf,
    /// File of the labels.
    pub labels_path: PathBuf,
    /// Step count.
    pub frames: u64,
    /// Event count over all steps.
    pub events: u64,
}

/// The sequences of a run, or of a part of one, on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedRun {
    /// The sequences that were recorded, in order.
    pub sequences: Vec<SequenceFiles>,
    /// Number of sequences that were complete already.
    pub reused: usize,
    /// Unfinished files of killed processes that were removed.
    pub leftovers: usize,
    /// Whether the run is complete, other shards included; then it has a manifest.
    pub finished: bool,
    /// Elapsed time.
    pub elapsed: Duration,
    /// Parts of the time of all threads.
    pub time: RecordingTime,
}

/// Simulates `frames` steps into `STEM.evc`, or the ending of the config's [`EventFormat`],
/// `STEM.meta`, `STEM.joints.npy` (see [`JointsReader`](evpose_io::JointsReader)) and `STEM.toml`
/// (a [`SequenceInfo`]), which appear when they are complete.
///
/// `progress` receives the number of frames simulated since its last call.
///
/// # Errors
/// If the steps are not those of the labels or a file cannot be written, or as
/// [`Simulator::advance`].
pub fn record(
    simulator: &mut Simulator,
    frames: u64,
    stem: impl AsRef<Path>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<SequenceFiles, SimError> {
    let format = EventFormat::of_hands(simulator.config())?;
    record_as(format, simulator, frames, stem.as_ref(), progress)
}

/// As [`record`], with events in `format`.
fn record_as(
    format: EventFormat,
    simulator: &mut Simulator,
    frames: u64,
    stem: &Path,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<SequenceFiles, SimError> {
    let step_hz = simulator.config().step_hz;
    if step_hz != META_STEP_HZ {
        let reason = "recordings of hands have 1000 steps a second";
        return Err(SimError::Config { field: "step_hz", value: step_hz.to_string(), reason });
    }
    let events_path = with_ending(stem, format.ending());
    let labels_path = with_ending(stem, "meta");
    let mut events = StepWriter::create(stem, format, simulator.camera().sensor())?;
    let mut labels = MetaWriter::create_for_hands(&labels_path)?;
    let mut joints = HandJointsWriter::create(with_ending(stem, HAND_JOINTS_ENDING), frames)?;
    // Labels are those before the configured camera, wherever that of the sequence stands.
    let camera_from_world = simulator.config().camera().camera_from_world();
    let mut unreported = 0;
    let mut info = SequenceInfo {
        sensor: simulator.camera().sensor(),
        hand: simulator.side(),
        another_hand: simulator.config().another_hand,
        episodes: Vec::new(),
    };
    for _ in 0..frames {
        let step = simulator.advance()?;
        // Episodes count from zero: a new one is not in the list yet.
        if info.episodes.len() as u64 == step.episode.index {
            info.episodes.push(EpisodeInfo {
                first_frame: step.frame,
                betas: step.episode.betas.clone(),
                threshold_offset: step.episode.threshold_offset,
            });
        }
        labels.hand(&step.label)?;
        joints.frame(&step.points_m.map(|point_m| camera_from_world.transform_point3(point_m)))?;
        events.step(step.events)?;
        unreported += 1;
        // In batches, since all threads report to one receiver.
        if unreported == REPORT_EVERY {
            progress(unreported);
            unreported = 0;
        }
    }
    progress(unreported);
    let count = events.events();
    // Events last: a reader that sees them finds labels and info complete.
    info.write(stem)?;
    labels.finish()?;
    joints.finish()?;
    events.finish()?;
    Ok(SequenceFiles { events_path, labels_path, frames, events: count })
}

/// Simulates all sequences of a run into `DIRECTORY/0000.evc`, or the ending of the config's format,
/// `DIRECTORY/0000.meta`, `DIRECTORY/0000.joints.npy`, …, one sequence a thread, with a manifest of their digests. The bytes do not depend on the number of
/// threads.
///
/// # Errors
/// As [`record_shard`].
pub fn record_all(
    simulation: &Simulation,
    directory: impl AsRef<Path>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordedRun, SimError> {
    record_shard(simulation, directory, Shard::WHOLE, progress)
}

/// Simulates the sequences of one shard, as [`record_all`] would have simulated them. Complete
/// sequences are reused: the directory must be that of the same configuration and seed.
///
/// # Errors
/// The first of [`record`]; digests or a manifest that cannot be written.
pub fn record_shard(
    simulation: &Simulation,
    directory: impl AsRef<Path>,
    shard: Shard,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordedRun, SimError> {
    let start = Instant::now();
    let config = simulation.config();
    let set = SequenceSet::of_hands(directory.as_ref(), config)?;
    let format = EventFormat::of_hands(config)?;
    let leftovers = set.remove_leftovers(shard)?;
    let unfinished = set.unfinished(shard);
    let reused = shard.sequences_of(set.sequences()).count() - unfinished.len();
    let recorded = unfinished
        .into_par_iter()
        // Sequences are long and few: one at a time keeps every thread busy to the end.
        .with_max_len(1)
        .map(|sequence| -> Result<(SequenceFiles, RecordingTime), SimError> {
            let begun = Instant::now();
            let mut simulator = simulation.sequence(sequence)?;
            let prepared = begun.elapsed();
            let stem = set.stem(sequence);
            let recorded = record_as(format, &mut simulator, config.frames(), &stem, progress)?;
            set.seal(sequence)?;
            let mut time = simulator.time();
            time.rendering += prepared;
            Ok((recorded, time.of_whole(begun.elapsed())))
        })
        .collect::<Result<Vec<_>, SimError>>()?;
    let finished = set.write_manifest()?;
    let time = recorded.iter().map(|(_, time)| *time).sum();
    let sequences = recorded.into_iter().map(|(files, _)| files).collect();
    Ok(RecordedRun { sequences, reused, leftovers, finished, elapsed: start.elapsed(), time })
}
