//! `evpose gap run`: from a recording to a verdict.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, anyhow};
use evpose_core::TimeWindow;
use evpose_gap::input::{Problem, load_recording};
use evpose_gap::report::{Fact, ReportData};
use evpose_gap::workflow::{AnswerEvidence, outcome, scene_free_verdict, with_stamp_period};

use super::args::{InputArgs, RunArgs};
use super::inputs;
use crate::bad_input::BadInput;
use crate::json::write_result;
use crate::outputs::write_file;
use crate::pages::gap as report;
use crate::pages::gap::files::{self, RunInfo, whole};
use crate::pages::gap::terminal;
use crate::progress::{say, spinner};
use crate::run_info::COMMIT;
use crate::scene_source;
use crate::scene_source::NONE;
use crate::threads::use_threads;

/// Everything that a run writes.
struct Written {
    report: ReportData,
    evidence: AnswerEvidence,
    before: String,
    after: String,
    held_out: Option<TimeWindow>,
    seconds: BTreeMap<String, f64>,
}

pub(super) fn run(args: &RunArgs) -> Result<u8> {
    use_threads(args.inputs.threads)?;
    let written = if args.inputs.scene == Path::new(NONE) {
        alone(&args.inputs)?
    } else {
        compared(&args.inputs)?
    };
    write(args, &written)?;
    terminal::lines(&written.report).iter().for_each(say);
    say(format!("written to {}", args.out.display()));
    Ok(written.report.verdict.exit_code())
}

fn compared(args: &InputArgs) -> Result<Written> {
    let mut clock = Clock::start();
    let prepared = inputs::prepare(args)?;
    let splits = prepared.data_splits()?;
    clock.lap("inputs");
    let spinner = spinner();
    let progress = |what: &str| spinner.set_message(what.to_owned());
    let result = splits.identify(&prepared.model.config, &prepared.left_out, &progress)?;
    clock.lap("naming");
    let mut outcome = outcome(&prepared, &splits, &result, &progress)?;
    // Before anything is written: nuisance parameters take effects out of the verdict.
    if let Some(nuisance) = inputs::nuisance(args) {
        nuisance.restrict(&mut outcome.report.verdict);
        outcome.evidence.restrict(&outcome.report.verdict.effects);
    }
    clock.lap("verdict");
    spinner.finish_and_clear();
    Ok(Written {
        report: outcome.report,
        evidence: outcome.evidence,
        before: prepared.model.config.to_toml(),
        after: outcome.corrected.to_toml(),
        held_out: Some(splits.held_out.window),
        seconds: clock.seconds,
    })
}

/// A recording without a scene.
fn alone(args: &InputArgs) -> Result<Written> {
    let mut clock = Clock::start();
    // Options that only a scene gives a meaning are refused, not ignored.
    let of_a_scene = [
        ("--validate", args.validate.is_some()),
        ("--poses", args.poses.is_some()),
        ("--seconds", args.seconds.is_some()),
        ("--response", args.response.is_some()),
    ];
    if let Some((option, _)) = of_a_scene.into_iter().find(|(_, is_given)| *is_given) {
        return Err(anyhow!("{option} needs a scene, and --scene is none").context(BadInput));
    }
    let model = inputs::model(&args.model)?;
    let options = args.opening.options(&args.measured).context(BadInput)?;
    let recording = load_recording(&args.measured, None, &options).context(BadInput)?;
    for line in &recording.provenance {
        say(format!("read      {line}"));
    }
    for note in &recording.notes {
        say(format!("note      {note}"));
    }
    // A camera's tick is no effect to be found: the model gets it first.
    let model = with_stamp_period(&model, recording.tick);
    clock.lap("inputs");
    // Hundreds of copies of a recording take minutes.
    let spinner = spinner();
    spinner.set_message("comparing the recording with copies whose times are redrawn");
    let mut verdict = scene_free_verdict(&recording.events, &model, args.quick, args.seed);
    spinner.finish_and_clear();
    verdict.notes.extend(recording.notes);
    if recording.outside > 0 {
        verdict.notes.push(Problem::Outside(recording.outside).to_string());
    }
    clock.lap("verdict");
    let mut after = model.clone();
    for finding in &verdict.effects {
        after.effects.extend(evpose_gap::workflow::as_effect(finding));
    }
    let mut report = ReportData::from_verdict(verdict);
    (report.model_before, report.model_after) = (model.to_toml(), after.to_toml());
    Ok(Written {
        before: model.to_toml(),
        after: after.to_toml(),
        report,
        evidence: AnswerEvidence::default(),
        held_out: None,
        seconds: clock.seconds,
    })
}

