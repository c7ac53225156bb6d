//! The verdict, the corrected model and the report, from what was named.

use evpose_core::{EventStream, Micros, seed_for};
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::chance::chance_of_largest;
use super::findings::{Evidenced, evidenced};
use super::gap_value::{RUNS, deviations, resampled};
use super::{Directions, Prepared, ablation, gap_value, limits};
use crate::answer::reduction;
use crate::c2st::two_sample;
use crate::locate::{Located, locate};
use crate::naming::{Bench, Judged, Named};
use crate::report::{
    Confusability, Doubt, Film, Ranked, ReportData, block_gaps, plots, probe_rows,
};
use crate::verdict::{Answer, Finding, Remaining, SCHEMA, TwoSample, Verdict};
use crate::{GapError, Lab, View};

/// Replicates for the probability of the largest deviation, in full and quick.
const REPLICATES: [u64; 2] = [199, 39];
/// Runs that say where models disagree, in full and quick.
const LOCATING: [u64; 2] = [8, 4];
/// Resamples for gaps of blocks.
const RESAMPLES: u64 = 60;
/// Gaps above this are larger than those of fresh runs of the model.
const CLOSED: f64 = 1.0;
/// Frames of the film and how long each is.
const FRAMES: usize = 24;
const FRAME: Micros = Micros(10_000);

/// All that comes of a comparison.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The answer.
    pub verdict: Verdict,
    /// The sensor model with what was found.
    pub corrected: SensorConfig,
    /// What a page is drawn from.
    pub report: ReportData,
}

/// What an answer stands for: effects are added only where they are named.
pub fn answered(named: &Named) -> &Judged {
    match named.answer {
        Answer::Effects | Answer::Parameter => &named.after,
        Answer::NoGap => &named.before,
        Answer::NoneOfCatalogue | Answer::Undecided => &named.refitted,
    }
}

/// The findings of an answer: none where nothing is named.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn effects_of(bench: &Bench<'_>, named: &Named) -> Result<Vec<Finding>, GapError> {
    let all = evidence_of(bench, named)?;
    Ok(all.into_iter().map(|evidenced| evidenced.finding).collect())
}

/// The same with what each finding rests on.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn evidence_of(bench: &Bench<'_>, named: &Named) -> Result<Vec<Evidenced>, GapError> {
    match named.answer {
        Answer::Effects | Answer::Parameter => evidenced(bench, named),
        Answer::NoGap | Answer::NoneOfCatalogue | Answer::Undecided => Ok(Vec::new()),
    }
}

/// Makes the verdict of what was named.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn outcome(
    prepared: &Prepared,
    bench: &Bench<'_>,
    named: &Named,
    say: &dyn Fn(&str),
) -> Result<Outcome, GapError> {
    let (held, seed) = (&bench.held, prepared.seed);
    let quick = usize::from(prepared.is_quick);
    let (given, after) = (&named.before.model, answered(named));
    say("numbers with their intervals");
    let effects = effects_of(bench, named)?;
    say("what would have shown");
    let directions = Directions::of(&bench.screen, given, &prepared.left_out)?;
    let limits = limits(&directions);
    say("where they disagree");
    let runs = streams(held, given, LOCATING[quick], seed)?;
    let corrected = streams(held, &after.model, LOCATING[quick], seed)?;
    let (measured, run_views, corrected_views) =
        (view(held, &held.events), views(held, &runs), views(held, &corrected));
    let before = locate(&measured, &run_views);
    let left = locate(&measured, &corrected_views);
    say("whether a classifier tells them apart");
    let check = |runs: &[EventStream]| -> TwoSample {
        two_sample(&held.events, &runs[..runs.len().min(4)], held.window, seed)
    };
    let (c2st_before, c2st_after) = (check(&runs), check(&corrected));
    say("the probability of chance");
    let p = chance_of_largest(held, given, REPLICATES[quick])?;
    say("taking it out again");
    let trials = ablation(bench, &of_answer(named), seed)?;
    let spread = |model: &SensorConfig| deviations(&bench.screen, model);
    let remaining = remaining(named, &left, &directions, &spread(&after.model)?);
    let verdict = Verdict {
        schema: SCHEMA,
        verdict: named.answer,
        effects,
        remaining,
        gap_before: gap_value(held, given, seed)?,
        gap_after: gap_value(held, &after.model, seed)?,
        grr: reduction(&named.before, after),
        p,
        place: before.place(),
        stage_shares: directions.shares(&spread(given)?),
        limits: limits.limits,
        untestable: limits.untestable,
        c2st_before: Some(c2st_before),
        c2st_after: Some(c2st_after),
        notes: prepared.notes.clone(),
    };
    let z = (deviations(held, given)?, deviations(held, &after.model)?);
    let pairs: Vec<_> = resampled(held, given, seed, RESAMPLES)?
        .into_iter()
        .zip(resampled(held, &after.model, seed, RESAMPLES)?)
        .collect();
    let expected = (held.expect(given, RUNS)?, held.expect(&after.model, RUNS)?);
    let sets = [("measured", &held.events), ("model", &runs[0]), ("corrected", &corrected[0])];
    let report = ReportData {
        blocks: block_gaps(held.layout, (&z.0, &z.1), &pairs),
        probes: probe_rows(held.layout, &held.measured, &expected.0, &expected.1),
        before,
        after: Some(left),
        plots: plots(&measured, &run_views, &corrected_views),
        candidates: ranked(named),
        misfit_without: Some(named.refitted.misfit),
        confusability: confusability(&directions, named),
        ablation: trials,
        film: Film::of(&sets, held.window, FRAME, FRAMES),
        model_before: given.to_toml(),
        model_after: after.model.to_toml(),
        doubts: Doubt::of(&verdict),
        ..ReportData::of(verdict.clone())
    };
    Ok(Outcome { verdict, corrected: after.model.clone(), report })
}

