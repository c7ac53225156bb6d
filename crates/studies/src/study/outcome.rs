//! Means of all rows over seeds, with intervals, and published findings compared with them: as JSON and as tables.

use std::collections::BTreeMap;

use evpose_cli::tasks::Metric;
use evpose_core::stats::interval::{Interval, t_interval};
use evpose_report::format::with_interval_or_dash;
use serde::Serialize;

use super::{StudyTable, mean_curve, strings};

/// A measure of a trial; none where it has no value.
pub(crate) struct Measure<T> {
    pub(crate) metric: Metric,
    pub(crate) value: fn(&T) -> Option<f64>,
}

/// A measure: key, heading, digits, and whether smaller values are better.
pub(crate) const fn measure<T>(
    (key, heading, digits, is_error): (&'static str, &'static str, usize, bool),
    value: fn(&T) -> Option<f64>,
) -> Measure<T> {
    Measure { metric: Metric { key, heading, digits, is_error }, value }
}

/// A trial as tables see it.
pub(crate) trait Measured: Serialize + Sized + 'static {
    /// Columns of the table.
    const MEASURES: &'static [Measure<Self>];

    /// Processor or device that it was timed on, if it was: speeds of two cannot be compared.
    fn timed_on(&self) -> String;

    /// Shares of correct points over a threshold, by name.
    fn curves(&self) -> Vec<(&'static str, &[f64])>;
}

/// A row as tables see it.
pub(crate) trait StudyRow: Serialize {
    /// Name on the command line.
    fn name(&self) -> &'static str;

    /// Description in one line.
    fn about(&self) -> &'static str;

    /// Further cells, with their headings.
    fn cells(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Why it did not run, and how to make it.
    fn missing(&self) -> Option<&str> {
        None
    }
}

/// Difference of areas under the curve below which two rows count as comparable. The publication
/// gives no number; this one is ours.
const COMPARABLE_AUC: f64 = 0.02;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Relation {
    Worse,
    /// Its poses are about as good.
    Comparable,
    /// It predicts fewer poses per second.
    Slower,
}

/// Outcome of the test of a published statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// The whole interval agrees with the statement.
    Found,
    /// The interval allows both.
    WithinNoise,
    /// The whole interval contradicts the statement.
    Reversed,
    OneSeed,
    /// The two were timed on different machines or devices.
    OtherMachines,
}

impl Relation {
    /// In front of the other row's name.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Worse => "worse than",
            Self::Comparable => "comparable to",
            Self::Slower => "slower than",
        }
    }

    /// The verdict from the difference "row minus other row" of something that is good if large.
    pub(crate) fn verdict(self, difference: &Interval) -> Verdict {
        let (Some(low), Some(high)) = (difference.low, difference.high) else {
            return Verdict::OneSeed;
        };
        // An interval that crosses a limit decides nothing.
        let (agrees, contradicts) = match self {
            Self::Worse | Self::Slower => (high < 0.0, low > 0.0),
            Self::Comparable => (
                low > -COMPARABLE_AUC && high < COMPARABLE_AUC,
                high < -COMPARABLE_AUC || low > COMPARABLE_AUC,
            ),
        };
        match (agrees, contradicts) {
            (true, _) => Verdict::Found,
            (_, true) => Verdict::Reversed,
            _ => Verdict::WithinNoise,
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Found => "found",
            Self::WithinNoise => "within noise",
            Self::Reversed => "reversed",
            Self::OneSeed => "one seed",
            Self::OtherMachines => "timed on different machines",
        })
    }
}

/// A published statement about two rows.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Finding {
    pub(crate) row: &'static str,
    pub(crate) relation: Relation,
    pub(crate) than: &'static str,
    pub(crate) measure: &'static str,
    /// The statement, in full.
    pub(crate) published: String,
}

#[derive(Debug, Serialize)]
pub(crate) struct TestedFinding {
    #[serde(flatten)]
    pub(crate) finding: Finding,
    /// The row minus the other, seed by seed; none if one of them has no such value.
    pub(crate) difference: Option<Interval>,
    pub(crate) verdict: Option<Verdict>,
}

/// Content of the JSON file of a study.
#[derive(Debug, Serialize)]
pub(crate) struct Outcome<R, T> {
    pub(crate) seeds: Vec<u64>,
    /// Data that rows were evaluated on, in words.
    pub(crate) data: String,
    /// Programs and machines of the trials: more than one if the study was continued elsewhere.
    pub(crate) machines: Vec<String>,
    pub(crate) rows: Vec<RowOutcome<R, T>>,
    pub(crate) findings: Vec<TestedFinding>,
}

