//! Rows of the ablation of bodies: network, test set and published result.
//!
//! # Source
//! Goyal et al.: *MoveEnet*, CVPRW 2023, Table 2, Fig. 8, and section 6 on resolution and moving
//! cameras.

use clap::builder::{PossibleValue, PossibleValuesParser};
use evpose_core::SensorSize;
use evpose_task::body::BodyConfig;

use super::{Network, Stages};
use crate::ablate::finding::Relation;

/// The full method, with which every row is compared.
pub(super) const FULL: &str = "full";

/// A row of the study.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) name: &'static str,
    /// Description in one line.
    pub(super) about: &'static str,
    pub(super) network: Network,
    pub(super) evaluated_on: Test,
    /// PCK@0.4 and PCK@0.8 on eH3.6M, where there are any.
    pub(super) published: Option<[f64; 2]>,
    /// Published relation to the full method.
    pub(super) expected: Option<Relation>,
}

/// Test set: the held-out people of the second stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Test {
    /// Unchanged.
    HeldOut,
    /// From a camera of 640x480 pixels.
    Vga,
    /// From hand-held cameras.
    Moving,
}

const WORSE: Option<Relation> = Some(Relation::Worse);
const COMPARABLE: Option<Relation> = Some(Relation::Comparable);

/// The registry of rows.
pub(super) const ROWS: &[Row] = &[
    Row {
        name: FULL,
        about: "EROS, pre-trained on stills that look like one, fine-tuned on recordings",
        network: Network::Full,
        evaluated_on: Test::HeldOut,
        published: Some([0.89, 0.93]),
        expected: None,
    },
    Row {
        name: "fixed-count",
        about: "frames of 7500 events instead of an EROS, from scratch, labelled at their mean time",
        network: Network::FixedCount,
        evaluated_on: Test::HeldOut,
        published: Some([0.87, 0.93]),
        expected: COMPARABLE,
    },
    Row {
        name: "wo-finetune",
        about: "pre-trained only",
        network: Network::Pretrained,
        evaluated_on: Test::HeldOut,
        published: Some([0.30, 0.52]),
        expected: WORSE,
    },
    Row {
        name: "wo-pretrain",
        about: "recordings only, from scratch",
        network: Network::Scratch,
        evaluated_on: Test::HeldOut,
        published: Some([0.59, 0.81]),
        expected: WORSE,
    },
    Row {
        name: "grey",
        about: "photographs instead of events, in both stages: no blind spots, no noise of events",
        network: Network::Grey,
        evaluated_on: Test::HeldOut,
        published: Some([0.84, 0.91]),
        expected: None,
    },
    Row {
        name: "pim",
        about: "integrated polarities instead of an EROS, from scratch",
        network: Network::Pim,
        evaluated_on: Test::HeldOut,
        published: Some([0.46, 0.54]),
        expected: WORSE,
    },
    Row {
        name: "vga",
        about: "the full method, trained at 346x260, evaluated at 640x480",
        network: Network::Full,
        evaluated_on: Test::Vga,
        published: None,
        expected: None,
    },
    Row {
        name: "moving",
        about: "the full method before cameras held by hand",
        network: Network::Full,
        evaluated_on: Test::Moving,
        published: None,
        expected: None,
    },
    Row {
        name: "fixed-count-moving",
        about: "frames of 7500 events before cameras held by hand",
        network: Network::FixedCount,
        evaluated_on: Test::Moving,
        published: None,
        expected: WORSE,
    },
];

/// Names for the command line.
pub(crate) fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(ROWS.iter().map(|row| PossibleValue::new(row.name).help(row.about)))
}

/// The rows of these names, or all; the full method always.
pub(super) fn selected(names: &[String]) -> Vec<&'static Row> {
    let is_chosen = |row: &&Row| {
        row.name == FULL || names.is_empty() || names.iter().any(|name| name == row.name)
    };
    ROWS.iter().filter(is_chosen).collect()
}

impl Test {
    /// Name of its directory.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::HeldOut => "held-out",
            Self::Vga => "held-out-vga",
            Self::Moving => "held-out-moving",
        }
    }

    /// The recordings it is made of.
    pub(super) fn config(self, stages: &Stages) -> BodyConfig {
        let mut config = stages.finetune.held_out();
        match self {
            Self::HeldOut => {}
            Self::Vga => config.simulation.sensor_size = SensorSize { width: 640, height: 480 },
            Self::Moving => config.simulation.moving_cameras = 1.0,
        }
        config
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_of_a_kind_and_the_full_method_always_runs() {
        for row in ROWS {
            assert_eq!(ROWS.iter().filter(|other| other.name == row.name).count(), 1);
        }
        let chosen = selected(&["pim".to_owned()]);
        assert_eq!(chosen.iter().map(|row| row.name).collect::<Vec<_>>(), [FULL, "pim"]);
    }
}
