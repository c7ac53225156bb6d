//! How much was found, how often a name was wrong, and how well numbers were met.

use std::collections::BTreeMap;

use evpose_gap::verdict::{Answer, FindingKind, Quantity};
use gapbench_pixel::{Case, CaseKind, Label};
use rayon::prelude::*;
use serde::Serialize;

use super::row::Row;
use super::truth::Truth;
use crate::commands::gap::steps::word;

/// How many of how many, with the Wilson interval of 95 %.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(super) struct Rate {
    pub(super) of: usize,
    pub(super) n: usize,
    pub(super) share: Option<f64>,
    pub(super) lo95: f64,
    pub(super) hi95: f64,
}

impl Rate {
    fn of(is: impl IntoIterator<Item = bool>) -> Self {
        let (mut of, mut n) = (0, 0);
        for is in is {
            of += usize::from(is);
            n += 1;
        }
        let (lo95, hi95) = wilson(of, n);
        Self { of, n, share: (n > 0).then(|| of as f64 / n as f64), lo95, hi95 }
    }
}

/// The interval of a share: Wilson, J. Am. Stat. Assoc. 22, 1927.
fn wilson(of: usize, n: usize) -> (f64, f64) {
    if n == 0 {
        return (0.0, 1.0);
    }
    const Z: f64 = 1.959_964;
    let (p, n) = (of as f64 / n as f64, n as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let whole = 1.0 + Z * Z / n;
    (((middle - half) / whole).max(0.0), ((middle + half) / whole).min(1.0))
}

/// The score of a part of the plan.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Scores {
    pub(super) cases: usize,
    /// Programs that results are of.
    pub(super) commits: Vec<String>,
    /// Visible singles with their effect named, and nothing that is not there.
    pub(super) singles_right: Rate,
    /// Cases with a name that is not there.
    pub(super) wrong_names: Rate,
    /// Nulls in which an effect is named, and in which anything is said.
    pub(super) nulls_named: Rate,
    pub(super) nulls_not_closed: Rate,
    /// Cases of parameters alone that are called so.
    pub(super) parameters_right: Rate,
    /// Pairs, both visible, with both named.
    pub(super) pairs_both: Rate,
    /// Cases outside the catalogue in which nothing is named.
    pub(super) outside_unnamed: Rate,
    /// Of right names: relative errors of their numbers, and whether intervals hold the truth.
    pub(super) parameter_error_median: Option<f64>,
    pub(super) intervals_hold: Rate,
    /// Of right names: the share of the gap that is gone.
    pub(super) grr_median: Option<f64>,
    /// Seconds of a case, to make it and to name it.
    pub(super) seconds_median: Option<f64>,
    pub(super) seconds_most: f64,
    /// Visible singles by strength.
    pub(super) by_strength: BTreeMap<usize, Rate>,
    /// What was said of what.
    pub(super) confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Numbers of right names: what they are and what was said.
    pub(super) numbers: Vec<Number>,
    /// What went wrong, a line each.
    pub(super) misses: Vec<String>,
}

/// One number of a right name.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Number {
    pub(super) id: String,
    pub(super) finding: &'static str,
    pub(super) parameter: &'static str,
    pub(super) truth: f64,
    pub(super) said: Quantity,
}

/// One case, opened.
struct Opened<'a> {
    label: Label,
    truth: Truth,
    row: &'a Row,
    names: Vec<&'a str>,
}

impl Opened<'_> {
    fn is_wrong(&self) -> bool {
        self.names.iter().any(|name| !self.truth.holds(name))
    }

    fn is_named(&self) -> bool {
        !self.names.is_empty()
    }

    fn is_outside(&self) -> bool {
        self.label.outside_catalogue
    }

    /// All effects named and none beside them.
    fn is_right(&self) -> bool {
        let all = self.truth.effects.iter().all(|truth| Truth::is_named(truth, &self.names));
        all && !self.is_wrong()
    }

    fn finding(&self, finding: &str, key: &str) -> Option<&Quantity> {
        let found = self.row.effects.iter().find(|effect| effect.name == finding)?;
        found.parameters.get(key)
    }
}

