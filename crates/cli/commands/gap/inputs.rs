//! What was typed, read: problems are said before anything is compared.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::EventStream;
use evpose_gap::input::{Nominal, Problem, Problems, load_recording, load_scene};
use evpose_gap::workflow::{Case, HeldOut, Inputs, Prepared, prepared};
use evpose_gap::{GapError, Scene};
use evpose_sensor::{STAGES, SensorConfig, SensorModel};

use super::BadInput;
use super::args::InputArgs;
use crate::commands::sensor::source;
use crate::progress::say;

/// A recording beside its scene, as read.
pub(super) struct Loaded {
    /// What is compared.
    pub(super) case: Case,
    /// What the maker of the recording says of the sensor.
    pub(super) nominal: Option<Nominal>,
    /// What was read, what was found and what was put right, a line each.
    pub(super) notes: Vec<String>,
}

/// The model that was asked for, checked.
pub(super) fn model(name: &str) -> Result<SensorConfig> {
    let config = source::sensor(name).context(BadInput)?.config;
    SensorModel::from_config(&config).map_err(GapError::from).context(BadInput)?;
    Ok(config)
}

/// Reads a recording and its scene.
pub(super) fn load(
    measured: &Path,
    scene: &Path,
    model: &SensorConfig,
    as_is: bool,
) -> Result<Loaded> {
    load_all(measured, scene, model, as_is).context(BadInput)
}

fn load_all(measured: &Path, dir: &Path, model: &SensorConfig, as_is: bool) -> Result<Loaded> {
    let scene = load_scene(dir)?;
    let recording = load_recording(measured, Some(scene.scene.size()))?;
    let mut notes: Vec<String> = scene
        .notes
        .iter()
        .chain(&recording.notes)
        .map(|note| format!("note      {note}"))
        .collect();
    let reference = expected(&scene.scene, model, scene.nominal.as_ref())?;
    let problems = Problems::find(&recording, scene.duration_s, &reference);
    let repaired = !as_is && !problems.is_hopeless();
    for problem in &problems.found {
        let is_repaired = matches!(
            problem,
            Problem::Unit { .. } | Problem::Start { .. } | Problem::Orientation(_)
        );
        let what = if is_repaired && repaired { "put right" } else { "problem  " };
        notes.push(format!("{what} {problem}"));
    }
    let source = scene.provenance.iter().chain(&recording.provenance);
    source.map(|line| format!("read      {line}")).chain(notes.iter().cloned()).for_each(say);
    if problems.is_hopeless() {
        return Err(GapError::Recording(format!(
            "{} and {} do not belong together",
            measured.display(),
            dir.display()
        ))
        .into());
    }
    let events = if repaired { problems.repair(&recording.events) } else { recording.events };
    let case = Case::new(&events, scene.scene)?;
    let notes = notes.iter().map(|note| note.replace("  ", " ")).collect();
    Ok(Loaded { case, nominal: scene.nominal, notes })
}

/// Events that the model has of a scene, without noise.
fn expected(
    scene: &Scene,
    model: &SensorConfig,
    nominal: Option<&Nominal>,
) -> Result<EventStream, GapError> {
    let reference = prepared(model, nominal).reference;
    let mut run = SensorModel::from_config(&reference)?.start(scene.size(), 0);
    let mut all = EventStream::empty(scene.size());
    for (k, plane) in scene.planes().iter().enumerate() {
        for event in run.expose(plane, scene.time(k))?.iter() {
            all.push(event).map_err(|error| GapError::Scene(error.to_string()))?;
        }
    }
    Ok(all)
}

/// Reads all that a comparison needs.
pub(super) fn prepare(args: &InputArgs) -> Result<Prepared> {
    let given = model(&args.model)?;
    check_names(&args.leave_out)?;
    let train = load(&args.measured, &args.scene, &given, args.as_is)?;
    let mut notes = train.notes;
    let held = match (&args.validate, &args.validate_scene) {
        (Some(recording), Some(scene)) => {
            let held = load(recording, scene, &given, args.as_is)?;
            notes.extend(held.notes);
            HeldOut::Recording(held.case)
        }
        _ => HeldOut::Later,
    };
    let inputs = Inputs {
        train: train.case,
        held,
        model: given,
        nominal: train.nominal,
        left_out: args.leave_out.clone(),
        seed: args.seed,
        is_quick: args.quick,
    };
    let mut prepared = Prepared::new(inputs).context(BadInput)?;
    for note in &prepared.notes {
        say(format!("note      {note}"));
    }
    prepared.notes.splice(0..0, notes);
    Ok(prepared)
}

fn check_names(names: &[String]) -> Result<()> {
    for name in names {
        if STAGES.iter().all(|spec| spec.name != name) {
            let known: Vec<&str> = STAGES.iter().map(|spec| spec.name).collect();
            let problem = anyhow::anyhow!(source::unknown("effect", name, &known));
            return Err(problem.context(BadInput));
        }
    }
    Ok(())
}
