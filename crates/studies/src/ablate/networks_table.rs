//! The networks of the study, with what was published about each.
//!
//! # Source
//! Rudnev et al., supplement, section on alternative backbones. It has no table: validation losses are
//! said to be comparable to that of ResNet-18 or not, and two networks not to reach 1000 poses per
//! second on the authors' GPU.

use super::outcome::{Outcome, RowOutcome};
use super::rows::{FULL, Group};
use super::table::{align, thousands};
use evpose_report::format::{with_interval, with_interval_or_dash};

/// Published statements about a network.
struct PublishedNetwork {
    /// Name of its row.
    row: &'static str,
    /// In tables.
    network: &'static str,
    validation_loss: &'static str,
    /// Whether it reaches 1000 poses per second.
    real_time: &'static str,
}

const fn published(
    row: &'static str,
    network: &'static str,
    validation_loss: &'static str,
    real_time: &'static str,
) -> PublishedNetwork {
    PublishedNetwork { row, network, validation_loss, real_time }
}

const UNKNOWN: &str = "-";
const COMPARABLE: &str = "comparable";
const NOT_COMPARABLE: &str = "not comparable";

const PUBLISHED: [PublishedNetwork; 10] = [
    published(FULL, "ResNet-18", "the reference", "yes"),
    published("resnet34", "ResNet-34", COMPARABLE, "no"),
    published("mobilenet-v2", "MobileNetV2", COMPARABLE, "yes, faster"),
    published("vgg11-bn", "VGG-11", COMPARABLE, "no"),
    published("vgg13-bn", "VGG-13", COMPARABLE, UNKNOWN),
    published("vgg16-bn", "VGG-16", COMPARABLE, UNKNOWN),
    published("vgg19-bn", "VGG-19", COMPARABLE, UNKNOWN),
    published("shufflenet-v2", "ShuffleNetV2", NOT_COMPARABLE, UNKNOWN),
    published("mnasnet", "MnasNet", NOT_COMPARABLE, UNKNOWN),
    published("inception-v3", "Inception v3", NOT_COMPARABLE, UNKNOWN),
];

/// Headings.
pub(super) const HEADER: [&str; 10] = [
    "network",
    "parameters",
    "at full width",
    "validation loss",
    "AUC 2D",
    "AUC 3D",
    "MPJPE mm",
    "poses/s",
    "published: loss",
    "published: 1000 poses/s",
];

/// Legend of the columns.
pub(super) const LEGEND: &str = "Every network is trained, evaluated and timed here, at the width of \
    the config. Validation loss: the lowest of a training, on the starts of the training sequences. \
    poses/s: the network alone on this machine, one window at a time; `evpose bench infer --network \
    all` times all of them at full width. What was published has no figures: whether the validation \
    loss is comparable to ResNet-18's, and whether the network reaches 1000 poses per second on the \
    authors' GPU.";

/// The cells of each network that was run. None if no network but the full method's was.
pub(super) fn rows(outcome: &Outcome) -> Option<Vec<Vec<String>>> {
    if !outcome.rows.iter().any(|row| row.row.group == Group::Backbone) {
        return None;
    }
    let cells = |published: &PublishedNetwork| {
        let row = outcome.rows.iter().find(|row| row.name == published.row)?;
        Some(cells(row, published))
    };
    Some(PUBLISHED.iter().filter_map(cells).collect())
}

fn cells(row: &RowOutcome, published: &PublishedNetwork) -> Vec<String> {
    let mean = |name: &str, digits| with_interval_or_dash(row.means.get(name), digits);
    vec![
        published.network.to_owned(),
        thousands(row.parameters),
        thousands(row.parameters_as_published),
        with_interval_or_dash(row.validation_loss.as_ref(), 2),
        mean("auc_2d", 3),
        mean("auc_3d", 3),
        mean("mpjpe_mm", 1),
        with_interval(&row.poses_per_s, 0),
        published.validation_loss.to_owned(),
        published.real_time.to_owned(),
    ]
}

/// The table as Markdown whose columns are aligned. None if no network but the full method's was run.
pub(super) fn aligned(outcome: &Outcome) -> Option<String> {
    rows(outcome).map(|rows| align(&HEADER, &rows))
}

#[cfg(test)]
mod tests {
    use anyhow::Result;

    use super::super::outcome::tests::outcome;
    use super::super::rows::ROWS;
    use super::*;

    #[test]
    fn every_network_of_the_study_has_a_published_statement() {
        let rows = ROWS.iter().filter(|row| [Group::Full, Group::Backbone].contains(&row.group));
        let mut names: Vec<&str> = rows.map(|row| row.name).collect();
        let mut known: Vec<&str> = PUBLISHED.iter().map(|published| published.row).collect();
        names.sort_unstable();
        known.sort_unstable();
        assert_eq!(names, known);
    }

    #[test]
    fn networks_stand_beside_what_was_published() -> Result<()> {
        let full = (FULL, [0.5, 0.6, 0.7]);
        assert_eq!(aligned(&outcome(&[full, ("eoi", [0.4, 0.5, 0.6])])?), None);
        let table = aligned(&outcome(&[full, ("inception-v3", [0.4, 0.5, 0.6])])?);
        let table = table.unwrap_or_default();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 4, "{table}");
        assert!(lines[2].starts_with("| ResNet-18") && lines[2].contains("0.40 ± "), "{table}");
        assert!(lines[3].contains("not comparable"), "{table}");
        Ok(())
    }
}
