//! The verdict, the corrected model and the report, from the result of a search.

use std::collections::BTreeMap;

use evpose_core::{EventStream, Micros, seed_for};
use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::chance::p_of_largest_deviation;
use super::evidence::AnswerEvidence;
use super::findings::{EvidencedFinding, evidenced_findings};
use super::gap_value::{RUNS, deviations, resampled};
use super::next_step::next_step;
use super::stage_shares::stage_shares;
use super::{Directions, Prepared, ablation, gap_value, limits};
use crate::c2st::two_sample;
use crate::locate::{Located, Response, locate};
use crate::report::{
    CORRECTED_NOTE, Confusability, Doubt, ReportData, SideBySide, block_gaps, plots, probe_rows,
};
use crate::search::{DataSplits, Identification, ModelScore, StageCallback};
use crate::verdict::{Answer, Finding, SCHEMA, TwoSample, Unexplained, Verdict};
use crate::{GapError, Objective, View};

/// Replicates for the p-value of the largest deviation, in full and in quick runs.
const REPLICATES: [u64; 2] = [199, 39];
/// Runs that locate the disagreement, in full and in quick runs.
const LOCATING_RUNS: [u64; 2] = [8, 4];
/// Runs of the classifier two-sample test.
const CLASSIFIED_RUNS: usize = 4;
/// Bootstrap resamples for gaps of blocks.
const RESAMPLES: u64 = 60;
/// Frames of the side-by-side animation, and the length of each.
const FRAMES: usize = 24;
const FRAME: Micros = Micros(10_000);
/// Maximum effects in the matrix of confusable effects.
const MAX_CONFUSABLE: usize = 16;

/// All results of a comparison.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Answer of the run, as `verdict.json` has it.
    pub verdict: Verdict,
    /// Values that its probabilities and intervals come from.
    pub evidence: AnswerEvidence,
    /// The corrected sensor model.
    pub corrected: SensorConfig,
    /// Data of the report.
    pub report: ReportData,
}

/// The corrected model of an answer.
pub fn answer_score(result: &Identification) -> &ModelScore {
    match result.answer {
        Answer::NoGap => &result.before,
        _ => &result.after,
    }
}

/// Findings of an answer, without names that failed their tests; empty where there is no gap.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn findings_of_answer(
    splits: &DataSplits<'_>,
    result: &Identification,
) -> Result<Vec<Finding>, GapError> {
    let all = evidence_of_answer(splits, result)?;
    let findings = all.into_iter().map(|evidenced| evidenced.finding);
    Ok(findings.filter(|finding| !finding.is_demoted()).collect())
}

fn evidence_of_answer(
    splits: &DataSplits<'_>,
    result: &Identification,
) -> Result<Vec<EvidencedFinding>, GapError> {
    match result.answer {
        Answer::NoGap => Ok(Vec::new()),
        _ => evidenced_findings(splits, result),
    }
}

/// Makes verdict, corrected model and report from the result of a search.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn outcome(
    prepared: &Prepared,
    splits: &DataSplits<'_>,
    result: &Identification,
    progress: StageCallback<'_>,
) -> Result<Outcome, GapError> {
    let (held_out, seed) = (&splits.held_out, prepared.seed);
    let quick = usize::from(prepared.is_quick);
    let (given, after) = (&result.before.model, answer_score(result));
    progress("estimates with their intervals");
    let findings = evidence_of_answer(splits, result)?;
    let evidence = AnswerEvidence::new(splits, result, &findings);
    let findings = findings.into_iter().map(|evidenced| evidenced.finding);
    let (demoted, effects): (Vec<Finding>, Vec<Finding>) = findings.partition(Finding::is_demoted);
    progress("detection limits");
    // On the screening part: a direction takes a simulation for every effect and strength.
    let directions = Directions::simulate(&splits.screen, given, &prepared.left_out)?;
    let limits = limits(&directions);
    progress("location of the disagreement");
    let runs = streams(held_out, given, LOCATING_RUNS[quick], seed)?;
    let corrected = streams(held_out, &after.model, LOCATING_RUNS[quick], seed)?;
    let (measured, run_views, corrected_views) =
        (view(held_out, &held_out.events), views(held_out, &runs), views(held_out, &corrected));
    let before = locate(&measured, &run_views);
    let left = locate(&measured, &corrected_views);
    progress("classifier two-sample test");
    let check = |runs: &[EventStream]| -> TwoSample {
        let runs = &runs[..runs.len().min(CLASSIFIED_RUNS)];
        two_sample(&held_out.events, runs, held_out.window, seed)
    };
    let (c2st_before, c2st_after) = (check(&runs), check(&corrected));
    progress("p-value of the largest deviation");
    let p = p_of_largest_deviation(held_out, given, REPLICATES[quick])?;
    progress("ablation");
    let ablation = ablation(splits, result, seed)?;
    let on_screen = |model: &SensorConfig| deviations(&splits.screen, model);
    let of_left = directions.shares(&on_screen(&after.model)?);
    let unexplained = unexplained(result, &left, &of_left);
    let mut verdict = Verdict {
        schema: SCHEMA,
        verdict: result.answer,
        stage_shares: stage_shares(&effects, &unexplained, &of_left),
        effects,
        demoted,
        gap_before: gap_value(held_out, given, seed)?,
        gap_after: gap_value(held_out, &after.model, seed)?,
        grr: closed(&unexplained),
        unexplained,
        p,
        place: before.location(),
        limits: limits.limits,
        untestable: limits.untestable,
        c2st_before: Some(c2st_before),
        c2st_after: Some(c2st_after),
        corrections: corrections(&prepared.notes),
        is_out_of_time: result.is_cut,
        next: String::new(),
        notes: prepared.notes.clone(),
    };
    verdict.next = next_step(&verdict);
    let sets = [("measured", &held_out.events), ("model", &runs[0]), ("corrected", &corrected[0])];
    let report = ReportData {
        before,
        after: Some(left),
        plots: plots(&measured, &run_views, &corrected_views),
        confusability: confusability(&directions, result),
        ablation,
        side_by_side: SideBySide::render(&sets, held_out.window, FRAME, FRAMES),
        model_before: given.to_toml(),
        model_after: after.model.to_toml(),
        doubts: Doubt::for_verdict(&verdict),
        ..statistics(held_out, given, &after.model, &verdict, seed)?
    };
    Ok(Outcome { verdict, evidence, corrected: after.model.clone(), report })
}