/// What is named, without what was tried in vain.
fn of_answer(named: &Named) -> Named {
    let mut answer = named.clone();
    answer.after = answered(named).clone();
    if !matches!(named.answer, Answer::Effects) {
        answer.steps.clear();
    }
    answer
}

fn streams(
    lab: &Lab<'_>,
    model: &SensorConfig,
    runs: u64,
    seed: u64,
) -> Result<Vec<EventStream>, GapError> {
    (0..runs)
        .into_par_iter()
        .map(|run| lab.stage.simulate(model, seed_for(seed, "stream", run)))
        .collect()
}

fn view<'a>(lab: &Lab<'a>, events: &EventStream) -> View<'a> {
    View::new(lab.stage, events, lab.window)
}

fn views<'a>(lab: &Lab<'a>, streams: &[EventStream]) -> Vec<View<'a>> {
    streams.par_iter().map(|events| view(lab, events)).collect()
}

fn remaining(
    named: &Named,
    left: &Located,
    directions: &Directions,
    deviations: &[f64],
) -> Remaining {
    let shares = directions.shares(deviations);
    let nearest = shares.iter().max_by(|a, b| a.1.total_cmp(b.1));
    let is_open = answered(named).gap > CLOSED;
    let is_unnamed = matches!(named.answer, Answer::NoneOfCatalogue | Answer::Undecided);
    let mut sentence = left.scan.sentence.clone();
    if named.answer == Answer::Undecided {
        let names = named.steps.iter().flat_map(|step| {
            let best = step.contenders.first().map(|best| best.found.name);
            best.into_iter().chain(step.confusable.iter().copied())
        });
        let names: Vec<&str> = names.collect();
        sentence = format!("Any of these would do: {}. {sentence}", names.join(", "));
    }
    Remaining {
        is_significant: is_open || is_unnamed,
        nearest_stage: nearest.map_or_else(String::new, |(name, _)| name.clone()),
        sentence,
    }
}

/// Every candidate that was judged, by what it leaves on what was held out.
fn ranked(named: &Named) -> Vec<Ranked> {
    let Some(step) = named.steps.first() else { return Vec::new() };
    let row = |contender: &crate::naming::Contender| Ranked {
        name: contender.found.name.to_owned(),
        misfit: contender.held.misfit,
        error: None,
        is_fitted: true,
        parameters: Default::default(),
    };
    step.contenders.iter().map(row).collect()
}

/// How alike what was judged looks, or all that shows where nothing was.
fn confusability(directions: &Directions, named: &Named) -> Confusability {
    let judged: Vec<&str> = named
        .steps
        .iter()
        .flat_map(|step| step.contenders.iter().map(|contender| contender.found.name))
        .collect();
    let is_shown = |i: &usize| {
        let direction = &directions.all[*i];
        direction.limit.is_some() && (judged.is_empty() || judged.contains(&direction.name))
    };
    let shown: Vec<usize> = (0..directions.all.len()).filter(is_shown).take(16).collect();
    let row = |a: &usize| shown.iter().map(|b| directions.likeness(*a, *b)).collect();
    Confusability {
        names: shown.iter().map(|i| directions.all[*i].name.to_owned()).collect(),
        cosines: shown.iter().map(row).collect(),
    }
}
