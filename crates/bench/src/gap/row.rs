//! Identification of one case, as a line of results.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_gap::input::{load_recording, load_scene};
use evpose_gap::search::gap_closed;
use evpose_gap::verdict::{Answer, Finding, FindingKind};
use evpose_gap::workflow::{
    ComparisonCase as Pair, FindingEvidence, HeldOut, Inputs, Prepared, RawError, answer_score,
    evidence_of_answer,
};
use evpose_sensor::SensorConfig;
use gapbench_pixel::Case;
use serde::{Deserialize, Serialize};

use super::case_files::part;
use evpose_cli::pages::gap::words::answer_key;
use evpose_cli::run_info::COMMIT;

/// Seed of the noise of simulations, the same for all cases.
const SEED: u64 = 1;

fn one() -> usize {
    1
}

/// One case: nothing in it comes from the label.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Row {
    /// The case.
    pub(super) id: String,
    /// The answer in one word.
    pub(super) verdict: Answer,
    /// Identified effects and parameters.
    pub(super) effects: Vec<Finding>,
    /// Gap of the model as given, on the second recording, and of the corrected one.
    pub(super) gap_before: f64,
    pub(super) gap_after: f64,
    /// The share of it that is gone.
    pub(super) grr: f64,
    /// Evidence of the identified effects.
    #[serde(default)]
    pub(super) evidence: BTreeMap<String, FindingEvidence>,
    /// Uncertainty of the estimates of findings, before calibration.
    #[serde(default)]
    pub(super) errors: BTreeMap<String, BTreeMap<String, RawError>>,
    /// The best few of each step, named or not, with the discrepancy that they leave.
    pub(super) tried: Vec<Vec<(String, f64)>>,
    /// Events of the first recording.
    pub(super) events: usize,
    /// Threads that it ran on.
    #[serde(default = "one")]
    pub(super) threads: usize,
    /// Seconds to make the files, and to name from them.
    pub(super) make_s: f64,
    pub(super) name_s: f64,
    /// The program.
    pub(super) commit: String,
}

impl Row {
    /// All that it took.
    pub(super) fn seconds(&self) -> f64 {
        self.make_s + self.name_s
    }

    /// Seconds on a machine with two cores: one thread leaves the other core to another part
    /// of the plan.
    pub(super) fn seconds_on_two_cores(&self) -> f64 {
        self.seconds() * self.threads as f64 / 2.0
    }

    /// The effects that were named, in their order.
    pub(super) fn named(&self) -> impl Iterator<Item = &Finding> {
        self.effects.iter().filter(|effect| effect.kind == FindingKind::Effect)
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.effects.iter().map(|effect| effect.name.as_str()).collect();
        write!(
            f,
            "{}  {:<18}gap {:>5.2} to {:<5.2}{:>6.1} s  {}",
            self.id,
            answer_key(self.verdict),
            self.gap_before,
            self.gap_after,
            self.seconds(),
            names.join(" + ")
        )
    }
}

/// Names what is missing from the files of a case.
pub(super) fn name(folder: &Path, case: &Case, make_s: f64) -> Result<Row> {
    let begin = Instant::now();
    let read = |i| -> Result<_> {
        let (measured, dir) = part(folder, i);
        let scene = load_scene(&dir)?;
        let recording = load_recording(&measured, Some(scene.scene.size()))
            .with_context(|| measured.display().to_string())?;
        Ok((recording.events, scene))
    };
    let ((train, scene), (held_out, held_out_scene)) = (read(0)?, read(1)?);
    let nominal = scene.nominal;
    let prepared = Prepared::new(Inputs {
        train: Pair::new(&train, scene.scene)?,
        held_out: HeldOut::Recording(Pair::new(&held_out, held_out_scene.scene)?),
        model: SensorConfig::preset("ideal")?,
        nominal,
        // Some cases take the hidden effect out of the catalogue: then no name is right.
        left_out: case.leave_out.iter().map(|name| (*name).to_owned()).collect(),
        seed: SEED,
        is_quick: true,
    })?;
    let splits = prepared.data_splits()?;
    let result = splits.identify(&prepared.model.config, &prepared.left_out, &|_| {})?;
    let (mut effects, mut evidence, mut errors) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
    for evidenced in evidence_of_answer(&splits, &result)? {
        let name = &evidenced.finding.name;
        evidence.extend(evidenced.evidence.map(|evidence| (name.clone(), evidence)));
        errors.insert(name.clone(), evidenced.errors);
        effects.push(evidenced.finding);
    }
    let after = answer_score(&result);
    let tried = result.added_effects.iter().map(|added| {
        let tried = added.contenders.iter();
        tried.map(|c| (c.candidate.name.to_owned(), c.held_out.discrepancy)).collect()
    });
    Ok(Row {
        id: case.id.clone(),
        verdict: result.answer,
        effects,
        evidence,
        errors,
        gap_before: result.before.gap,
        gap_after: after.gap,
        grr: gap_closed(&result.before, after),
        tried: tried.collect(),
        events: splits.train.events.len(),
        make_s,
        name_s: begin.elapsed().as_secs_f64(),
        threads: rayon::current_num_threads(),
        commit: COMMIT.to_owned(),
    })
}
