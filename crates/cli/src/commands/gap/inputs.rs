//! Reads the inputs of a comparison and reports their problems before anything is compared.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use evpose_core::{EventStream, Micros, TimeWindow};
use evpose_gap::GapError;
use evpose_gap::davis::Shots;
use evpose_gap::input::{LoadedRecording, LoadedScene, Nominal, Problem, Problems, load_recording};
use evpose_gap::search::Budget;
use evpose_gap::workflow::{
    ComparisonCase, FRAME_NUISANCE, HeldOut, Inputs, Nuisance, NuisanceSample, POSE_NUISANCE,
    Prepared, prepared, with_stamp_period,
};
use evpose_io::OpenOptions;
use evpose_sensor::{STAGES, SensorConfig, SensorModel};

use super::args::InputArgs;
use super::davis;
use super::note::InputNote;
use crate::bad_input::BadInput;
use crate::progress::say;
use crate::scene_source::{FRAMES, SceneSource, as_gap_error};
use crate::sensor_source as source;

/// A recording beside its scene, as read.
pub(super) struct Loaded {
    /// Recording and scene of the comparison.
    pub(super) case: ComparisonCase,
    /// Nominal values of the sensor, as given with the recording.
    pub(super) nominal: Option<Nominal>,
    /// Unit of the recording's time stamps.
    pub(super) tick: Micros,
    /// Notes on the input, its problems and their corrections, a line each.
    pub(super) notes: Vec<String>,
    /// The frames of the recording, where these are the scene.
    pub(super) shots: Option<Shots>,
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
    options: &OpenOptions,
    scene: &SceneSource,
    model: &SensorConfig,
    as_is: bool,
) -> Result<Loaded> {
    let load = if scene.is_frames() { davis::load } else { load_all };
    load(measured, options, scene, model, as_is).context(BadInput)
}

fn load_all(
    measured: &Path,
    options: &OpenOptions,
    source: &SceneSource,
    model: &SensorConfig,
    as_is: bool,
) -> Result<Loaded> {
    let scene = source.load()?;
    let mut recording = load_recording(measured, Some(scene.scene.size()), options)?;
    let mut duration_s = scene.duration_s;
    let is_part = scene.scene.duration().as_seconds() < PART * scene.duration_s;
    if source.is_rendered() || is_part {
        // Events behind the rendered part have no light to be compared with.
        duration_s = scene.scene.duration().as_seconds();
        cut(&mut recording, &scene)?;
    }
    let properties = scene.notes.iter().chain(&recording.notes).cloned();
    let mut notes: Vec<InputNote> = properties.map(InputNote::property).collect();
    let reference = prepared(model, scene.nominal.as_ref()).reference;
    let reference = scene.scene.events(&reference, 0)?;
    let problems = Problems::find(&recording, duration_s, &reference);
    // What does not belong together is not repaired: the run ends below.
    let repaired = !as_is && !problems.is_uncorrectable();
    for problem in &problems.list {
        let is_repaired = matches!(
            problem,
            Problem::Unit { .. } | Problem::Start { .. } | Problem::Orientation(_)
        );
        notes.push(InputNote::of(problem, is_repaired && repaired));
    }
    let lines = scene.provenance.iter().chain(&recording.provenance);
    let lines = lines.map(|line| format!("read      {line}"));
    lines.chain(notes.iter().map(InputNote::on_terminal)).for_each(say);
    // After the notes, which say why.
    if problems.is_uncorrectable() {
        return Err(GapError::Recording(format!(
            "{} and {} do not belong together",
            measured.display(),
            source.path.display()
        ))
        .into());
    }
    let events = if repaired { problems.repair(&recording.events) } else { recording.events };
    if let Some(note) = outside(&events, scene.scene.duration()) {
        let note = InputNote::property(note);
        say(note.on_terminal());
        notes.push(note);
    }
    let case = ComparisonCase::new(&events, scene.scene)?;
    let notes = notes.into_iter().map(InputNote::in_verdict).collect();
    Ok(Loaded { case, nominal: scene.nominal, tick: recording.tick, notes, shots: None })
}

/// A note on events that the scene does not cover.
fn outside(events: &EventStream, end: Micros) -> Option<String> {
    let early = events.t().partition_point(|t| *t < Micros(0));
    // An event at the last frame still has its light.
    let late = events.len() - events.t().partition_point(|t| *t <= end);
    let last_s = end.as_seconds();
    (early + late > 0).then(|| {
        format!(
            "{early} events before time 0 and {late} behind the last frame, at {last_s} s, are not \
             compared"
        )
    })
}

/// A scene that is shorter than this fraction of the stated duration was read in part.
const PART: f64 = 0.9;
/// A recording of a config's sequence is no longer than this times the sequence.
const SPARE: f64 = 1.1;