/// A row with its means over seeds.
#[derive(Debug, Serialize)]
pub(crate) struct RowOutcome<R, T> {
    #[serde(flatten)]
    pub(crate) row: R,
    /// By the key of the measure; those that all of its trials have.
    pub(crate) means: BTreeMap<&'static str, Interval>,
    #[serde(flatten)]
    pub(crate) curves: BTreeMap<&'static str, Vec<f64>>,
    per_seed: Vec<T>,
}

impl<R: StudyRow, T: Measured> Outcome<R, T> {
    /// The outcome of rows with their trials, in the order of the seeds.
    pub(crate) fn new(
        seeds: &[u64],
        data: String,
        rows: Vec<(R, Vec<T>)>,
        findings: Vec<Finding>,
    ) -> Self {
        let mut machines: Vec<String> =
            rows.iter().flat_map(|(_, trials)| trials).map(T::timed_on).collect();
        // Rows for which nothing was timed are of no machine.
        machines.retain(|machine| !machine.is_empty());
        machines.sort();
        machines.dedup();
        let rows: Vec<RowOutcome<R, T>> =
            rows.into_iter().map(|(row, trials)| RowOutcome::new(row, trials)).collect();
        let findings = findings.into_iter().map(|finding| tested(finding, &rows)).collect();
        Self { seeds: seeds.to_vec(), data, machines, rows, findings }
    }

    /// The table of all rows that ran; `first` is the heading of their names.
    pub(crate) fn all_rows(&self, first: &str, note: &str) -> StudyTable {
        let ran: Vec<_> = self.rows.iter().filter(|row| !row.per_seed.is_empty()).collect();
        let measures = T::MEASURES.iter().map(|measure| measure.metric);
        let others = ran.first().map_or_else(Vec::new, |row| row.row.cells());
        let columns = measures.clone().map(|m| m.heading).chain(others.iter().map(|cell| cell.0));
        let cells = |row: &&RowOutcome<R, T>| {
            let mut cells = strings([row.row.name()]);
            cells.extend(measures.clone().map(|m| cell(row.means.get(m.key), m.digits)));
            cells.extend(row.row.cells().into_iter().map(|cell| cell.1));
            cells
        };
        let columns = [first].into_iter().chain(columns);
        StudyTable::new("All rows", columns, ran.iter().map(cells), note)
    }

    /// Rows that did not run, and how to make them.
    pub(crate) fn missing_rows(&self) -> StudyTable {
        let row = |row: &RowOutcome<R, T>| Some(strings([row.row.name(), row.row.missing()?]));
        let (rows, note) = (self.rows.iter().filter_map(row), "No figure here stands for them.");
        StudyTable::new("Rows that did not run", ["row", "reason"], rows, note)
    }

    pub(crate) fn all_findings(&self, note: &str) -> StudyTable {
        let has_run = |name: &str| {
            self.rows.iter().any(|row| row.row.name() == name && !row.per_seed.is_empty())
        };
        let row = |tested: &TestedFinding| {
            let Finding { row, relation, than, measure, published } = &tested.finding;
            let verdict =
                match (tested.verdict, [*row, *than].into_iter().find(|name| !has_run(name))) {
                    (Some(verdict), _) => verdict.to_string(),
                    (None, Some(name)) => format!("not tested: {name} did not run"),
                    (None, None) => "not tested: nothing was measured".to_owned(),
                };
            let metric = metric::<T>(measure);
            let (heading, digits) = metric.map_or((*measure, 3), |m| (m.heading, m.digits));
            let difference = with_interval_or_dash(tested.difference.as_ref(), digits);
            let expected = format!("{} {than}", relation.words());
            strings([*row, &expected, heading, &difference, &verdict, published])
        };
        let columns = ["row", "expected", "measure", "difference", "here", "published"];
        StudyTable::new("Published findings", columns, self.findings.iter().map(row), note)
    }

    /// Descriptions of the rows, a line each.
    pub(crate) fn descriptions(&self) -> String {
        self.rows.iter().map(|row| format!("{}: {}\n", row.row.name(), row.row.about())).collect()
    }
}

