//! Cases with their truth: the only place where `truth.json` is read, and only of cases that have
//! a line of results.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use evpose_gap::input::Description;
use evpose_gap::verdict::FindingKind;
use serde::{Deserialize, Serialize};

use super::names::{self, CONVENTIONS};
use super::row::{FAILED, NamedFinding, Row};
use super::truth::{HiddenEffect, Truth};
use crate::jsonl;
use crate::naming::RESULTS;

/// A line a case, with its truth.
pub(super) const TRUTHS: &str = "truths.jsonl";

/// The part of a truth that scores take, beside the row of a case: a line of `truths.jsonl`.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct StoredTruth {
    id: String,
    #[serde(flatten)]
    truth: Truth,
    nominal_spread: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Opened {
    pub(crate) row: Row,
    pub(super) truth: Truth,
    /// Spread of thresholds that `scene.json` states; zero if it states none.
    pub(super) nominal_spread: f64,
}

impl Opened {
    /// Opens the truth of a case in the folder `truths`, and the nominal values in `cases`.
    pub(super) fn read(row: Row, cases: &Path, truths: &Path) -> Result<Self> {
        let scene = Description::read(&cases.join(&row.id).join("scene.json"))?;
        let path: PathBuf = truths.join(&row.id).join("truth.json");
        let truth = Truth::read(&path)?;
        // An effect without an entry in the answer key would pass for one outside the catalogue.
        for effect in &truth.effects {
            ensure!(
                names::entry(&effect.name).is_some(),
                "{}: no names are known for `{}`",
                path.display(),
                effect.name
            );
        }
        let nominal_spread = scene.nominal.and_then(|nominal| nominal.threshold_sigma);
        // The spread of thresholds that the description states is known, not to be found.
        Ok(Self { row, truth, nominal_spread: nominal_spread.unwrap_or(0.0) })
    }

    pub(super) fn stored(&self) -> StoredTruth {
        let Self { row, truth, nominal_spread } = self;
        StoredTruth { id: row.id.clone(), truth: truth.clone(), nominal_spread: *nominal_spread }
    }

    /// Effects of the verdict, without parameters.
    pub(super) fn named(&self) -> impl Iterator<Item = &NamedFinding> {
        self.row.effects.iter().filter(|finding| finding.kind == FindingKind::Effect)
    }

    pub(super) fn parameters(&self) -> impl Iterator<Item = &NamedFinding> {
        self.row.effects.iter().filter(|finding| finding.kind == FindingKind::Parameter)
    }

    /// Whether a finding is the name of something hidden, visible or not.
    pub(super) fn is_hidden(&self, finding: &NamedFinding) -> bool {
        self.truth.effects.iter().any(|effect| right_names(effect).contains(&finding.name.as_str()))
    }

    pub(super) fn is_convention(&self, finding: &NamedFinding) -> bool {
        let holds = |c: &names::Convention| c.holds(&self.truth, finding, self.nominal_spread);
        CONVENTIONS.iter().any(holds)
    }

    pub(super) fn is_right(&self, finding: &NamedFinding) -> bool {
        self.is_hidden(finding) || self.is_convention(finding)
    }

    pub(super) fn has_wrong_name(&self) -> bool {
        self.named().any(|finding| !self.is_right(finding))
    }

    pub(super) fn has(&self, effect: &HiddenEffect) -> bool {
        let right = right_names(effect);
        self.row.effects.iter().any(|finding| right.contains(&finding.name.as_str()))
    }

    /// Hidden effects of the catalogue that are visible.
    pub(super) fn visible(&self) -> impl Iterator<Item = &HiddenEffect> {
        let effects = self.truth.effects.iter();
        effects.filter(|effect| effect.is_visible && !right_names(effect).is_empty())
    }

    pub(super) fn is_outside_catalogue(&self) -> bool {
        self.truth.effects.iter().any(|effect| right_names(effect).is_empty())
    }

    /// Whether exactly the visible effects are named: all of them, and nothing that is not there.
    /// Conventions are neither missing nor in excess.
    pub(super) fn is_exact(&self) -> bool {
        self.row.verdict != FAILED
            && !self.has_wrong_name()
            && self.visible().all(|effect| self.has(effect))
    }

    /// Stated probabilities of the names, and whether each is right; `is_strict` counts only names
    /// that are no convention.
    pub(crate) fn stated(&self, is_strict: bool) -> Vec<(f64, bool)> {
        let is_counted =
            |f: &&NamedFinding| !is_strict || self.is_hidden(f) || !self.is_convention(f);
        let stated = |finding: &NamedFinding| Some((finding.probability?, self.is_right(finding)));
        self.named().filter(is_counted).filter_map(stated).collect()
    }

    /// Whether an effect is named that is no convention.
    pub(super) fn is_named(&self) -> bool {
        self.named().any(|finding| !self.is_convention(finding))
    }

    /// Whether the verdict says that something is left that it has no name for.
    pub(super) fn is_open(&self) -> bool {
        ["none_of_catalogue", "partial", "undecided"].contains(&self.row.verdict.as_str())
    }

    /// Hidden effects with their strengths, or `nothing`.
    pub(super) fn title(&self) -> String {
        let effect = |effect: &HiddenEffect| {
            let unseen = if effect.is_visible { "" } else { ", not visible" };
            format!("{} ({}{unseen})", effect.name, effect.strength)
        };
        match self.truth.effects.as_slice() {
            [] => "nothing".to_owned(),
            effects => effects.iter().map(effect).collect::<Vec<_>>().join(" + "),
        }
    }
}

/// Right names of a hidden effect; none of one outside the catalogue.
fn right_names(effect: &HiddenEffect) -> &'static [&'static str] {
    names::entry(&effect.name).map_or(&[], |entry| entry.right)
}

/// Cases of a stored folder: every row with its stored truth.
pub(super) fn read(dir: &Path) -> Result<Vec<Opened>> {
    let stored: Vec<StoredTruth> = jsonl::read(&dir.join(TRUTHS))?;
    let mut truths: HashMap<String, StoredTruth> =
        stored.into_iter().map(|stored| (stored.id.clone(), stored)).collect();
    let open = |row: Row| {
        let stored = truths.remove(&row.id);
        let stored =
            stored.with_context(|| format!("{}: no line of case {}", dir.display(), row.id))?;
        let StoredTruth { truth, nominal_spread, .. } = stored;
        Ok(Opened { row, truth, nominal_spread })
    };
    jsonl::read::<Row>(&dir.join(RESULTS))?.into_iter().map(open).collect()
}

pub(super) fn open(rows: Vec<Row>, cases: &Path, truths: &Path) -> Result<Vec<Opened>> {
    rows.into_iter()
        .map(|row| {
            let id = row.id.clone();
            Opened::read(row, cases, truths).with_context(|| format!("case {id}"))
        })
        .collect()
}
