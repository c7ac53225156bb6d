//! The test of a published statement about two rows.
//!
//! The verdict follows from the 95 % interval of the difference between the two rows, paired by
//! seed, so that effects of the data of a seed on both rows cancel.

use evpose_core::stats::interval::Interval;
use serde::Serialize;

/// Difference of areas under the curve below which two rows count as comparable. The publication
/// gives no number; this one is ours.
const COMPARABLE_AUC: f64 = 0.02;

/// Published order of two rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Finding {
    pub(crate) relation: Relation,
    /// Name of the other row.
    pub(crate) than: &'static str,
    /// The statement, in full.
    pub(crate) words: &'static str,
}

/// Published relation of a row to another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// Its poses are worse.
    Worse,
    /// Its poses are about as good.
    Comparable,
    /// It predicts fewer poses per second.
    Slower,
}

/// Outcome of the test of a published statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The whole interval agrees with the statement.
    Found,
    /// The interval allows both.
    WithinNoise,
    /// The whole interval contradicts the statement.
    Reversed,
    /// One seed has no interval.
    OneSeed,
    /// The two were timed on different machines or devices.
    OtherMachines,
}

impl Relation {
    /// In front of the other row's name.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Worse => "worse than",
            Self::Comparable => "comparable to",
            Self::Slower => "slower than",
        }
    }

    /// The verdict from the difference "row minus other row" of something that is good if large.
    #[must_use]
    pub fn verdict(self, difference: &Interval) -> Verdict {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(relation: Relation, low: f64, high: f64) -> Verdict {
        let estimate = (low + high) / 2.0;
        relation.verdict(&Interval { estimate, low: Some(low), high: Some(high) })
    }

    #[test]
    fn an_ordering_is_found_only_where_the_whole_interval_agrees() {
        for relation in [Relation::Worse, Relation::Slower] {
            assert_eq!(verdict(relation, -0.3, -0.1), Verdict::Found);
            assert_eq!(verdict(relation, -0.3, 0.0), Verdict::WithinNoise);
            assert_eq!(verdict(relation, -0.3, 0.1), Verdict::WithinNoise);
            assert_eq!(verdict(relation, 0.1, 0.3), Verdict::Reversed);
        }
    }

    #[test]
    fn rows_are_comparable_where_no_difference_beyond_the_margin_is_possible() {
        let comparable = |low, high| verdict(Relation::Comparable, low, high);
        assert_eq!(comparable(-0.01, 0.015), Verdict::Found);
        assert_eq!(comparable(-0.01, 0.03), Verdict::WithinNoise, "too few seeds to decide");
        assert_eq!(comparable(-0.2, -0.03), Verdict::Reversed);
        assert_eq!(comparable(0.03, 0.2), Verdict::Reversed);
    }

    #[test]
    fn one_seed_finds_nothing() {
        let difference = Interval { estimate: -1.0, low: None, high: None };
        assert_eq!(Relation::Worse.verdict(&difference), Verdict::OneSeed);
    }
}