/// A report with the statistics of all blocks, before and after.
fn statistics(
    held_out: &Objective<'_>,
    given: &SensorConfig,
    corrected: &SensorConfig,
    verdict: &Verdict,
    seed: u64,
) -> Result<ReportData, GapError> {
    let z = (deviations(held_out, given)?, deviations(held_out, corrected)?);
    // The same seed twice: pairs have the same draws, so that their difference has less noise.
    let pairs: Vec<_> = resampled(held_out, given, seed, RESAMPLES)?
        .into_iter()
        .zip(resampled(held_out, corrected, seed, RESAMPLES)?)
        .collect();
    let expected = (held_out.expect(given, RUNS)?, held_out.expect(corrected, RUNS)?);
    Ok(ReportData {
        blocks: block_gaps(held_out.layout, (&z.0, &z.1), &pairs),
        probes: probe_rows(held_out.layout, &held_out.measured, &expected.0, &expected.1),
        ..ReportData::from_verdict(verdict.clone())
    })
}

fn streams(
    objective: &Objective<'_>,
    model: &SensorConfig,
    runs: u64,
    seed: u64,
) -> Result<Vec<EventStream>, GapError> {
    (0..runs)
        .into_par_iter()
        .map(|run| objective.reference_scene.simulate(model, seed_for(seed, "stream", run)))
        .collect()
}

fn view<'a>(objective: &Objective<'a>, events: &EventStream) -> View<'a> {
    View::new(objective.reference_scene, events, objective.window)
}

fn views<'a>(objective: &Objective<'a>, streams: &[EventStream]) -> Vec<View<'a>> {
    streams.par_iter().map(|events| view(objective, events)).collect()
}

/// The part of the gap that the corrected model leaves, located in `left`.
fn unexplained(
    result: &Identification,
    left: &Located,
    of_left: &BTreeMap<String, f64>,
) -> Unexplained {
    let nearest = of_left.iter().max_by(|a, b| a.1.total_cmp(b.1));
    let location = left.location();
    Unexplained {
        fraction: result.left.fraction,
        p: result.left.p,
        is_significant: result.left.is_significant,
        nearest_stage: nearest.map_or_else(String::new, |(name, _)| name.clone()),
        sentence: location.sentence,
        shares: location.shares,
        responses: left.responses.iter().map(Response::sentence).collect(),
    }
}

/// Corrections of the input among notes.
fn corrections(notes: &[String]) -> Vec<String> {
    notes.iter().filter_map(|note| note.strip_prefix(CORRECTED_NOTE)).map(str::to_owned).collect()
}

/// Gap closed (fraction): what is not left.
fn closed(unexplained: &Unexplained) -> f64 {
    1.0 - unexplained.fraction
}

/// Cosines between the directions of all contenders, or of all detectable effects if there are
/// none.
fn confusability(directions: &Directions, result: &Identification) -> Confusability {
    let tested: Vec<&str> = result
        .added_effects
        .iter()
        .flat_map(|added| added.contenders.iter().map(|contender| contender.candidate.name))
        .collect();
    let is_shown = |i: &usize| {
        let direction = &directions.all[*i];
        direction.limit.is_some() && (tested.is_empty() || tested.contains(&direction.name))
    };
    let shown: Vec<usize> =
        (0..directions.all.len()).filter(is_shown).take(MAX_CONFUSABLE).collect();
    let row = |a: &usize| shown.iter().map(|b| directions.likeness(*a, *b)).collect();
    Confusability {
        names: shown.iter().map(|i| directions.all[*i].name.to_owned()).collect(),
        cosines: shown.iter().map(row).collect(),
    }
}
