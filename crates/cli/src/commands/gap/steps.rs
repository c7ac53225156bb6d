//! The steps of `evpose gap run` one by one.

use anyhow::{Context, Result};
use evpose_core::{Micros, TimeWindow, seed_for};
use evpose_gap::search::{DataSplits, Identification};
use evpose_gap::verdict::Answer;
use evpose_gap::workflow::{
    Directions, Prepared, ablation, answer_score, findings_of_answer, limits, prepared,
};
use evpose_gap::{
    Layout, Objective, ReferenceScene, View, by_block, locate as places, rho_of_chance,
};

use super::args::{CorrectArgs, InputArgs, PowerArgs};
use super::inputs;
use crate::bad_input::BadInput;
use crate::outputs::write_file;
use crate::pages::gap::words;
use crate::progress::{say, spinner};
use crate::scene_source::SceneSource;
use crate::threads::use_threads;
use evpose_report::format::{percent, short};

/// Runs that a model is compared by.
const RUNS: u64 = 8;
const LISTED: usize = 20;
/// Effects that are this much alike are listed.
const ALIKE: f64 = 0.9;

/// `evpose gap probe`.
pub(super) fn probe(args: &InputArgs) -> Result<()> {
    use_threads(args.threads)?;
    let prepared = inputs::prepare(args)?;
    let held_out = prepared.data_splits()?.held_out;
    let expected = held_out.expect(&prepared.model.config, RUNS)?;
    let z = expected.deviations(held_out.layout, &held_out.measured);
    say(format!(
        "gap       {:.2}; 1 is a fresh run of the model",
        // In units of chance, so that 1 is what a fresh run of the model has.
        evpose_gap::gap(held_out.layout, &z)
    ));
    for (block, distance) in by_block(held_out.layout, &z) {
        say(format!("  {:<34}{:>8.2}", words::block(block), distance / rho_of_chance()));
    }
    say(format!("{:<54}{:>12}{:>12}{:>8}", "largest deviations", "measured", "expected", "z"));
    let mut order: Vec<usize> = (0..z.len()).collect();
    // Largest first, whatever the sign.
    order.sort_by(|a, b| z[*b].abs().total_cmp(&z[*a].abs()));
    for i in order.into_iter().take(LISTED) {
        let entry = &held_out.layout.entries[i];
        say(format!(
            "  {:<52}{:>12}{:>12}{:>8.1}",
            entry.name,
            short(held_out.measured[i]),
            short(expected.mean[i]),
            z[i]
        ));
    }
    Ok(())
}

/// `evpose gap locate`.
pub(super) fn locate(args: &InputArgs) -> Result<()> {
    use_threads(args.threads)?;
    let prepared = inputs::prepare(args)?;
    let held_out = prepared.data_splits()?.held_out;
    let simulated = |run| {
        let seed = seed_for(args.seed, "stream", run);
        held_out.reference_scene.simulate(&prepared.model.config, seed)
    };
    let runs = (0..RUNS).map(simulated).collect::<Result<Vec<_>, _>>()?;
    let view = |events| View::new(held_out.reference_scene, events, held_out.window);
    let runs: Vec<View<'_>> = runs.iter().map(view).collect();
    let place = places::locate(&view(&held_out.events), &runs).location();
    say(&place.sentence);
    for (axis, share) in &place.shares {
        say(format!("  {:<40}{:>6}", words::axis(axis), percent(*share)));
    }
    Ok(())
}

/// `evpose gap name`.
pub(super) fn name(args: &InputArgs) -> Result<(Answer, bool)> {
    use_threads(args.threads)?;
    with_name(args, |_, splits, result| {
        for finding in findings_of_answer(splits, result)? {
            say(format!("  {}: {}", finding.name, words::parameters(&finding)));
            if let Some(formula) = words::formula(&finding) {
                say(format!("    {formula}"));
            }
            if let Some(explained) = finding.explained {
                say(format!(
                    "    explains {} of the gap alone, {} beside the others",
                    percent(explained.alone),
                    percent(explained.beside_others)
                ));
            }
            if !finding.confusable_with.is_empty() {
                say(format!(
                    "    not to be distinguished from {}",
                    finding.confusable_with.join(", ")
                ));
            }
        }
        // Without a gap there is nothing to be unexplained.
        if result.answer != Answer::NoGap {
            say(format!("  unexplained: {} of the gap", percent(result.left.fraction)));
        }
        Ok(())
    })
}