/// Leaves of a recording what a scene covers that was rendered in part. What is much longer than
/// the whole sequence has stamps in another unit: that is for the search for problems to say.
fn cut(recording: &mut LoadedRecording, scene: &LoadedScene) -> Result<(), GapError> {
    let window = TimeWindow { start: Micros(0), end: scene.scene.duration() + Micros(1) };
    // Cutting it would hide that its stamps are in another unit.
    let last_s = recording.events.t().last().map_or(0.0, |t| t.as_seconds());
    if last_s > SPARE * scene.duration_s {
        return Ok(());
    }
    let part = recording.events.slice(window);
    if part.is_empty() {
        return Err(GapError::Recording(format!(
            "no events in the {} s that the scene was rendered for",
            scene.scene.duration().as_seconds()
        )));
    }
    recording.events = part;
    Ok(())
}

/// The scene of the first recording, and that of the second.
pub(super) fn sources(args: &InputArgs) -> (SceneSource, Option<SceneSource>) {
    let source = |path: &Path, poses: &Option<PathBuf>| SceneSource {
        path: path.to_owned(),
        poses: poses.clone(),
        seconds: args.seconds,
        response: args.response,
    };
    let held_out = args.validate_scene.as_deref();
    (source(&args.scene, &args.poses), held_out.map(|path| source(path, &args.validate_poses)))
}

/// Nuisance of the scenes of a comparison; none if their light is given.
pub(super) fn nuisance(args: &InputArgs) -> Option<&'static Nuisance> {
    match (&args.poses, args.scene == Path::new(FRAMES)) {
        (Some(_), _) => Some(&POSE_NUISANCE),
        (None, true) => Some(&FRAME_NUISANCE),
        (None, false) => None,
    }
}

/// Reads all that a comparison needs.
pub(super) fn prepare(args: &InputArgs) -> Result<Prepared> {
    // The budget runs from here on: reading and rendering count.
    let budget = args.budget.map(|s| Budget::from_now(Duration::from_secs_f64(s)));
    let given = model(&args.model)?;
    // A misspelt name would exclude nothing, and nobody would notice.
    check_names(&args.leave_out)?;
    let (train_scene, held_out_scene) = sources(args);
    if args.poses.is_some() && args.validate.is_some() && args.validate_poses.is_none() {
        let problem = anyhow::anyhow!("--poses with --validate takes --validate-poses as well");
        return Err(problem.context(BadInput));
    }
    if held_out_scene
        .as_ref()
        .is_some_and(|held_out| held_out.is_frames() != train_scene.is_frames())
    {
        let problem = anyhow::anyhow!("--scene frames and --validate-scene frames go together");
        return Err(problem.context(BadInput));
    }
    let options = |recording: &Path| args.opening.options(recording).context(BadInput);
    let train = load(&args.measured, &options(&args.measured)?, &train_scene, &given, args.as_is)?;
    // Coarse time stamps are the file's own, and no effect that the model lacks.
    let given = with_stamp_period(&given, train.tick);
    let mut notes = train.notes;
    if train.tick > Micros(1) {
        let note = format!("stamps count {} us: the model's do as well", train.tick.0);
        say(format!("note      {note}"));
        notes.push(note);
    }
    let (held_out, held_out_shots) = match (&args.validate, &held_out_scene) {
        (Some(recording), Some(scene)) => {
            let held_out = load(recording, &options(recording)?, scene, &given, args.as_is)?;
            notes.extend(held_out.notes);
            (HeldOut::Recording(held_out.case), held_out.shots)
        }
        _ => (HeldOut::Later, None),
    };
    let inputs = Inputs {
        train: train.case,
        held_out,
        model: given,
        nominal: train.nominal,
        left_out: args.leave_out.clone(),
        seed: args.seed,
        is_quick: args.quick,
    };
    let nuisance = nuisance(args);
    let samples = |shots: Option<Shots>, source: SceneSource| {
        move |i| match &shots {
            Some(shots) => shots.twin(i, args.seed),
            None => source.nuisance_sample(i).map_err(|error| as_gap_error(&error)),
        }
    };
    let mut prepared = match nuisance {
        Some(nuisance) => {
            let of_held_out = held_out_scene.map(|scene| samples(held_out_shots, scene));
            let of_held_out = of_held_out.as_ref().map(|sample| sample as NuisanceSample<'_>);
            Prepared::with_nuisance(
                inputs,
                nuisance,
                &samples(train.shots, train_scene),
                of_held_out,
            )
        }
        None => Prepared::new(inputs),
    }
    .context(BadInput)?;
    prepared.budget = budget;
    for note in &prepared.notes {
        say(format!("note      {note}"));
    }
    // What kind of comparison it is comes first.
    let first = usize::from(nuisance.is_some());
    prepared.notes.splice(first..first, notes);
    Ok(prepared)
}

fn check_names(names: &[String]) -> Result<()> {
    for name in names {
        if STAGES.find(name).is_none() {
            let known = STAGES.names();
            let problem = anyhow::anyhow!(source::unknown("effect", name, &known));
            return Err(problem.context(BadInput));
        }
    }
    Ok(())
}
