//! The outcome as tables: on the terminal and as Markdown.

use evpose_report::format::with_interval_or_dash;

use crate::compare::measure::{DataSet, Measure};
use crate::compare::ordering::TestedOrdering;
use crate::compare::outcome::{Outcome, SystemOutcome};
use crate::study::{VERDICTS, listed, markdown_table};

/// Headings of the table of systems.
pub(crate) fn header() -> Vec<&'static str> {
    let measures = Measure::ALL.map(Measure::name);
    ["system", "input"].into_iter().chain(measures).chain(["training s", "published"]).collect()
}

/// The cells of a system.
pub(crate) fn cells(system: &SystemOutcome) -> Vec<String> {
    let mut cells = vec![system.name.to_owned(), system.images.to_owned()];
    for measure in Measure::ALL {
        cells.push(with_interval_or_dash(system.mean(measure), measure.digits()));
    }
    cells.push(system.training_s.map_or_else(|| "-".to_owned(), |s| format!("{:.0}", s.estimate)));
    cells.push(published(system));
    cells
}

/// Published figures: `DHP19: PCK@0.4 0.97, …; eH3.6M: …`.
fn published(system: &SystemOutcome) -> String {
    let sets = [DataSet::Dhp19, DataSet::Eh36m, DataSet::Online];
    let of_set = |set: DataSet| {
        let figures = system.published.iter().filter(|figure| figure.data_set == set);
        let figures: Vec<String> =
            figures.map(|figure| format!("{} {}", figure.measure.name(), figure.value)).collect();
        (!figures.is_empty()).then(|| format!("{set}: {}", figures.join(", ")))
    };
    let all: Vec<String> = sets.into_iter().filter_map(of_set).collect();
    if all.is_empty() { "-".to_owned() } else { all.join("; ") }
}

/// The verdict of an ordering, in words.
pub(crate) fn verdict(ordering: &TestedOrdering) -> String {
    match ordering.verdict {
        Some(verdict) => verdict.to_string(),
        None if ordering.missing.is_empty() => "not tested: nothing was measured".to_owned(),
        None => format!("not tested: {} did not run", ordering.missing.join(" and ")),
    }
}

/// The difference of an ordering.
pub(crate) fn difference(ordering: &TestedOrdering) -> String {
    with_interval_or_dash(ordering.difference.as_ref(), ordering.measure.digits())
}

/// Protocol and origin of the values.
pub(crate) fn legend(outcome: &Outcome) -> String {
    format!(
        "Evaluated on {}. Means over seeds {} with 95% intervals of Student's t. PCK: share of the 13 \
         joints within a fraction of the torso's diagonal; MPJPE in pixels of the images; in mm \
         of one camera for systems that estimate depth, of others triangulated where the recordings \
         have two calibrated cameras. poses/s: from image to joints on one thread of {}, the \
         representation not included. Published figures are of other data. Verdicts follow from the \
         interval of the difference of both systems, seed by seed: {VERDICTS}.",
        outcome.data,
        listed(&outcome.seeds),
        outcome.machines.join(" and "),
    )
}

/// Content of `comparison.md`, which the terminal shows too.
pub(crate) fn markdown(outcome: &Outcome) -> String {
    let ran = outcome.systems.iter().filter(|system| system.missing.is_none());
    let mut text = markdown_table(&header(), ran.map(cells));
    for system in &outcome.systems {
        if let Some(reason) = &system.missing {
            text += &format!("\n{} did not run: {reason}.", system.name);
        }
    }
    text += &format!("\n\n{}\n\n", legend(outcome));
    if !outcome.orderings.is_empty() {
        text += "| published | difference here | |\n|---|---|---|\n";
    }
    for ordering in &outcome.orderings {
        text += &format!(
            "| {} | {} | {} |\n",
            ordering.statement,
            difference(ordering),
            verdict(ordering)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use anyhow::Result;

    use super::*;
    use crate::compare::outcome::tests::outcome;

    #[test]
    fn every_system_has_a_row_or_says_why_not() -> Result<()> {
        let text = markdown(&outcome(&[0.8, 0.6, 0.7])?);
        assert!(text.contains("| move-enet | EROS | 0.700 ± 0.248 |"), "{text}");
        assert!(text.contains("DHP19: PCK@0.4 0.28, PCK@0.6 0.51, MPJPE px 26.79"), "{text}");
        assert!(text.contains("\nopenpose-pim did not run: give --openpose FILE.onnx."), "{text}");
        assert!(
            text.contains(
                "PCK@0.4 0.46 and 0.89 on eH3.6M | - | not tested: openpose-pim did not run |"
            ),
            "{text}"
        );
        let columns = |line: &&str| line.matches(" | ").count();
        let rows: Vec<&str> = text.lines().take(4).filter(|line| line.starts_with("| ")).collect();
        assert!(rows.len() == 3 && rows.iter().all(|row| columns(row) == header().len() - 1));
        Ok(())
    }
}
