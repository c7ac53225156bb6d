//! Cases with their labels: the only place where labels are opened, and only those of cases that
//! have a row.

use anyhow::{Context, Result};
use evpose_gap::verdict::{Answer, Finding, FindingKind, Quantity};
use gapbench_pixel::{Case, CaseKind, Label, Tier};
use rayon::prelude::*;

use super::part::PlanId;
use super::row::Row;
use super::truth::Truth;
use crate::terminal::bar;

#[derive(Debug)]
pub(super) struct Opened {
    pub(super) truth: Truth,
    pub(super) row: Row,
}

/// Opens the label of every row of a plan. `label` makes the label of a case.
pub(super) fn open(
    plan: PlanId,
    cases: &[Case],
    rows: Vec<Row>,
    label: &(dyn Fn(&Case) -> Label + Sync),
) -> Result<Vec<Opened>> {
    let progress = bar("opening", rows.len() as u64, "labels");
    let opened = rows
        .into_par_iter()
        // A label takes recordings with and without each effect: in parallel.
        .map(|row| {
            let case = cases.iter().find(|case| case.id == row.id);
            let case = case.with_context(|| format!("case {} is not of this plan", row.id))?;
            let label = label(case);
            progress.inc(1);
            Ok(Opened { truth: Truth::from_label(&label, plan), row })
        })
        .collect();
    progress.finish_and_clear();
    opened
}

impl Opened {
    pub(super) fn names(&self) -> Vec<&str> {
        self.row.named().map(|effect| effect.name.as_str()).collect()
    }

    pub(super) fn is_named(&self) -> bool {
        self.row.named().next().is_some()
    }

    pub(super) fn is_wrong(&self) -> bool {
        self.row.named().any(|effect| !self.truth.holds(&effect.name))
    }

    pub(super) fn is_wrong_leniently(&self) -> bool {
        self.row.named().any(|effect| !self.truth.holds_leniently(&effect.name))
    }

    pub(super) fn has_all(&self) -> bool {
        let names = self.names();
        self.truth.effects.iter().all(|truth| self.truth.is_named(truth, &names))
    }

    pub(super) fn has_all_leniently(&self) -> bool {
        let names = self.names();
        self.truth.effects.iter().all(|truth| self.truth.is_named_leniently(truth, &names))
    }

    /// All visible effects are named, and none that is not there.
    pub(super) fn is_exact(&self) -> bool {
        let names = self.names();
        let mut visible = self.truth.visible.iter();
        visible.all(|truth| self.truth.is_named(truth, &names)) && !self.is_wrong()
    }

    /// All hidden parameters of the model are called so, and no effect is named that is not there.
    fn has_parameters(&self) -> bool {
        let is_named = |name: &String| {
            let is_it = |f: &Finding| f.kind == FindingKind::Parameter && f.name == *name;
            self.row.effects.iter().any(is_it)
        };
        self.truth.parameters.iter().all(is_named) && !self.is_wrong()
    }

    fn is_home(&self) -> bool {
        self.truth.plan.tier == Tier::Home
    }

    /// All effects named and none beside them.
    pub(super) fn is_right(&self) -> bool {
        self.has_all() && !self.is_wrong()
    }

    pub(super) fn is_right_leniently(&self) -> bool {
        self.has_all_leniently() && !self.is_wrong_leniently()
    }

    pub(super) fn is_outside(&self) -> bool {
        self.truth.is_outside
    }

    /// Outside the catalogue: nothing is blamed, and if there is something to see it is said that
    /// it has no name, beside the names of conventions or without any.
    pub(super) fn is_unnamed(&self) -> bool {
        let is_explained = matches!(self.row.verdict, Answer::Parameter | Answer::Effects);
        if self.is_home() {
            let is_closed = is_explained || self.row.verdict == Answer::NoGap;
            return !(self.is_wrong() || is_closed && self.truth.is_visible);
        }
        let has_nothing = self.row.verdict == Answer::NoGap && !self.truth.is_visible;
        has_nothing || !(is_explained || self.row.verdict == Answer::NoGap || self.is_wrong())
    }

