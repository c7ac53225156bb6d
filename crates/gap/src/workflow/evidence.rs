//! The evidence of an answer, as data: `evidence.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::calibration::FindingEvidence;
use super::errors::RawError;
use super::findings::EvidencedFinding;
use crate::search::{AddedEffect, DataSplits, Identification};
use crate::verdict::Finding;

/// Basis of the probabilities and intervals of a verdict, before calibration, and the contenders of the
/// search. Empty where there is no scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AnswerEvidence {
    /// Evidence of each effect of the verdict, by its name.
    pub effects: BTreeMap<String, FindingEvidence>,
    /// Uncalibrated errors of all estimates, by finding and parameter.
    pub errors: BTreeMap<String, BTreeMap<String, RawError>>,
    /// Contenders for each added effect, named or not, with the discrepancy statistic that they leave on
    /// held-out data; the best first.
    pub contenders: Vec<Vec<(String, f64)>>,
    /// Count of events of the training data.
    pub events: usize,
}

impl AnswerEvidence {
    pub(super) fn new(
        splits: &DataSplits<'_>,
        result: &Identification,
        findings: &[EvidencedFinding],
    ) -> Self {
        let name = |one: &EvidencedFinding| one.finding.name.clone();
        let contenders = |added: &AddedEffect| {
            let all = added.contenders.iter();
            all.map(|c| (c.candidate.name.to_owned(), c.held_out.discrepancy)).collect()
        };
        Self {
            effects: findings.iter().filter_map(|one| Some((name(one), one.evidence?))).collect(),
            errors: findings.iter().map(|one| (name(one), one.errors.clone())).collect(),
            contenders: result.added_effects.iter().map(contenders).collect(),
            events: splits.train.events.len(),
        }
    }

    /// Drops the evidence of all but these findings: nuisance parameters take effects out of a verdict.
    pub fn restrict(&mut self, findings: &[Finding]) {
        let is_there = |name: &String| findings.iter().any(|finding| finding.name == *name);
        self.effects.retain(|name, _| is_there(name));
        self.errors.retain(|name, _| is_there(name));
    }
}
