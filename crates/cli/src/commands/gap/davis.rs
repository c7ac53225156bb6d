//! A recording beside the frames that its camera took.

use std::path::Path;

use anyhow::{Result, bail};
use evpose_gap::davis::load_shots;
use evpose_gap::input::{Problem, Problems};
use evpose_gap::workflow::{ComparisonCase, prepared};
use evpose_io::OpenOptions;
use evpose_sensor::SensorConfig;

use super::inputs::Loaded;
use super::note::InputNote;
use crate::progress::say;
use crate::scene_source::{MAX_PIXELS, SceneSource, USUAL_S};

/// Reads events and frames, which have one clock and one place: only axes and polarity may be mixed
/// up.
pub(super) fn load(
    measured: &Path,
    options: &OpenOptions,
    source: &SceneSource,
    model: &SensorConfig,
    as_is: bool,
) -> Result<Loaded> {
    if source.poses.is_some() {
        bail!("--poses goes with the config of a scene, not with --scene frames");
    }
    let seconds = source.seconds.unwrap_or(USUAL_S);
    let read = load_shots(measured, source.response.unwrap_or_default(), seconds, options)?;
    // All planes are kept in memory, so that the product decides, not either factor.
    let pixels = read.shots.planes() as f64 * read.shots.size().pixels() as f64;
    if pixels > MAX_PIXELS {
        bail!(
            "{:.1} s of a sensor of {} are too much to be compared at once: give fewer --seconds",
            read.shots.duration().as_seconds(),
            read.shots.size()
        );
    }
    let scene = read.shots.scene()?;
    let mut problems = Problems::default();
    if read.recording.outside > 0 {
        problems.list.push(Problem::Outside(read.recording.outside));
    }
    // Clock and start are one in these files, so that of all problems only axes may be real.
    if !as_is {
        let reference = scene.events(&prepared(model, None).reference, 0)?;
        let all = Problems::find(&read.recording, scene.duration().as_seconds(), &reference).list;
        problems.list.extend(all.into_iter().filter(|p| matches!(p, Problem::Orientation(_))));
    }
    let properties = read.recording.notes.iter().cloned();
    let mut notes: Vec<InputNote> = properties.map(InputNote::property).collect();
    // Nothing else is repaired here, since nothing else is searched for.
    let is_repaired = |problem: &Problem| matches!(problem, Problem::Orientation(_));
    notes.extend(problems.list.iter().map(|one| InputNote::of(one, is_repaired(one))));
    let lines = read.recording.provenance.iter().map(|line| format!("read      {line}"));
    lines.chain(notes.iter().map(InputNote::on_terminal)).for_each(say);
    let case = ComparisonCase::new(&problems.repair(&read.recording.events), scene)?;
    let notes = notes.into_iter().map(InputNote::in_verdict).collect();
    let tick = read.recording.tick;
    Ok(Loaded { case, nominal: None, tick, notes, shots: Some(read.shots) })
}
