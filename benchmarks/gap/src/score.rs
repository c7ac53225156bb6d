//! Detection rates, false identifications, and errors of estimates.

use std::collections::BTreeMap;

use evpose_gap::verdict::{Answer, Finding, Quantity};
use gapbench_pixel::{CaseKind, EFFECTS, STRENGTHS, Tier};
use serde::Serialize;

use super::group::{Group, groups};
use super::opened::Opened;
use super::own::OwnSummary;
use super::stats::{Bin, Median, Rate, Stated, bins, calibration_error, median};
use super::targets::{Headline, headlines};

/// The score of a part of the plan. Figures are strict: see [`Lenient`].
#[derive(Debug, Clone, Serialize)]
pub(super) struct Scores {
    pub(super) plans: Vec<u64>,
    pub(super) tier: Tier,
    pub(super) cases: usize,
    pub(super) commits: Vec<String>,
    /// Stored folders that they are in; none of one that is scored by itself.
    pub(super) folders: Vec<String>,
    pub(super) headlines: Vec<Headline>,
    /// Recall and precision of all cases, and by the count of hidden effects.
    pub(super) all: Group,
    pub(super) groups: Vec<Group>,
    /// Cases with something visible of the catalogue in which exactly that is named.
    pub(super) exact_sets: Rate,
    /// Visible singles with their effect named, and nothing that is not there.
    pub(super) singles_right: Rate,
    pub(super) wrong_names: Rate,
    /// Nulls in which an effect is named, and in which anything is said.
    pub(super) nulls_named: Rate,
    pub(super) nulls_not_closed: Rate,
    /// Cases of parameters alone that are called so.
    pub(super) parameters_right: Rate,
    /// Pairs, both visible, with both named.
    pub(super) pairs_both: Rate,
    /// Cases outside the catalogue in which nothing is blamed.
    pub(super) outside_unnamed: Rate,
    /// The same figures by a less strict rule.
    pub(super) lenient: Lenient,
    /// Of right names: relative errors of their estimates, and whether intervals hold the truth.
    pub(super) parameter_error: Option<Median>,
    pub(super) intervals_hold: Rate,
    /// Of right names: the share of the gap that is gone.
    pub(super) grr: Option<Median>,
    /// Stated probabilities of all names, and of the first name of each case, and how far shares are
    /// from the latter.
    pub(super) stated: Stated,
    pub(super) reliability: Vec<Bin>,
    pub(super) calibration_error: Option<f64>,
    /// Recordings of our own model.
    pub(super) own: Option<OwnSummary>,
    /// Seconds of a case on two cores, to make it and to name it.
    pub(super) seconds_mean: f64,
    pub(super) seconds_median: Option<f64>,
    pub(super) seconds_most: f64,
    pub(super) by_strength: BTreeMap<usize, Rate>,
    /// Singles by effect and strength, seen or not.
    pub(super) power: Vec<Power>,
    /// Coverage of intervals, by finding.
    pub(super) coverage: BTreeMap<String, Rate>,
    /// Confusion matrix: answers by hidden effects.
    pub(super) confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Estimates of right names beside their true values.
    pub(super) estimates: Vec<Estimate>,
    /// Wrong cases, a line each.
    pub(super) misses: Vec<String>,
    /// Remarks on single cases.
    pub(super) notes: Vec<String>,
}

/// The same shares where a source follower passes for any low-pass, and where outside the catalogue
/// it is enough that no effect is named.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Lenient {
    pub(super) singles_right: Rate,
    pub(super) wrong_names: Rate,
    pub(super) pairs_both: Rate,
    pub(super) outside_unnamed: Rate,
}

/// How often an effect of one strength is named.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Power {
    pub(super) effect: &'static str,
    pub(super) strength: usize,
    pub(super) visible: usize,
    pub(super) right: Rate,
}

/// One number of a right name.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Estimate {
    pub(super) id: String,
    pub(super) finding: String,
    pub(super) parameter: String,
    pub(super) truth: f64,
    pub(super) estimate: Quantity,
}

impl Estimate {
    /// Relative error; none where the truth is zero.
    pub(super) fn error(&self) -> Option<f64> {
        (self.truth != 0.0).then(|| (self.estimate.value / self.truth - 1.0).abs())
    }

    pub(super) fn is_covered(&self) -> bool {
        (self.estimate.lo90..=self.estimate.hi90).contains(&self.truth)
    }
}

