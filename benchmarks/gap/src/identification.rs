//! Targets of identification, for each composition of a plan.

use gapbench_pixel::Tier;

use super::group::Group;
use super::score::Scores;
use super::stats::Rate;
use super::targets::Headline;
use super::targets::Target::{AtLeast, AtMost};

fn at_least(name: &'static str, rate: &Rate, required: f64, goal: f64) -> Headline {
    Headline::of_rate(name, rate).with_targets(AtLeast(required), AtLeast(goal))
}

fn at_most(name: &'static str, rate: &Rate, required: f64, goal: f64) -> Headline {
    Headline::of_rate(name, rate).with_targets(AtMost(required), AtMost(goal))
}

/// Recall, precision and exact sets of all cases.
pub(super) fn all(scores: &Scores) -> Vec<Headline> {
    let Group { recall, precision, precision_of_hidden, .. } = &scores.all;
    let of_names = |name, rate| match scores.tier {
        Tier::Home => at_least(name, rate, 0.95, 0.98),
        Tier::Plain => Headline::of_rate(name, rate),
    };
    vec![
        Headline::of_rate("all cases: visible effects named", recall),
        of_names("all cases: names that are right", precision),
        of_names("all cases: the same, conventions aside", precision_of_hidden),
        Headline::of_rate("all cases: exact sets", &scores.exact_sets),
    ]
}

/// Targets of identification among conventions: recall of visible effects and precision of names.
pub(super) fn home(scores: &Scores) -> Vec<Headline> {
    let unknown = Rate::default();
    let group = |name: &str| scores.groups.iter().find(|group| group.name == name);
    let recall = |name| group(name).map_or(unknown, |group| group.recall);
    let precision = |headline, of, required, goal| {
        let hidden = group(of).map_or(unknown, |group| group.precision_of_hidden);
        let rate = group(of).map_or(unknown, |group| group.precision);
        at_least(headline, &rate, required, goal)
            .noted(format!("without conventions {}/{}", hidden.of, hidden.n))
    };
    let exact = |headline: Headline, of| {
        let exact = group(of).map_or(unknown, |group| group.exact);
        headline.noted(format!("exact sets {}/{}", exact.of, exact.n))
    };
    let singles = at_least("singles: visible effects named", &recall("singles"), 0.92, 0.97);
    let pairs = at_least("pairs, both visible: both named", &scores.pairs_both, 0.75, 0.90);
    let several = recall("three to five");
    let several = at_least("three to five: visible effects named", &several, 0.70, 0.85);
    let wrong = &scores.wrong_names;
    vec![
        exact(singles, "singles"),
        precision("singles: names that are right", "singles", 0.97, 0.99),
        exact(pairs, "pairs"),
        precision("pairs: names that are right", "pairs", 0.95, 0.98),
        exact(several, "three to five"),
        precision("three to five: names that are right", "three to five", 0.95, 0.98),
        at_most("nulls with an effect named", &scores.nulls_named, 0.02, 0.01)
            .noted(format!("wrong names in all cases: {}/{}", wrong.of, wrong.n)),
        at_least("parameters alone called so", &scores.parameters_right, 0.92, 0.97),
        at_least("outside the catalogue, nothing blamed", &scores.outside_unnamed, 0.90, 0.95)
            .noted(format!(
                "no wrong name {}/{}",
                scores.lenient.outside_unnamed.of, scores.lenient.outside_unnamed.n
            )),
    ]
}

/// Targets of identification in an otherwise ideal pixel: fractions of cases with right and with
/// wrong answers.
pub(super) fn plain(scores: &Scores) -> Vec<Headline> {
    let note = |rate: &Rate| format!("leniently {}/{}", rate.of, rate.n);
    let Scores { lenient, .. } = scores;
    let outside = lenient.outside_unnamed;
    vec![
        at_least("visible singles named right", &scores.singles_right, 0.90, 0.97)
            .noted(note(&lenient.singles_right)),
        at_most("wrong names, all cases", &scores.wrong_names, 0.02, 0.01)
            .noted(note(&lenient.wrong_names)),
        at_most("nulls with an effect named", &scores.nulls_named, 0.02, 0.02)
            .noted(format!("not called so: {}", scores.nulls_not_closed.of)),
        at_least("parameters alone called so", &scores.parameters_right, 0.90, 0.95),
        at_least("pairs with both named", &scores.pairs_both, 0.75, 0.88)
            .noted(note(&lenient.pairs_both)),
        at_least("outside the catalogue, nothing blamed", &scores.outside_unnamed, 0.90, 0.95)
            .noted(format!("no effect named {}/{}", outside.of, outside.n)),
    ]
}