    pub(super) fn is_met(&self) -> bool {
        match self.truth.kind {
            CaseKind::Single | CaseKind::Pair | CaseKind::Several if self.is_home() => {
                self.is_exact()
            }
            CaseKind::Null if self.is_home() => !self.is_wrong(),
            CaseKind::Parameter if self.is_home() => self.has_parameters(),
            CaseKind::Single | CaseKind::Pair | CaseKind::Several => self.is_right(),
            CaseKind::Null => self.row.verdict == Answer::NoGap,
            CaseKind::Parameter => self.row.verdict == Answer::Parameter,
            CaseKind::LeftOut | CaseKind::NeverCatalogued => self.is_unnamed(),
        }
    }

    /// Its values count for the error of estimates: the truth was identified. Among several effects
    /// that is so for those that are named, as long as no other is.
    pub(super) fn counts_for_error(&self) -> bool {
        match self.truth.kind {
            CaseKind::Single | CaseKind::Pair | CaseKind::Several if self.is_home() => {
                self.is_named() && !self.is_wrong()
            }
            CaseKind::Single | CaseKind::Pair | CaseKind::Several => self.is_right(),
            CaseKind::Parameter => self.is_met(),
            CaseKind::Null | CaseKind::LeftOut | CaseKind::NeverCatalogued => false,
        }
    }

    /// Wrong identifications, and effects that are visible and were not identified.
    pub(super) fn is_miss(&self) -> bool {
        let is_hidden = !self.is_home()
            && matches!(self.truth.kind, CaseKind::Single | CaseKind::Pair)
            && !self.truth.is_visible;
        self.is_wrong() || !(self.is_met() || is_hidden)
    }

    pub(super) fn estimate(&self, finding: &str, key: &str) -> Option<&Quantity> {
        let found = self.row.effects.iter().find(|effect| effect.name == finding)?;
        found.parameters.get(key)
    }

    pub(super) fn hidden(&self) -> String {
        self.truth.hidden.join(" + ")
    }

    /// Its row of the confusion matrix.
    pub(super) fn title(&self) -> String {
        let unseen = if self.truth.is_visible { "" } else { ", too weak to see" };
        match self.truth.kind {
            CaseKind::Single => format!("{}{unseen}", self.hidden()),
            CaseKind::Null => "nothing".to_owned(),
            CaseKind::Parameter => format!("parameter{unseen}"),
            CaseKind::Pair => format!("pair{unseen}"),
            CaseKind::Several => "three to five".to_owned(),
            CaseKind::LeftOut => "left out of the catalogue".to_owned(),
            CaseKind::NeverCatalogued => "never catalogued".to_owned(),
        }
    }

    /// Its column of the confusion matrix. Names of conventions are left out of it.
    pub(super) fn answer_label(&self) -> String {
        let mut names = self.names();
        names.retain(|name| self.truth.hides(name) || !self.truth.holds(name));
        match self.truth.kind {
            CaseKind::Pair | CaseKind::Several if !names.is_empty() => {
                let there = names.iter().filter(|name| self.truth.holds(name)).count();
                format!("{there} right, {} wrong", names.len() - there)
            }
            _ if names.is_empty() && self.is_named() => "conventions alone".to_owned(),
            _ if !names.is_empty() => names.join(" + "),
            _ => self.row.verdict.key().to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::example;

    #[test]
    fn labels_are_opened_of_cases_that_have_a_row_and_of_no_others() -> Result<()> {
        let cases = example::PLAN.cases();
        let rows: Vec<Row> = example::opened().into_iter().take(5).map(|o| o.row).collect();
        let ids: Vec<String> = rows.iter().map(|row| row.id.clone()).collect();
        let asked = Mutex::new(Vec::new());
        let label = |case: &Case| {
            asked.lock().unwrap().push(case.id.clone());
            example::label(case)
        };
        let opened = open(example::PLAN, &cases, rows, &label)?;
        let mut asked = asked.into_inner().unwrap();
        asked.sort();
        assert_eq!((asked, opened.len()), (ids, 5));
        Ok(())
    }

    #[test]
    fn outside_the_catalogue_blaming_a_parameter_is_no_better_than_a_name() {
        let mut all = example::opened();
        let outside = all.iter_mut().find(|o| o.is_outside() && o.truth.is_visible).unwrap();
        for (answer, is_met) in [
            (Answer::NoneOfCatalogue, true),
            (Answer::Undecided, true),
            (Answer::Parameter, false),
            (Answer::NoGap, false),
        ] {
            outside.row.verdict = answer;
            outside.row.effects.clear();
            assert_eq!(outside.is_met(), is_met, "{answer:?}");
        }
    }
}
