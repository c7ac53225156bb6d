//! Precision and recall of names, exact sets and times: of all cases, by generator, and by the
//! number of hidden effects.

use evpose_core::stats::quantile;
use evpose_gap::search::excess_closed;
use serde::Serialize;

use super::opened::Opened;
use super::truth::Generator;
use crate::stats::{Rate, Stated, bins, calibration_error, median};
use crate::targets::Target::{AtLeast, AtMost, Within};
use crate::targets::{Headline, Unit, gap_closed, probabilities};
use evpose_report::format::short;

#[derive(Debug, Clone, Serialize)]
pub(crate) struct OutsideScores {
    pub(super) cases: usize,
    pub(super) commits: Vec<String>,
    /// Stored folders that they are in; none of one that is scored by itself.
    pub(super) folders: Vec<String>,
    /// Figures beside the required ones.
    pub(super) headlines: Vec<Headline>,
    /// Stated probabilities of all names, conventions among them, and of those that are none.
    pub(crate) stated: Stated,
    pub(crate) stated_strict: Stated,
    /// All cases first.
    pub(crate) groups: Vec<Group>,
    /// Recall by strength.
    pub(super) strengths: Vec<(String, Rate)>,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct Group {
    pub(super) title: String,
    pub(super) cases: usize,
    /// Visible effects of the catalogue that are named.
    pub(crate) recall: Rate,
    /// Names that are right: something hidden, or a convention of the generator.
    pub(crate) precision: Rate,
    /// The same of names that are no convention.
    pub(crate) strict_precision: Rate,
    /// Cases with something visible of the catalogue in which exactly that is named.
    pub(super) exact_sets: Rate,
    pub(super) wrong_names: Rate,
    /// Cases with nothing hidden in which an effect is named that is no convention.
    pub(crate) nulls_named: Rate,
    /// Cases with something outside the catalogue whose verdict leaves something open.
    pub(crate) outside_open: Rate,
    pub(super) parameters: Rate,
    /// Seconds from start to report.
    pub(super) seconds: Option<Seconds>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Seconds {
    pub(super) median: f64,
    pub(super) p90: f64,
    pub(super) max: f64,
}

fn seconds(cases: &[&Opened]) -> Option<Seconds> {
    let mut seconds: Vec<f64> = cases.iter().map(|case| case.row.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let max = seconds.last().copied()?;
    // The smallest time that nine tenths of the cases do not exceed.
    let p90 = seconds[(seconds.len() * 9).div_ceil(10) - 1];
    Some(Seconds { median: quantile::median(&mut seconds)?, p90, max })
}

impl Group {
    fn new(title: &str, cases: &[&Opened]) -> Self {
        let all = || cases.iter().copied();
        Self {
            title: title.to_owned(),
            cases: cases.len(),
            recall: Rate::from_outcomes(
                all().flat_map(|case| case.visible().map(|effect| case.has(effect))),
            ),
            precision: Rate::from_outcomes(
                all().flat_map(|case| case.named().map(|finding| case.is_right(finding))),
            ),
            // Names that only a convention makes right are left out.
            strict_precision: Rate::from_outcomes(all().flat_map(|case| {
                let counted = case.named().filter(|f| case.is_hidden(f) || !case.is_convention(f));
                counted.map(|finding| case.is_hidden(finding))
            })),
            exact_sets: Rate::from_outcomes(
                all()
                    // Where nothing can be seen, naming nothing is no achievement.
                    .filter(|case| !case.is_outside_catalogue() && case.visible().next().is_some())
                    .map(Opened::is_exact),
            ),
            wrong_names: Rate::from_outcomes(all().map(Opened::has_wrong_name)),
            nulls_named: Rate::from_outcomes(
                all().filter(|case| case.truth.effects.is_empty()).map(Opened::is_named),
            ),
            outside_open: Rate::from_outcomes(
                all().filter(|case| case.is_outside_catalogue()).map(Opened::is_open),
            ),
            parameters: Rate::from_outcomes(
                all().flat_map(|case| case.parameters().map(|finding| case.is_right(finding))),
            ),
            seconds: seconds(cases),
        }
    }
}

pub(super) fn score_cases(opened: &[Opened], folders: Vec<String>) -> OutsideScores {
    let of = |title: &str, is_in: &dyn Fn(&Opened) -> bool| {
        Group::new(title, &opened.iter().filter(|case| is_in(case)).collect::<Vec<_>>())
    };
    let mut groups = vec![of("all", &|_| true)];
    for generator in Generator::ALL {
        groups.push(of(generator.name(), &|case| case.truth.generator == generator));
    }
    for (count, title) in ["nothing hidden", "one", "two", "three or more"].iter().enumerate() {
        let is_in = |case: &Opened| {
            !case.is_outside_catalogue() && case.truth.effects.len().min(3) == count
        };
        groups.push(of(title, &is_in));
    }
    // Apart from the others, since not all that is hidden there has a name.
    groups.push(of("outside the catalogue", &Opened::is_outside_catalogue));
    groups.retain(|group| group.cases > 0);
    let of_strength = |strength: &str| {
        let effects = opened.iter().flat_map(|case| case.visible().map(move |e| (case, e)));
        let effects = effects.filter(|(_, effect)| effect.strength == strength);
        Rate::from_outcomes(effects.map(|(case, effect)| case.has(effect)))
    };
    let strengths = ["weak", "middle", "strong"].map(|s| (s.to_owned(), of_strength(s)));
    // More than one commit: results were not made by one program.
    let mut commits: Vec<String> = opened.iter().map(|case| case.row.commit.clone()).collect();
    commits.sort();
    commits.dedup();
    let stated = |is_strict: bool| {
        let names = opened.iter().flat_map(|case| case.stated(is_strict));
        Stated::of(&names.collect::<Vec<_>>())
    };
    let mut scores = OutsideScores {
        cases: opened.len(),
        commits,
        folders,
        headlines: Vec::new(),
        stated: stated(false),
        stated_strict: stated(true),
        groups,
        strengths: strengths.to_vec(),
    };
    scores.headlines = headlines(opened, &scores);
    scores
}

/// Figures beside what is required of them. Of values nothing is known: parameters of generators are
/// not those of the catalogue.
fn headlines(opened: &[Opened], scores: &OutsideScores) -> Vec<Headline> {
    let all = &scores.groups[0];
    let of = |name, rate: &Rate| Headline::of_rate(name, rate);
    // The first name alone: later ones depend on it.
    let first: Vec<(f64, bool)> =
        opened.iter().filter_map(|case| case.stated(false).into_iter().next()).collect();
    let closed = opened.iter().filter(|case| case.is_named() && !case.has_wrong_name());
    let closed = closed.filter_map(|case| excess_closed(case.row.gap_before?, case.row.gap_after?));
    let mut seconds: Vec<f64> =
        // As on two cores, with perfect scaling: rows of other thread counts are compared with it.
        opened.iter().map(|c| c.row.seconds * c.row.threads as f64 / 2.0).collect();
    let unknown = |name, unit| {
        Headline::new(name, unit, None, 0)
            .noted("parameters of generators are not those of the catalogue".to_owned())
    };
    let wrong = &all.wrong_names;
    let strict = &scores.stated_strict;
    vec![
        of("visible effects named", &all.recall).with_targets(AtLeast(0.75), AtLeast(0.88)),
        of("names that are right", &all.precision)
            .with_targets(AtLeast(0.95), AtLeast(0.98))
            .noted(format!("wrong names in {} of {} cases", wrong.of, wrong.n)),
        of("the same, conventions aside", &all.strict_precision)
            .with_targets(AtLeast(0.95), AtLeast(0.98)),
        of("exact sets", &all.exact_sets),
        of("nulls with an effect named", &all.nulls_named).with_targets(AtMost(0.02), AtMost(0.01)),
        of("left open outside the catalogue", &all.outside_open)
            .with_targets(AtLeast(0.90), AtLeast(0.95)),
        of("parameters that are right", &all.parameters),
        unknown("error of estimates, median", Unit::Share).with_targets(AtMost(0.03), AtMost(0.01)),
        unknown("estimates whose 90 % interval holds the truth", Unit::Share)
            .with_targets(Within(0.85, 0.95), Within(0.85, 0.95)),
        gap_closed(median(closed)),
        probabilities(calibration_error(&bins(&first)), first.len(), &scores.stated),
        Headline::new(
            "stated probabilities, conventions aside",
            Unit::Number,
            strict.mean,
            strict.right.n,
        )
        .noted(format!(
            "{}/{} right, {} to {}",
            strict.right.of,
            strict.right.n,
            short(strict.right.lo95),
            short(strict.right.hi95)
        )),
        Headline::new(
            "seconds a case on 2 cores, median",
            Unit::Seconds,
            quantile::median(&mut seconds),
            opened.len(),
        )
        .with_targets(AtMost(60.0), AtMost(20.0)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outside::example::{case, opened};

    fn group<'a>(scores: &'a OutsideScores, title: &str) -> &'a Group {
        scores.groups.iter().find(|group| group.title == title).expect(title)
    }

    #[track_caller]
    fn assert_rate(rate: &Rate, of: usize, n: usize) {
        assert_eq!((rate.of, rate.n), (of, n));
    }

    #[test]
    fn made_up_verdicts_are_counted_as_they_are() {
        let scores = score_cases(&opened(), Vec::new());
        let all = group(&scores, "all");
        // leak, hot, thresholds, leak; missed: lowpass, refractory. ghost and dead do not count.
        assert_rate(&all.recall, 4, 6);
        // Right: leak_on, frame_grid, hot_pixels, threshold_mismatch, leak_on; wrong: psf_blur and
        // dead_pixels.
        assert_rate(&all.precision, 5, 7);
        // Without frame_grid and threshold_mismatch.
        assert_rate(&all.strict_precision, 3, 5);
        assert_rate(&all.exact_sets, 2, 4);
        assert_rate(&all.wrong_names, 2, 7);
        assert_rate(&all.nulls_named, 1, 2);
        assert_rate(&all.outside_open, 1, 1);
        assert_rate(&all.parameters, 1, 1);
        let seconds = all.seconds.expect("seven cases");
        assert_eq!((seconds.median, seconds.p90, seconds.max), (20.0, 30.0, 30.0));
        assert_eq!(group(&scores, "outside the catalogue").cases, 1);
        assert_eq!(group(&scores, "two").cases, 2);
        assert_rate(&group(&scores, "v2e").recall, 1, 2);
        let (lo, hi) = evpose_core::stats::interval::wilson(4, 6);
        assert_eq!((all.recall.lo95, all.recall.hi95), (lo, hi));
    }

    #[test]
    fn a_convention_belongs_to_its_generator() {
        let named = |generator, name| {
            let scores = score_cases(&[case("a", generator, &[], "effects", &[name])], Vec::new());
            let all = group(&scores, "all");
            (all.precision.of, all.nulls_named.of)
        };
        assert_eq!(named("v2e", "frame_grid"), (1, 0));
        assert_eq!(named("esim", "frame_grid"), (0, 1));
        assert_eq!(named("iebcs", "frame_grid"), (1, 0));
        assert_eq!(named("iebcs", "frame_difference"), (0, 1));
        assert_eq!(named("iebcs", "reset_overshoot"), (1, 0));
        assert_eq!(named("esim", "threshold_temporal_noise"), (1, 0));
    }

    #[test]
    fn a_larger_spread_than_the_nominal_one_is_no_convention() {
        let mut of_volt = case("a", "volt", &[], "effects", &["threshold_mismatch"]);
        assert!(!of_volt.has_wrong_name());
        of_volt.nominal_spread = 0.005;
        assert!(of_volt.has_wrong_name());
    }

    #[test]
    fn a_failed_run_is_a_miss_and_no_exact_set() {
        let scores = score_cases(&[case("a", "v2e", &[("leak", true)], "failed", &[])], Vec::new());
        let all = group(&scores, "all");
        assert_rate(&all.recall, 0, 1);
        assert_rate(&all.exact_sets, 0, 1);
        assert_rate(&all.precision, 0, 0);
    }
}