/// Opens the labels and scores the rows.
pub(super) fn of(cases: &[Case], rows: &[&Row]) -> Scores {
    let opened: Vec<Opened<'_>> = rows
        .par_iter()
        .filter_map(|row| {
            let label = cases.iter().find(|case| case.id == row.id)?.label();
            let effects = row.effects.iter().filter(|effect| effect.kind == FindingKind::Effect);
            let names = effects.map(|effect| effect.name.as_str()).collect();
            Some(Opened { truth: Truth::of(&label), label, row, names })
        })
        .collect();
    let of_kind = |kind| opened.iter().filter(move |case| case.label.kind == kind);
    let singles = || of_kind(CaseKind::Single).filter(|case| case.label.visible);
    let pairs = of_kind(CaseKind::Pair).filter(|case| case.label.visible);
    let both = |case: &Opened<'_>| {
        case.truth.effects.iter().all(|truth| Truth::is_named(truth, &case.names))
    };
    let named_right = || {
        let is_told = |case: &&Opened<'_>| match case.label.kind {
            CaseKind::Single | CaseKind::Pair => case.is_right(),
            CaseKind::Parameter => case.is_right() && case.row.verdict == Answer::Parameter,
            CaseKind::Null | CaseKind::LeftOut | CaseKind::NeverCatalogued => false,
        };
        opened.iter().filter(is_told)
    };
    let number =
        |case: &Opened<'_>, (finding, parameter, truth): &(&'static str, &'static str, f64)| {
            let said = case.finding(finding, parameter)?.clone();
            Some(Number { id: case.row.id.clone(), finding, parameter, truth: *truth, said })
        };
    let numbers: Vec<Number> = named_right()
        .flat_map(|case| case.truth.numbers.iter().filter_map(move |truth| number(case, truth)))
        .collect();
    let errors = numbers.iter().map(|n| (n.said.value / n.truth - 1.0).abs()).collect();
    let held = numbers.iter().map(|n| (n.said.lo90..=n.said.hi90).contains(&n.truth));
    let mut by_strength = BTreeMap::new();
    for strength in 0..4 {
        let of = singles().filter(|case| case.label.strength == Some(strength));
        by_strength.insert(strength, Rate::of(of.map(Opened::is_right)));
    }
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for case in &opened {
        *confusion.entry(title(case)).or_default().entry(said(case)).or_default() += 1;
    }
    let misses = opened
        .iter()
        .filter(|case| is_miss(case))
        .map(|case| format!("{} {} ({}): {}", case.row.id, title(case), effects(case), said(case)));
    let mut commits: Vec<String> = rows.iter().map(|row| row.commit.clone()).collect();
    commits.sort();
    commits.dedup();
    let seconds: Vec<f64> = rows.iter().map(|row| row.seconds()).collect();
    let outside = opened.iter().filter(|case| case.is_outside());
    Scores {
        cases: opened.len(),
        commits,
        singles_right: Rate::of(singles().map(Opened::is_right)),
        wrong_names: Rate::of(opened.iter().map(Opened::is_wrong)),
        nulls_named: Rate::of(of_kind(CaseKind::Null).map(Opened::is_named)),
        nulls_not_closed: Rate::of(
            of_kind(CaseKind::Null).map(|case| case.row.verdict != Answer::NoGap),
        ),
        parameters_right: Rate::of(
            of_kind(CaseKind::Parameter).map(|case| case.row.verdict == Answer::Parameter),
        ),
        pairs_both: Rate::of(pairs.map(both)),
        outside_unnamed: Rate::of(outside.map(|case| !case.is_wrong())),
        parameter_error_median: median(errors),
        intervals_hold: Rate::of(held),
        numbers: numbers.clone(),
        grr_median: median(named_right().map(|case| case.row.grr).collect()),
        seconds_most: seconds.iter().copied().fold(0.0, f64::max),
        seconds_median: median(seconds),
        by_strength,
        confusion,
        misses: misses.collect(),
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

fn is_miss(case: &Opened<'_>) -> bool {
    let is_missed = match case.label.kind {
        CaseKind::Single | CaseKind::Pair => case.label.visible && !case.is_right(),
        CaseKind::Null => case.row.verdict != Answer::NoGap,
        CaseKind::Parameter => case.row.verdict != Answer::Parameter,
        CaseKind::LeftOut | CaseKind::NeverCatalogued => case.is_wrong(),
    };
    is_missed || case.is_wrong()
}

/// What a case is, in rows of the confusion matrix.
fn title(case: &Opened<'_>) -> String {
    let what = effects(case);
    let unseen = if case.label.visible { "" } else { ", too weak to see" };
    match case.label.kind {
        CaseKind::Single => format!("{what}{unseen}"),
        CaseKind::Null => "nothing".to_owned(),
        CaseKind::Parameter => format!("parameter{unseen}"),
        CaseKind::Pair => format!("pair{unseen}"),
        CaseKind::LeftOut => "left out of the catalogue".to_owned(),
        CaseKind::NeverCatalogued => "never catalogued".to_owned(),
    }
}

fn effects(case: &Opened<'_>) -> String {
    let names = case.label.truth.iter().map(|truth| truth.term.name);
    names.collect::<Vec<_>>().join(" + ")
}

/// What was said, in columns of the confusion matrix.
fn said(case: &Opened<'_>) -> String {
    match case.label.kind {
        CaseKind::Pair if case.is_named() => {
            let there = case.names.iter().filter(|name| case.truth.holds(name)).count();
            format!("{there} right, {} wrong", case.names.len() - there)
        }
        _ if case.is_named() => case.names.join(" + "),
        _ => word(case.row.verdict).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_shares_are_those_of_wilson() {
        // 8 of 10: 0.490 to 0.943, as in every table.
        let (lo, hi) = wilson(8, 10);
        assert!((lo - 0.4902).abs() < 1e-4 && (hi - 0.9433).abs() < 1e-4);
        let none = Rate::of([false; 5]);
        assert!(none.lo95 == 0.0 && (none.hi95 - 0.4345).abs() < 1e-4);
        assert_eq!(Rate::of([]).share, None);
    }
}
