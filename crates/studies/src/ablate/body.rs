//! `evpose ablate body`: rows of the ablation of bodies, compared as systems are.
//!
//! # Source
//! Goyal et al.: *MoveEnet*, CVPRW 2023, Table 2, Fig. 8, and section 6 on resolution and moving
//! cameras.

use anyhow::Result;
use evpose_core::Registry;

use crate::compare::args::{BodyStudyArgs, NetworkFiles, names};
use crate::compare::data::Data;
use crate::compare::ordering::{Ordering, worse};
use crate::compare::stages::Network;
use crate::compare::study::{self, Protocol};
use crate::compare::system::{
    DataSet, Figure, Images, MEAN_POSE, System, Test, Weights, eh36m, selected, system,
};
use crate::study::Relation;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose ablate body --out runs/ablation-body\n  \
    evpose ablate body --out runs/ablation-body --resume\n  \
    evpose ablate body --rows wo-pretrain,pim --seeds 2 --steps 800 --out runs/two-rows\n\n\
    People are simulated once for each seed and shared by all rows; networks that several rows need are \
    trained once. The full method always runs, since every row is held against it.")]
pub struct AblateBodyArgs {
    /// Rows to run, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = names(&ROWS))]
    rows: Vec<String>,
    #[command(flatten)]
    body: BodyStudyArgs,
}

/// The full method, with which every row is compared.
const FULL: &str = "full";

const ABLATION: Protocol = Protocol {
    title: "What each part of the method for bodies is worth",
    system: "row",
    folder: "rows",
    files: ["ablation.json", "ablation.md", "ablation.html"],
    orderings: &[
        Ordering {
            system: "fixed-count",
            relation: Relation::Comparable,
            other: FULL,
            measure: "pck_40",
            data_set: DataSet::Eh36m,
        },
        worse("wo-finetune", FULL, "pck_40", DataSet::Eh36m),
        worse("wo-pretrain", FULL, "pck_40", DataSet::Eh36m),
        worse("pim", FULL, "pck_40", DataSet::Eh36m),
        worse("fixed-count-moving", FULL, "pck_40", DataSet::Eh36m),
    ],
    about_orderings: "Published orders of a row and the full method, and their tests: the row minus the full method.",
};

const fn row(
    name: &'static str,
    about: &'static str,
    (images, network, test): (Images, Network, Test),
    published: &'static [Figure],
) -> System {
    system(name, about, (images, Weights::MoveEnet(network), test), published)
}

static ROWS: Registry<System> = Registry::new(&[
    &row(
        FULL,
        "EROS, pre-trained on stills that look like one, fine-tuned on recordings",
        (Images::Eros, Network::Full, Test::HeldOut),
        &[eh36m("pck_40", 0.89), eh36m("pck_80", 0.93)],
    ),
    &row(
        "fixed-count",
        "frames of 7500 events instead of an EROS, from scratch, labelled at their mean time",
        (Images::FixedCount, Network::FixedCount, Test::HeldOut),
        &[eh36m("pck_40", 0.87), eh36m("pck_80", 0.93)],
    ),
    &row(
        "wo-finetune",
        "pre-trained only",
        (Images::Eros, Network::Pretrained, Test::HeldOut),
        &[eh36m("pck_40", 0.30), eh36m("pck_80", 0.52)],
    ),
    &row(
        "wo-pretrain",
        "recordings only, from scratch",
        (Images::Eros, Network::Scratch, Test::HeldOut),
        &[eh36m("pck_40", 0.59), eh36m("pck_80", 0.81)],
    ),
    &row(
        "grey",
        "photographs instead of events, in both stages: no blind spots, no noise of events",
        (Images::Grey, Network::Grey, Test::HeldOut),
        &[eh36m("pck_40", 0.84), eh36m("pck_80", 0.91)],
    ),
    &row(
        "pim",
        "integrated polarities instead of an EROS, from scratch",
        (Images::Pim, Network::Pim, Test::HeldOut),
        &[eh36m("pck_40", 0.46), eh36m("pck_80", 0.54)],
    ),
    &row(
        "vga",
        "the full method, trained at 346x260, evaluated at 640x480",
        (Images::Eros, Network::Full, Test::Vga),
        &[],
    ),
    &row(
        "moving",
        "the full method before cameras held by hand",
        (Images::Eros, Network::Full, Test::Moving),
        &[],
    ),
    &row(
        "fixed-count-moving",
        "frames of 7500 events before cameras held by hand",
        (Images::FixedCount, Network::FixedCount, Test::Moving),
        &[],
    ),
    &MEAN_POSE,
]);

pub(super) fn run(args: &AblateBodyArgs) -> Result<()> {
    let mut names = args.rows.clone();
    // No names select all rows, the full method among them.
    names.extend((!names.is_empty()).then(|| FULL.to_owned()));
    let chosen = selected(&ROWS, &names);
    study::run(&ABLATION, &args.body, chosen, Data::Simulated, &NetworkFiles::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_of_a_kind_and_statements_have_the_published_figures_of_rows() {
        for row in &ROWS {
            assert_eq!(selected(&ROWS, &[row.name.to_owned()]).len(), 1, "{}", row.name);
        }
        let statement = |index: usize| ABLATION.orderings[index].finding(&ROWS).published;
        assert_eq!(statement(3), "pim worse than full: PCK@0.4 0.46 and 0.89 on eH3.6M");
        assert_eq!(statement(4), "fixed-count-moving worse than full");
    }
}
