//! Sequences and images of people.

use std::path::Path;

use anyhow::Result;
use evpose_sim::person::{People, RecordedPeople, record_people};
use evpose_sim::{SequenceSet, Shard};
use evpose_task::body::{BodyConfig, BodySourceKind};
use evpose_train::body::{BodyFrames, BodyRecordings, holds_annotations};

use crate::progress::{bar, say};
use crate::run_info;

/// Records the missing sequences of a shard of the people of `config`.
///
/// # Errors
/// If the simulation fails, a file cannot be written, or the directory is of another config.
pub fn record(config: &BodyConfig, dir: &Path, shard: Shard) -> Result<RecordedPeople> {
    config.simulation.missing_folders().into_iter().for_each(say);
    let people = People::new(&config.simulation, config.seed)?;
    let set = SequenceSet::of_people(dir, &config.simulation)?;
    let steps = set.unfinished(shard).len() as u64 * config.simulation.steps();
    let progress = bar("simulating", steps, "steps");
    let recorded = record_people(&people, dir, shard, &|steps| progress.inc(steps))?;
    progress.finish_and_clear();
    run_info::check_shared(dir, config)?;
    Ok(recorded)
}

/// Counts and speed of a simulation, in a line.
pub fn summary_of_people(recorded: &RecordedPeople, config: &BodyConfig) -> String {
    let seconds = recorded.elapsed.as_secs_f64();
    format!(
        "{} sequences, {} steps of {} ms, {:.1} M events in {seconds:.1} s ({}): {:.0} steps/s",
        recorded.sequences,
        recorded.steps,
        config.simulation.step().0 as f64 / 1e3,
        recorded.events as f64 / 1e6,
        recorded.time.of(recorded.elapsed),
        recorded.steps as f64 / seconds,
    )
}

/// Simulates the recordings of `config` where they are missing.
///
/// # Errors
/// If the simulation fails, or `data` is of another config.
pub fn prepare(config: &BodyConfig, data: &Path) -> Result<()> {
    let set = SequenceSet::of_people(data, &config.simulation)?;
    if set.unfinished(Shard::WHOLE).is_empty() {
        run_info::check_shared(data, config)?;
        // Whoever recorded the last one may have ended before it wrote the manifest.
        set.write_manifest()?;
        return Ok(());
    }
    // First: whatever is recorded afterwards has to be of this config.
    run_info::write_shared(data, config)?;
    let simulation = &config.simulation;
    say(format!(
        "simulating {} people of {} s at {} into {}",
        simulation.sequences,
        simulation.seconds,
        simulation.sensor_size,
        data.display()
    ));
    let recorded = record(config, data, Shard::WHOLE)?;
    say(summary_of_people(&recorded, config));
    Ok(())
}

/// Loads the images that `config` trains on.
///
/// # Errors
/// If a recording or an annotation cannot be read.
pub fn frames(config: &BodyConfig, data: &Path) -> Result<BodyFrames> {
    let (label, count, unit) = match config.data.source {
        BodySourceKind::Stills | BodySourceKind::GreyStills => {
            config.simulation.missing_folders().into_iter().for_each(say);
            ("rendering", config.data.stills, "stills")
        }
        BodySourceKind::Recordings if holds_annotations(data) => ("reading", 0, "images"),
        BodySourceKind::Recordings | BodySourceKind::GreyRecordings => {
            ("reading", BodyRecordings::open(data)?.files.len() as u64, "recordings")
        }
        BodySourceKind::Annotations => ("reading", 0, "images"),
    };
    let progress = bar(label, count, unit);
    let frames = BodyFrames::load(config, data, &|done| progress.inc(done))?;
    progress.finish_and_clear();
    say(format!("{} images", frames.len()));
    Ok(frames)
}
