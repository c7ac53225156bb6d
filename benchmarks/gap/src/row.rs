//! Identification of one case, as a line of results.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fmt;
use std::path::Path;

use anyhow::Result;
use evpose_gap::run_files;
use evpose_gap::verdict::{Answer, Finding, FindingKind, Verdict};
use evpose_gap::workflow::{AnswerEvidence, FindingEvidence, RawError};
use gapbench_pixel::Case;
use serde::{Deserialize, Serialize};

use super::case_files::part;
use crate::program::Program;

/// Seed of the noise of simulations, the same for all cases.
const SEED: &str = "1";

fn one() -> usize {
    1
}

/// One case: nothing in it comes from the label.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) id: String,
    pub(super) verdict: Answer,
    pub(super) effects: Vec<Finding>,
    /// Gap of the model as given, on the second recording, and of the corrected one.
    pub(super) gap_before: f64,
    pub(super) gap_after: f64,
    /// The share of it that is gone.
    pub(super) grr: f64,
    #[serde(default)]
    pub(super) evidence: BTreeMap<String, FindingEvidence>,
    /// Uncertainty of the estimates of findings, before calibration.
    #[serde(default)]
    pub(super) errors: BTreeMap<String, BTreeMap<String, RawError>>,
    /// The best few of each step, named or not, with the discrepancy that they leave.
    pub(super) tried: Vec<Vec<(String, f64)>>,
    /// Events of the first recording.
    pub(super) events: usize,
    #[serde(default = "one")]
    pub(super) threads: usize,
    pub(super) make_s: f64,
    /// Seconds to name from them: those of the whole run of the program with its report, in rows of commits
    /// before `gapbench` of the search alone.
    pub(super) name_s: f64,
    pub(super) commit: String,
}

impl Row {
    pub(super) fn seconds(&self) -> f64 {
        self.make_s + self.name_s
    }

    /// Seconds on a machine with two cores: one thread leaves the other core to another part
    /// of the plan.
    pub(super) fn seconds_on_two_cores(&self) -> f64 {
        self.seconds() * self.threads as f64 / 2.0
    }

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
            self.verdict.key(),
            self.gap_before,
            self.gap_after,
            self.seconds(),
            names.join(" + ")
        )
    }
}

/// Names what is missing from the files of a case, by a run of the program that leaves its own files in
/// `report`.
pub(super) fn name(
    program: &Program,
    folder: &Path,
    case: &Case,
    report: &Path,
    make_s: f64,
) -> Result<Row> {
    let ((train, scene), (held_out, held_out_scene)) = (part(folder, 0), part(folder, 1));
    let mut arguments: Vec<&OsStr> = ["--quick", "--seed", SEED].map(OsStr::new).into();
    for (name, path) in [
        ("--measured", &train),
        ("--scene", &scene),
        ("--validate", &held_out),
        ("--validate-scene", &held_out_scene),
    ] {
        arguments.extend([OsStr::new(name), path.as_os_str()]);
    }
    // Some cases take the hidden effect out of the catalogue: then no name is right.
    if let Some(name) = case.leave_out {
        arguments.extend(["--leave-out", name].map(OsStr::new));
    }
    let ended = program.gap_run(&arguments, report)?;
    let verdict: Verdict = ended.read(run_files::VERDICT)?;
    let evidence: AnswerEvidence = ended.read(run_files::EVIDENCE)?;
    Ok(Row {
        id: case.id.clone(),
        verdict: verdict.verdict,
        effects: verdict.effects,
        gap_before: verdict.gap_before.value,
        gap_after: verdict.gap_after.value,
        grr: verdict.grr,
        evidence: evidence.effects,
        errors: evidence.errors,
        tried: evidence.contenders,
        events: evidence.events,
        threads: program.threads(),
        make_s,
        name_s: ended.seconds,
        commit: program.commit.clone(),
    })
}