impl<R: StudyRow, T: Measured> RowOutcome<R, T> {
    fn new(row: R, per_seed: Vec<T>) -> Self {
        let mean = |measure: &Measure<T>| {
            // A measure that one trial lacks has no mean over seeds.
            let values: Option<Vec<f64>> = per_seed.iter().map(measure.value).collect();
            Some((measure.metric.key, t_interval(&values?)?))
        };
        let names = per_seed.first().map_or_else(Vec::new, T::curves).into_iter().enumerate();
        let curve = |index: usize| mean_curve(per_seed.iter().map(|trial| trial.curves()[index].1));
        let curves = names.map(|(index, (name, _))| (name, curve(index))).collect();
        Self { row, means: T::MEASURES.iter().filter_map(mean).collect(), curves, per_seed }
    }
}

/// A mean in a table; counts that are the same under all seeds have no interval.
fn cell(mean: Option<&Interval>, digits: usize) -> String {
    let is_count = |mean: &&Interval| digits == 0 && mean.high == Some(mean.estimate);
    let count = mean.filter(is_count).map(|mean| format!("{:.0}", mean.estimate));
    count.unwrap_or_else(|| with_interval_or_dash(mean, digits))
}

pub(crate) fn metric<T: Measured>(key: &str) -> Option<Metric> {
    T::MEASURES.iter().map(|measure| measure.metric).find(|metric| metric.key == key)
}

/// Tests a finding, seed by seed, so that effects of the data of a seed on both rows cancel.
fn tested<R: StudyRow, T: Measured>(finding: Finding, rows: &[RowOutcome<R, T>]) -> TestedFinding {
    let trials = |name: &str| {
        rows.iter().find(|row| row.row.name() == name).map_or(&[][..], |row| &row.per_seed[..])
    };
    let (here, there) = (trials(finding.row), trials(finding.than));
    let measure = T::MEASURES.iter().find(|measure| measure.metric.key == finding.measure);
    let difference = measure.and_then(|measure| {
        let pairs = here.iter().zip(there);
        // A seed without a value leaves no mean: that of the others would be of a selection.
        let less = |(a, b): (&T, &T)| Some((measure.value)(a)? - (measure.value)(b)?);
        t_interval(&pairs.map(less).collect::<Option<Vec<f64>>>()?)
    });
    // Times of other machines or devices cannot be compared, accuracies can.
    let is_as_fast = here.iter().zip(there).all(|(a, b)| a.timed_on() == b.timed_on());
    let verdict = measure.zip(difference).map(|(measure, difference)| match finding.relation {
        Relation::Slower if !is_as_fast => Verdict::OtherMachines,
        relation => verdict(relation, measure.metric, &difference),
    });
    TestedFinding { finding, difference, verdict }
}