/// `evpose gap correct`.
pub(super) fn correct(args: &CorrectArgs) -> Result<(Answer, bool)> {
    use_threads(args.inputs.threads)?;
    with_name(&args.inputs, |_, _, result| {
        write_file(&args.out, answer_score(result).model.to_toml())?;
        let what = match result.answer {
            Answer::Effects => "the model with the identified effects",
            Answer::Partial => "the model with what explains a part of the gap",
            Answer::NoGap => "nothing to correct: the model as given",
            Answer::Undecided => "undecided: the model with one of the candidates that would do",
            Answer::NoneOfCatalogue if !result.added_effects.is_empty() => {
                "no effect is named: the model with a formula for what is missing"
            }
            Answer::Parameter | Answer::NoneOfCatalogue => {
                "no effect is named: the model with its parameters refitted"
            }
        };
        say(format!("{what}, written to {}", args.out.display()));
        Ok(())
    })
}

/// `evpose gap ablate`.
pub(super) fn ablate(args: &InputArgs) -> Result<(Answer, bool)> {
    use_threads(args.threads)?;
    with_name(args, |prepared, splits, result| {
        for row in ablation(splits, result, prepared.seed)? {
            say(format!("  {:<44} gap {}", words::change(&row), words::gap(&row.gap)));
        }
        Ok(())
    })
}

/// Names what is missing, says so, and goes on.
fn with_name(
    args: &InputArgs,
    then: impl FnOnce(&Prepared, &DataSplits<'_>, &Identification) -> Result<()>,
) -> Result<(Answer, bool)> {
    let prepared = inputs::prepare(args)?;
    let splits = prepared.data_splits()?;
    let spinner = spinner();
    let progress = |what: &str| spinner.set_message(what.to_owned());
    let mut result = splits.identify(&prepared.model.config, &prepared.left_out, &progress)?;
    // Before anything is printed: nuisance parameters take effects out of the answer.
    if let Some(nuisance) = inputs::nuisance(args) {
        nuisance.restrict_identification(&mut result);
    }
    spinner.finish_and_clear();
    if result.is_cut {
        say(words::OUT_OF_TIME);
    }
    let names: Vec<&str> = result.added_effects.iter().map(|added| added.name()).collect();
    let mut gaps = format!("gap {:.2} as given", result.before.gap);
    if result.refitted.gap != result.before.gap {
        gaps += &format!(", {:.2} with its parameters refitted", result.refitted.gap);
    }
    if !names.is_empty() {
        let is_named = matches!(result.answer, Answer::Effects | Answer::Partial);
        // Contenders were tried in the search, whose gap is shown, but they are no answer.
        let tried = if is_named { "" } else { " (not named)" };
        gaps += &format!(", {:.2} with {}{tried}", result.after.gap, names.join(" + "));
    }
    say(format!("{:<18}{gaps}", result.answer.key()));
    then(&prepared, &splits, &result)?;
    Ok((result.answer, result.is_cut))
}

/// `evpose gap power`.
pub(super) fn power(args: &PowerArgs) -> Result<()> {
    use_threads(args.threads)?;
    let path = args.scene.clone();
    let mut source = SceneSource { path, poses: None, seconds: None, response: None };
    // Rendering is the slow part: no more of the scene than is used below.
    if source.is_rendered() {
        source.seconds = Some(args.seconds);
    }
    let loaded = source.load().context(BadInput)?;
    let model = prepared(&inputs::model(&args.model)?, loaded.nominal.as_ref());
    let scene = loaded.scene.first(Micros::from_seconds(args.seconds));
    // A window excludes its end, and events at the last frame count.
    let window = TimeWindow { start: Micros(0), end: scene.duration() + Micros(1) };
    let reference_scene = ReferenceScene::new(scene, &model.reference)?;
    let events = reference_scene.simulate(&model.config, seed_for(args.seed, "stream", 0))?;
    say(format!("{} events in {:.3} s", events.len(), window.length().as_seconds()));
    let layout = Layout::of_all_probes();
    let objective =
        Objective::new(&reference_scene, &layout, &events, window, &model.reference, args.seed)?;
    let directions = Directions::simulate(&objective, &model.config, &[])?;
    let found = limits(&directions);
    say("would show from");
    for limit in &found.limits {
        let value = short(limit.value);
        say(format!("  {:<28}{} = {value} {}", limit.name, limit.parameter, limit.unit));
    }
    say("would not show");
    for (name, reason) in &found.untestable {
        say(format!("  {name:<28}{reason}"));
    }
    say("look alike (|cos| of what they do)");
    // Each pair once: likeness is symmetric.
    for (a, one) in directions.all.iter().enumerate().filter(|(_, one)| one.limit.is_some()) {
        for (b, other) in directions.all.iter().enumerate().take(a) {
            let likeness = directions.likeness(a, b);
            if other.limit.is_some() && likeness > ALIKE {
                say(format!("  {likeness:.3}  {}  {}", other.name, one.name));
            }
        }
    }
    Ok(())
}
