//! The registry of published orderings of two systems, and their tests.
//!
//! # Source
//! As [`system`](crate::compare::system): Tables 1 and 2, and section 6.

use crate::compare::system::{DataSet, MOVE_ENET, System};
use crate::compare::trial::Trial;
use crate::study::{Finding, Relation, metric};

/// A published ordering: `system` is worse than `other`, or comparable to it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ordering {
    pub(crate) system: &'static str,
    pub(crate) relation: Relation,
    pub(crate) other: &'static str,
    pub(crate) measure: &'static str,
    pub(crate) data_set: DataSet,
}

/// A system that is worse than another.
pub(crate) const fn worse(
    system: &'static str,
    other: &'static str,
    measure: &'static str,
    data_set: DataSet,
) -> Ordering {
    Ordering { system, relation: Relation::Worse, other, measure, data_set }
}

const fn comparable(system: &'static str, measure: &'static str) -> Ordering {
    let (relation, data_set) = (Relation::Comparable, DataSet::Eh36m);
    Ordering { system, relation, other: MOVE_ENET, measure, data_set }
}

const fn slower(system: &'static str) -> Ordering {
    Ordering {
        system,
        relation: Relation::Slower,
        other: MOVE_ENET,
        measure: "poses_per_s",
        data_set: DataSet::Online,
    }
}

/// The registry.
pub(crate) const ORDERINGS: &[Ordering] = &[
    worse(MOVE_ENET, "openpose-grey", "pck_40", DataSet::Eh36m),
    worse("movenet-grey", MOVE_ENET, "pck_40", DataSet::Eh36m),
    worse("openpose-pim", MOVE_ENET, "pck_40", DataSet::Eh36m),
    worse("openpose-pim", MOVE_ENET, "pck_80", DataSet::Eh36m),
    comparable("openpose-grey", "pck_80"),
    comparable("move-enet-fixed-count", "pck_80"),
    worse("lift-mono", MOVE_ENET, "pck_40", DataSet::Dhp19),
    worse("lift-mono", MOVE_ENET, "pck_60", DataSet::Dhp19),
    worse("lift-mono", MOVE_ENET, "mpjpe_px", DataSet::Dhp19),
    worse("dhp19-cnn", MOVE_ENET, "mpjpe_px", DataSet::Dhp19),
    worse("lift-mono", "dhp19-cnn", "mpjpe_px", DataSet::Dhp19),
    worse("move-enet-wo-finetune", MOVE_ENET, "pck_40", DataSet::Eh36m),
    worse("move-enet-wo-pretrain", MOVE_ENET, "pck_40", DataSet::Eh36m),
    slower("openpose-grey"),
    slower("lift-mono"),
];

impl Ordering {
    /// The statement with its published figures, where the systems have them.
    pub(crate) fn finding(&self, systems: &[&System]) -> Finding {
        let Self { system, relation, other, measure, data_set } = *self;
        let figure = |name: &str| {
            let system = systems.iter().find(|system| system.name == name)?;
            system.figure(measure, data_set)
        };
        let heading = metric::<Trial>(measure).map_or(measure, |metric| metric.heading);
        let figures =
            figure(system).zip(figure(other)).map_or_else(String::new, |(here, there)| {
                format!(": {heading} {here} and {there} on {}", data_set.name())
            });
        let published = format!("{system} {} {other}{figures}", relation.words());
        Finding { row: system, relation, than: other, measure, published }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::stats::interval::Interval;

    use super::*;
    use crate::compare::system::SYSTEMS;
    use crate::study::{Verdict, verdict};

    #[test]
    fn orderings_are_those_of_the_published_figures() {
        for ordering in ORDERINGS {
            let figure = |name: &str| {
                let system = SYSTEMS.find(name).expect("a system");
                system.figure(ordering.measure, ordering.data_set).expect("a figure")
            };
            let estimate = figure(ordering.system) - figure(ordering.other);
            let difference = Interval { estimate, low: Some(estimate), high: Some(estimate) };
            let metric = metric::<Trial>(ordering.measure).expect("a measure");
            let verdict = verdict(ordering.relation, metric, &difference);
            assert_eq!(verdict, Verdict::Found, "{ordering:?}");
        }
        assert_eq!(
            ORDERINGS[6].finding(&SYSTEMS).published,
            "lift-mono worse than move-enet: PCK@0.4 0.28 and 0.97 on DHP19"
        );
    }
}