pub(super) fn score_cases(
    opened: &[Opened],
    own: Option<OwnSummary>,
    folders: Vec<String>,
) -> Scores {
    let tier = opened.first().map_or_else(Tier::default, |case| case.truth.plan.tier);
    let of_kind = |kind| opened.iter().filter(move |case| case.truth.kind == kind);
    let singles = || of_kind(CaseKind::Single).filter(|case| case.truth.is_visible);
    let pairs = || of_kind(CaseKind::Pair).filter(|case| case.truth.is_visible);
    let outside = || opened.iter().filter(|case| case.is_outside());
    let nulls = || of_kind(CaseKind::Null);
    let estimates = estimates(opened);
    let first = |case: &Opened| {
        let effect = case.row.named().next()?;
        Some((effect.probability?, case.truth.holds(&effect.name)))
    };
    let names = opened.iter().flat_map(|case| {
        let stated = |effect: &Finding| Some((effect.probability?, case.truth.holds(&effect.name)));
        case.row.named().filter_map(stated).collect::<Vec<_>>()
    });
    let reliability = bins(&opened.iter().filter_map(first).collect::<Vec<_>>());
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for case in opened {
        *confusion.entry(case.title()).or_default().entry(case.answer_label()).or_default() += 1;
    }
    let mut commits: Vec<String> = opened.iter().map(|case| case.row.commit.clone()).collect();
    commits.sort();
    commits.dedup();
    let mut plans: Vec<u64> = opened.iter().map(|case| case.truth.plan.seed).collect();
    plans.sort_unstable();
    plans.dedup();
    let mut coverage: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for estimate in &estimates {
        coverage.entry(estimate.finding.clone()).or_default().push(estimate.is_covered());
    }
    let seconds = || opened.iter().map(|case| case.row.seconds_on_two_cores());
    let of_strength = |strength| {
        Rate::from_outcomes(
            singles().filter(|c| c.truth.strength == Some(strength)).map(Opened::is_right),
        )
    };
    let misses = opened.iter().filter(|case| case.is_miss());
    let miss = |case: &Opened| {
        format!("{} {} ({}): {}", case.row.id, case.title(), case.hidden(), case.answer_label())
    };
    let note = |case: &Opened| case.truth.note.as_ref().map(|n| format!("{} {n}", case.row.id));
    let mut scores = Scores {
        plans,
        tier,
        cases: opened.len(),
        commits,
        folders,
        headlines: Vec::new(),
        all: Group::new("all", &opened.iter().collect::<Vec<_>>()),
        groups: groups(opened),
        exact_sets: Rate::from_outcomes(
            opened
                .iter()
                .filter(|case| !case.is_outside() && !case.truth.visible.is_empty())
                .map(Opened::is_exact),
        ),
        singles_right: Rate::from_outcomes(singles().map(Opened::is_right)),
        wrong_names: Rate::from_outcomes(opened.iter().map(Opened::is_wrong)),
        // A name of a convention is right in a null, any other one is not.
        nulls_named: Rate::from_outcomes(nulls().map(Opened::is_wrong)),
        nulls_not_closed: Rate::from_outcomes(
            nulls().map(|case| case.row.verdict != Answer::NoGap),
        ),
        parameters_right: Rate::from_outcomes(of_kind(CaseKind::Parameter).map(Opened::is_met)),
        pairs_both: Rate::from_outcomes(pairs().map(Opened::has_all)),
        outside_unnamed: Rate::from_outcomes(outside().map(Opened::is_unnamed)),
        lenient: Lenient {
            singles_right: Rate::from_outcomes(singles().map(Opened::is_right_leniently)),
            wrong_names: Rate::from_outcomes(opened.iter().map(Opened::is_wrong_leniently)),
            pairs_both: Rate::from_outcomes(pairs().map(Opened::has_all_leniently)),
            outside_unnamed: Rate::from_outcomes(outside().map(|case| !case.is_wrong())),
        },
        parameter_error: median(estimates.iter().filter_map(Estimate::error)),
        intervals_hold: Rate::from_outcomes(estimates.iter().map(Estimate::is_covered)),
        grr: median(opened.iter().filter(|case| case.counts_for_error()).map(|case| case.row.grr)),
        stated: Stated::of(&names.collect::<Vec<_>>()),
        calibration_error: calibration_error(&reliability),
        reliability,
        own,
        seconds_mean: seconds().sum::<f64>() / opened.len().max(1) as f64,
        seconds_median: median(seconds()).map(|median| median.value),
        seconds_most: seconds().fold(0.0, f64::max),
        by_strength: (0..STRENGTHS).map(|strength| (strength, of_strength(strength))).collect(),
        power: power(opened),
        coverage: coverage
            .into_iter()
            .map(|(name, held)| (name, Rate::from_outcomes(held)))
            .collect(),
        confusion,
        estimates,
        misses: misses.map(miss).collect(),
        notes: opened.iter().filter_map(note).collect(),
    };
    scores.headlines = headlines(&scores);
    scores
}

fn estimates(opened: &[Opened]) -> Vec<Estimate> {
    let of = |case: &Opened| -> Vec<Estimate> {
        let estimate = |(finding, parameter, truth): &(String, String, f64)| {
            let estimate = case.estimate(finding, parameter)?.clone();
            let (id, truth) = (case.row.id.clone(), *truth);
            let (finding, parameter) = (finding.clone(), parameter.clone());
            Some(Estimate { id, finding, parameter, truth, estimate })
        };
        case.truth.values.iter().filter_map(estimate).collect()
    };
    opened.iter().filter(|case| case.counts_for_error()).flat_map(of).collect()
}