fn write(args: &RunArgs, written: &Written) -> Result<()> {
    let dir = &args.out;
    std::fs::create_dir_all(dir).with_context(|| format!("creating {}", dir.display()))?;
    write_file(&dir.join(files::MODEL), &written.before)?;
    write_file(&dir.join(files::CORRECTED), &written.after)?;
    write_result(&dir.join(files::VERDICT), &written.report.verdict)?;
    write_result(&dir.join(files::EVIDENCE), &written.evidence)?;
    let inputs = &args.inputs;
    let is_alone = inputs.scene == Path::new(NONE);
    // Absolute paths: `verify` is run from anywhere.
    let path = |path: &Option<std::path::PathBuf>| path.as_deref().map(whole).transpose();
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let info = RunInfo {
        command: std::env::args().collect::<Vec<_>>().join(" "),
        commit: COMMIT.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: inputs.seed,
        quick: inputs.quick,
        measured: whole(&inputs.measured)?,
        scene: if is_alone { None } else { Some(scene_source::whole(&inputs.scene)?) },
        validate: path(&inputs.validate)?,
        validate_scene: inputs.validate_scene.as_deref().map(scene_source::whole).transpose()?,
        poses: path(&inputs.poses)?,
        validate_poses: path(&inputs.validate_poses)?,
        scene_seconds: inputs.seconds,
        response: inputs.response.map(|response| response.to_string()),
        as_is: inputs.as_is,
        reading: inputs.opening.options(&inputs.measured)?,
        held_s: written.held_out.map(|w| [w.start.as_seconds(), w.end.as_seconds()]),
        model: inputs.model.clone(),
        model_before: files::MODEL.to_owned(),
        model_after: files::CORRECTED.to_owned(),
        leave_out: inputs.leave_out.clone(),
        seconds: written.seconds.clone(),
        finished_unix_s: now,
    };
    // The models that it names are there by now: `verify` finds a whole run, or none.
    write_result(&dir.join(files::RUN), &info)?;
    let mut report = written.report.clone();
    report.provenance = provenance(&info);
    let json = report.to_json(&dir.join(files::REPORT))?;
    write_file(&dir.join(files::REPORT), json)?;
    report::write(dir, &report)?;
    Ok(())
}

fn provenance(info: &RunInfo) -> Vec<Fact> {
    let text = |path: &Path| path.display().to_string();
    let mut facts = vec![
        Fact::new("recording", text(&info.measured)),
        Fact::new("scene", info.scene.as_deref().map_or_else(|| NONE.to_owned(), text)),
        Fact::new("model", &info.model),
        Fact::new("seed", info.seed.to_string()),
        Fact::new("program", format!("evpose {}, commit {}", info.version, info.commit)),
        Fact::new("command", &info.command),
    ];
    if let Some(recording) = &info.validate {
        // Held-out data are a second recording, or a part of this one.
        facts.insert(2, Fact::new("held out", text(recording)));
    } else if let Some([from, to]) = info.held_s {
        facts.insert(2, Fact::new("held out", format!("{from:.3} s to {to:.3} s")));
    }
    let whole: f64 = info.seconds.values().sum();
    facts.push(Fact::new("time taken", format!("{whole:.1} s")));
    facts
}

/// Seconds of the parts of a run.
struct Clock {
    since: Instant,
    seconds: BTreeMap<String, f64>,
}

impl Clock {
    fn start() -> Self {
        Self { since: Instant::now(), seconds: BTreeMap::new() }
    }

    fn lap(&mut self, name: &str) {
        self.seconds.insert(name.to_owned(), self.since.elapsed().as_secs_f64());
        self.since = Instant::now();
    }
}