/// The verdict from the difference of a metric, the row minus the other.
pub(crate) fn verdict(relation: Relation, metric: Metric, difference: &Interval) -> Verdict {
    if !metric.is_error {
        return relation.verdict(difference);
    }
    let minus = |value: Option<f64>| value.map(|value| -value);
    // An upper bound is a lower one when it is negated.
    let (low, high) = (minus(difference.high), minus(difference.low));
    relation.verdict(&Interval { estimate: -difference.estimate, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Score {
        auc: f64,
        speed: Option<f64>,
        machine: &'static str,
        curve: [f64; 2],
    }

    impl Measured for Score {
        const MEASURES: &'static [Measure<Self>] = &[
            measure(("auc", "AUC", 3, false), |score| Some(score.auc)),
            measure(("error", "error", 1, true), |score| Some(1.0 - score.auc)),
            measure(("speed", "poses/s", 0, false), |score| score.speed),
        ];

        fn timed_on(&self) -> String {
            self.machine.to_owned()
        }

        fn curves(&self) -> Vec<(&'static str, &[f64])> {
            vec![("curve", &self.curve[..])]
        }
    }

    #[derive(Serialize)]
    struct Row(&'static str);

    impl StudyRow for Row {
        fn name(&self) -> &'static str {
            self.0
        }

        fn about(&self) -> &'static str {
            "a row"
        }

        fn missing(&self) -> Option<&str> {
            (self.0 == "missing").then_some("give a file")
        }
    }

    fn scores(auc: &[f64], speed: Option<f64>) -> Vec<Score> {
        auc.iter().map(|&auc| Score { auc, speed, machine: "one", curve: [0.0, auc] }).collect()
    }

    fn outcome(rows: Vec<(&'static str, Vec<Score>)>) -> Outcome<Row, Score> {
        let finding = |row, relation, measure| Finding {
            row,
            relation,
            than: "full",
            measure,
            published: "it is worse".to_owned(),
        };
        let findings = vec![
            finding("a", Relation::Worse, "auc"),
            finding("a", Relation::Worse, "error"),
            finding("a", Relation::Slower, "speed"),
            finding("missing", Relation::Comparable, "auc"),
        ];
        let rows = rows.into_iter().map(|(name, scores)| (Row(name), scores)).collect();
        Outcome::new(&[1, 2, 3], "people".to_owned(), rows, findings)
    }

    fn verdicts(outcome: &Outcome<Row, Score>) -> Vec<Option<Verdict>> {
        outcome.findings.iter().map(|finding| finding.verdict).collect()
    }

    #[test]
    fn differences_are_taken_seed_by_seed_and_a_larger_error_is_worse() {
        // Seeds differ by far more than rows: unpaired, nothing could be concluded.
        let full = || ("full", scores(&[0.30, 0.50, 0.70], Some(900.0)));
        let of = |auc: &[f64], speed| {
            let rows = vec![full(), ("a", scores(auc, speed)), ("missing", Vec::new())];
            verdicts(&outcome(rows))
        };
        let (found, reversed) = (Some(Verdict::Found), Some(Verdict::Reversed));
        assert_eq!(of(&[0.28, 0.48, 0.68], Some(400.0)), [found, found, found, None]);
        assert_eq!(of(&[0.32, 0.52, 0.72], None), [reversed, reversed, None, None]);
        assert_eq!(of(&[0.33, 0.47, 0.70], None)[0], Some(Verdict::WithinNoise));
        // One seed decides nothing, and a row that did not run less.
        let rows = vec![("full", scores(&[0.3], None)), ("a", scores(&[0.2], None))];
        assert_eq!(verdicts(&outcome(rows))[..2], [Some(Verdict::OneSeed); 2]);
        // Speeds of two machines are not compared, and both are named.
        let mut elsewhere = scores(&[0.2, 0.3, 0.4], Some(400.0));
        elsewhere[1].machine = "another";
        let outcome = outcome(vec![full(), ("a", elsewhere)]);
        assert_eq!(
            (outcome.machines.len(), verdicts(&outcome)[2]),
            (2, Some(Verdict::OtherMachines))
        );
    }

    #[test]
    fn tables_have_a_row_for_each_that_ran_and_say_why_others_did_not() {
        let a = scores(&[0.4, 0.5, 0.6], None);
        let full = scores(&[0.5, 0.6, 0.7], Some(900.0));
        let outcome = outcome(vec![("full", full), ("a", a), ("missing", Vec::new())]);
        let table = outcome.all_rows("row", "A note.");
        assert_eq!(table.columns, ["row", "AUC", "error", "poses/s"]);
        assert_eq!(table.rows[0], ["full", "0.600 ± 0.248", "0.4 ± 0.2", "900"]);
        assert_eq!((table.rows.len(), table.rows[1][3].as_str()), (2, "-"));
        assert_eq!(outcome.missing_rows().rows, [["missing", "give a file"]]);
        let findings = outcome.all_findings("Published.").rows;
        let found = ["a", "worse than full", "AUC", "-0.100 ± 0.000", "found", "it is worse"];
        assert_eq!(findings[0], found);
        assert_eq!(findings[3][4], "not tested: missing did not run");
        assert_eq!(outcome.rows[1].curves["curve"], [0.0, 0.5]);
    }

    fn of_interval(relation: Relation, low: f64, high: f64) -> Verdict {
        let estimate = (low + high) / 2.0;
        relation.verdict(&Interval { estimate, low: Some(low), high: Some(high) })
    }

    #[test]
    fn an_ordering_is_found_only_where_the_whole_interval_agrees() {
        for relation in [Relation::Worse, Relation::Slower] {
            assert_eq!(of_interval(relation, -0.3, -0.1), Verdict::Found);
            assert_eq!(of_interval(relation, -0.3, 0.0), Verdict::WithinNoise);
            assert_eq!(of_interval(relation, -0.3, 0.1), Verdict::WithinNoise);
            assert_eq!(of_interval(relation, 0.1, 0.3), Verdict::Reversed);
        }
    }

    #[test]
    fn rows_are_comparable_where_no_difference_beyond_the_margin_is_possible() {
        let comparable = |low, high| of_interval(Relation::Comparable, low, high);
        assert_eq!(comparable(-0.01, 0.015), Verdict::Found);
        assert_eq!(comparable(-0.01, 0.03), Verdict::WithinNoise, "too few seeds to decide");
        assert_eq!(comparable(-0.2, -0.03), Verdict::Reversed);
        assert_eq!(comparable(0.03, 0.2), Verdict::Reversed);
    }
}
