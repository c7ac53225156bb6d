//! The registry of published orderings of two systems, and their tests.
//!
//! # Source
//! As [`system`](crate::compare::system): Tables 1 and 2, and section 6.

use crate::ablate::{Relation, Verdict};
use evpose_core::stats::interval::Interval;
use serde::Serialize;

use crate::compare::measure::{DataSet, Measure};
use crate::compare::system::{MOVE_ENET, SYSTEMS};

/// A published ordering: `system` is worse than `other`, or comparable to it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ordering {
    pub(crate) system: &'static str,
    pub(crate) relation: Relation,
    pub(crate) other: &'static str,
    pub(crate) measure: Measure,
    pub(crate) data_set: DataSet,
}

const fn worse(
    system: &'static str,
    other: &'static str,
    measure: Measure,
    data_set: DataSet,
) -> Ordering {
    Ordering { system, relation: Relation::Worse, other, measure, data_set }
}

const fn comparable(system: &'static str, measure: Measure) -> Ordering {
    let (relation, data_set) = (Relation::Comparable, DataSet::Eh36m);
    Ordering { system, relation, other: MOVE_ENET, measure, data_set }
}

const fn slower(system: &'static str) -> Ordering {
    Ordering {
        system,
        relation: Relation::Slower,
        other: MOVE_ENET,
        measure: Measure::PosesPerS,
        data_set: DataSet::Online,
    }
}

/// The registry.
pub(crate) const ORDERINGS: &[Ordering] = &[
    worse(MOVE_ENET, "openpose-grey", Measure::Pck40, DataSet::Eh36m),
    worse("movenet-grey", MOVE_ENET, Measure::Pck40, DataSet::Eh36m),
    worse("openpose-pim", MOVE_ENET, Measure::Pck40, DataSet::Eh36m),
    worse("openpose-pim", MOVE_ENET, Measure::Pck80, DataSet::Eh36m),
    comparable("openpose-grey", Measure::Pck80),
    comparable("move-enet-fixed-count", Measure::Pck80),
    worse("lift-mono", MOVE_ENET, Measure::Pck40, DataSet::Dhp19),
    worse("lift-mono", MOVE_ENET, Measure::Pck60, DataSet::Dhp19),
    worse("lift-mono", MOVE_ENET, Measure::MpjpePx, DataSet::Dhp19),
    worse("dhp19-cnn", MOVE_ENET, Measure::MpjpePx, DataSet::Dhp19),
    worse("lift-mono", "dhp19-cnn", Measure::MpjpePx, DataSet::Dhp19),
    worse("move-enet-wo-finetune", MOVE_ENET, Measure::Pck40, DataSet::Eh36m),
    worse("move-enet-wo-pretrain", MOVE_ENET, Measure::Pck40, DataSet::Eh36m),
    slower("openpose-grey"),
    slower("lift-mono"),
];

/// An ordering, tested.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct TestedOrdering {
    /// The published statement.
    pub(crate) statement: String,
    pub(crate) measure: Measure,
    /// The first system minus the second, seed by seed; none if one of them did not run.
    pub(crate) difference: Option<Interval>,
    /// None if one of them did not run.
    pub(crate) verdict: Option<Verdict>,
    /// Systems that did not run.
    pub(crate) missing: Vec<&'static str>,
}

impl Ordering {
    /// The statement with its published figures.
    pub(crate) fn statement(&self) -> String {
        let Self { system, relation, other, measure, data_set } = *self;
        let figure = |name: &str| {
            let system = SYSTEMS.iter().find(|system| system.name == name);
            system.and_then(|system| system.figure(measure, data_set)).unwrap_or(f64::NAN)
        };
        let (words, name) = (relation.words(), measure.name());
        let (here, there) = (figure(system), figure(other));
        format!("{system} {words} {other}: {name} {here} and {there} on {data_set}")
    }

    /// The verdict from a difference of the measure, `system` minus `other`.
    pub(crate) fn verdict(&self, difference: &Interval) -> Verdict {
        if self.measure.is_good_if_large() {
            return self.relation.verdict(difference);
        }
        let negative = |value: Option<f64>| value.map(|value| -value);
        self.relation.verdict(&Interval {
            estimate: -difference.estimate,
            low: negative(difference.high),
            high: negative(difference.low),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orderings_are_those_of_the_published_figures() {
        for ordering in ORDERINGS {
            let figure = |name: &str| {
                let system = SYSTEMS.iter().find(|system| system.name == name);
                system.and_then(|system| system.figure(ordering.measure, ordering.data_set))
            };
            let figures = figure(ordering.system).zip(figure(ordering.other));
            let Some((system, other)) = figures else {
                panic!("{}: no figure", ordering.statement());
            };
            let difference = Interval {
                estimate: system - other,
                low: Some(system - other),
                high: Some(system - other),
            };
            assert_eq!(ordering.verdict(&difference), Verdict::Found, "{}", ordering.statement());
        }
    }

    #[test]
    fn a_larger_error_is_worse() {
        let ordering = worse("a", "b", Measure::MpjpePx, DataSet::Dhp19);
        let difference =
            |low, high| Interval { estimate: 0.5 * (low + high), low: Some(low), high: Some(high) };
        assert_eq!(ordering.verdict(&difference(1.0, 2.0)), Verdict::Found);
        assert_eq!(ordering.verdict(&difference(-2.0, -1.0)), Verdict::Reversed);
        assert_eq!(ordering.verdict(&difference(-1.0, 2.0)), Verdict::WithinNoise);
    }
}
