//! Recall of visible effects and precision of names, by the count of hidden effects.

use gapbench_pixel::CaseKind;
use serde::Serialize;

use super::opened::Opened;
use super::stats::{Median, Rate, median};

/// Cases that are scored together.
const GROUPS: [(&str, &[CaseKind]); 6] = [
    ("singles", &[CaseKind::Single]),
    ("pairs", &[CaseKind::Pair]),
    ("three to five", &[CaseKind::Several]),
    ("parameters alone", &[CaseKind::Parameter]),
    ("nulls", &[CaseKind::Null]),
    ("outside the catalogue", &[CaseKind::LeftOut, CaseKind::NeverCatalogued]),
];

/// Scores of the cases of a group. Rates over effects and names take those of one case for
/// independent.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Group {
    pub(super) name: &'static str,
    pub(super) cases: usize,
    /// Visible hidden effects of the catalogue that are named.
    pub(super) recall: Rate,
    /// Names that are right, those of conventions among them.
    pub(super) precision: Rate,
    /// The same without names of conventions.
    pub(super) precision_of_hidden: Rate,
    /// Cases in which the answer is the expected one: for effects, all visible ones are named and
    /// nothing that is not there.
    pub(super) exact: Rate,
    /// Cases with a name that is not there.
    pub(super) wrong: Rate,
    /// Seconds of a case on two cores.
    pub(super) seconds: Option<Median>,
}

pub(super) fn groups(opened: &[Opened]) -> Vec<Group> {
    let of = |(name, kinds): &(&'static str, &[CaseKind])| {
        let cases: Vec<&Opened> =
            opened.iter().filter(|case| kinds.contains(&case.truth.kind)).collect();
        (!cases.is_empty()).then(|| Group::new(name, &cases))
    };
    GROUPS.iter().filter_map(of).collect()
}

impl Group {
    pub(super) fn new(name: &'static str, cases: &[&Opened]) -> Self {
        let names = || cases.iter().flat_map(|case| case.names().into_iter().map(|n| (*case, n)));
        let is_right = |(case, name): (&Opened, &str)| case.truth.holds(name);
        // Names that only a convention makes right would flatter precision.
        let is_no_convention = |(case, name): &(&Opened, &str)| {
            case.truth.hides(name) || !case.truth.is_convention(name)
        };
        // What is outside of the catalogue cannot be named, so that it is no miss.
        let recall = cases.iter().filter(|case| !case.is_outside()).flat_map(|case| {
            let names = case.names();
            let is_named = |truth: &String| case.truth.is_named(truth, &names);
            case.truth.visible.iter().map(is_named).collect::<Vec<_>>()
        });
        Self {
            name,
            cases: cases.len(),
            recall: Rate::from_outcomes(recall),
            precision: Rate::from_outcomes(names().map(is_right)),
            precision_of_hidden: Rate::from_outcomes(
                names().filter(is_no_convention).map(is_right),
            ),
            exact: Rate::from_outcomes(cases.iter().map(|case| case.is_met())),
            wrong: Rate::from_outcomes(cases.iter().map(|case| case.is_wrong())),
            seconds: median(cases.iter().map(|case| case.row.seconds_on_two_cores())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    fn group<'a>(groups: &'a [Group], name: &str) -> &'a Group {
        groups.iter().find(|group| group.name == name).expect("the group has cases")
    }

    #[test]
    fn whoever_names_all_visible_effects_and_no_other_has_every_rate() {
        for group in groups(&example::opened_home()) {
            assert_eq!((group.exact.of, group.wrong.of), (group.cases, 0), "{}", group.name);
            assert_eq!(group.recall.of, group.recall.n, "{}", group.name);
            assert_eq!(group.precision.of, group.precision.n, "{}", group.name);
        }
    }

    #[test]
    fn names_of_conventions_are_right_in_every_group_and_blame_no_null() {
        let mut opened = example::opened_home();
        let before = groups(&opened);
        let named = example::name_conventions(&mut opened);
        assert!(named > opened.len());
        for (before, after) in before.iter().zip(groups(&opened)) {
            assert_eq!((after.exact.of, after.wrong.of), (before.exact.of, 0), "{}", after.name);
            assert!(after.precision.n > before.precision.n);
            assert_eq!(after.precision_of_hidden, before.precision_of_hidden);
        }
    }

    #[test]
    fn one_effect_that_is_not_named_is_one_miss_of_recall_and_one_set_that_is_not_exact() {
        let mut opened = example::opened_home();
        let case = opened.iter_mut().find(|o| o.truth.visible.len() == 5).expect("five effects");
        case.row.effects.pop();
        let groups = groups(&opened);
        let several = group(&groups, "three to five");
        assert_eq!((several.recall.of, several.recall.n), (239, 240));
        assert_eq!((several.exact.of, several.exact.n, several.wrong.of), (59, 60, 0));
        assert_eq!(several.precision.of, several.precision.n);
    }

    #[test]
    fn a_name_that_is_not_there_counts_once_against_precision() {
        let mut opened = example::opened_home();
        let case = opened.iter_mut().find(|o| o.truth.kind == CaseKind::Pair).expect("a pair");
        case.row.effects[0].name = "no such effect".to_owned();
        let groups = groups(&opened);
        let pairs = group(&groups, "pairs");
        assert_eq!((pairs.precision.of, pairs.precision.n), (119, 120));
        assert_eq!((pairs.recall.of, pairs.recall.n), (119, 120));
        assert_eq!((pairs.exact.of, pairs.wrong.of), (59, 1));
    }

    #[test]
    fn effects_that_do_not_show_are_no_misses_and_right_when_named() {
        let mut opened = example::opened_home();
        let hidden = |o: &&mut Opened| o.truth.kind == CaseKind::Single && !o.truth.is_visible;
        let (mut count, name) = (0, |o: &Opened| o.truth.effects[0].clone());
        for case in opened.iter_mut().filter(hidden).take(7) {
            let mut finding = example::finding();
            finding.name = name(case);
            case.row.effects.push(finding);
            count += 1;
        }
        let groups = groups(&opened);
        let singles = group(&groups, "singles");
        assert_eq!((count, singles.recall.n, singles.cases), (7, 108, 144));
        assert_eq!((singles.precision.of, singles.precision.n), (115, 115));
    }

    #[test]
    fn outside_the_catalogue_conventions_may_be_named_but_not_as_all_there_is() {
        use evpose_gap::verdict::Answer;
        let mut opened = example::opened_home();
        example::name_conventions(&mut opened);
        let outside = opened.iter_mut().find(|o| o.is_outside()).expect("one is outside");
        for (answer, is_met) in [
            (Answer::NoneOfCatalogue, true),
            (Answer::Undecided, true),
            (Answer::Partial, true),
            (Answer::Effects, false),
            (Answer::NoGap, false),
        ] {
            outside.row.verdict = answer;
            assert_eq!(outside.is_met(), is_met, "{answer:?}");
        }
    }
}