fn power(opened: &[Opened]) -> Vec<Power> {
    let of = |effect: &'static str, strength: usize| {
        let is_it = |case: &&Opened| {
            case.truth.kind == CaseKind::Single
                && case.truth.strength == Some(strength)
                && case.truth.effects == [effect]
        };
        let cases = || opened.iter().filter(is_it);
        Power {
            effect,
            strength,
            visible: cases().filter(|case| case.truth.is_visible).count(),
            right: Rate::from_outcomes(cases().map(Opened::is_right)),
        }
    };
    EFFECTS
        .iter()
        .flat_map(|effect| (0..STRENGTHS).map(move |strength| (effect.name(), strength)))
        .map(|(effect, strength)| of(effect, strength))
        // Strengths that no case has would be points of nothing.
        .filter(|power| power.right.n > 0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use crate::targets::Reached;

    #[test]
    fn a_namer_that_knows_everything_meets_every_target() {
        let scores = score_cases(&example::opened(), None, Vec::new());
        for rate in [scores.singles_right, scores.parameters_right, scores.pairs_both] {
            assert_eq!((rate.of, rate.share), (rate.n, Some(1.0)));
        }
        assert_eq!((scores.wrong_names.of, scores.nulls_named.of), (0, 0));
        assert_eq!((scores.cases, scores.misses.len()), (576, 0));
        assert!(scores.parameter_error.is_some_and(|median| median.value < 0.05));
        assert_eq!(scores.power.len(), 18 * 4);
    }

    #[test]
    fn a_namer_that_knows_everything_meets_every_target_of_the_plan_with_conventions() {
        let scores = score_cases(&example::opened_home(), None, Vec::new());
        assert_eq!((scores.cases, scores.misses.len()), (456, 0));
        // Its intervals all hold the truth, which is more than nine of ten.
        let is_of_intervals = |headline: &Headline| headline.name.contains("90 % interval");
        let missed = |headline: &&Headline| {
            headline.reached() == Reached::Missed && !is_of_intervals(headline)
        };
        assert_eq!(scores.headlines.iter().filter(missed).count(), 0);
        let reached = |name: &str| {
            let headline = scores.headlines.iter().find(|headline| headline.name == name);
            headline.map(Headline::reached)
        };
        assert_eq!(reached("three to five: visible effects named"), Some(Reached::Goal));
        assert_eq!(reached("nulls with an effect named"), Some(Reached::Goal));
    }

    #[test]
    fn nulls_in_which_only_conventions_are_named_are_right() {
        let mut opened = example::opened_home();
        example::name_conventions(&mut opened);
        let scores = score_cases(&opened, None, Vec::new());
        assert_eq!((scores.nulls_named.of, scores.nulls_named.n), (0, 100));
        assert_eq!((scores.wrong_names.of, scores.misses.len()), (0, 0));
        let null = opened.iter_mut().find(|case| case.truth.kind == CaseKind::Null).unwrap();
        null.row.effects[0].name = "no such effect".to_owned();
        let scores = score_cases(&opened, None, Vec::new());
        assert_eq!((scores.nulls_named.of, scores.misses.len()), (1, 1));
    }

    #[test]
    fn a_source_follower_for_a_lowpass_is_wrong_and_counted_leniently_beside() {
        let mut opened = example::opened();
        for case in opened.iter_mut().filter(|case| case.truth.effects == ["photoreceptor_lowpass"])
        {
            for effect in &mut case.row.effects {
                effect.name = "source_follower".to_owned();
            }
        }
        let scores = score_cases(&opened, None, Vec::new());
        assert!(scores.wrong_names.of > 0 && scores.lenient.wrong_names.of == 0);
        assert!(scores.singles_right.of < scores.singles_right.n);
        assert_eq!(scores.lenient.singles_right.of, scores.lenient.singles_right.n);
        assert_eq!(scores.misses.len(), scores.wrong_names.of);
        assert!(!scores.notes.is_empty());
    }

    #[test]
    fn a_number_outside_its_interval_is_not_held() {
        let quantity =
            Quantity { value: 1.1, lo90: 1.05, hi90: 1.2, unit: String::new(), halves: None };
        let mut estimate = Estimate {
            id: String::new(),
            finding: "a".to_owned(),
            parameter: "b".to_owned(),
            truth: 1.0,
            estimate: quantity,
        };
        assert!(
            !estimate.is_covered() && estimate.error().is_some_and(|e| (e - 0.1).abs() < 1e-12)
        );
        estimate.estimate.lo90 = 1.0;
        assert!(estimate.is_covered());
        estimate.truth = 0.0;
        assert_eq!(estimate.error(), None);
    }
}
