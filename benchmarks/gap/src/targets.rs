//! Targets of the benchmark, and whether they are reached.

use gapbench_pixel::Tier;
use serde::Serialize;

use Target::{AtLeast, AtMost, Within};

use super::identification;
use super::score::Scores;
use super::stats::{Median, Rate, Stated};

/// A figure is to be at least, at most, or between.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Target {
    AtLeast(f64),
    AtMost(f64),
    Within(f64, f64),
}

impl Target {
    pub(super) fn is_met(self, value: f64) -> bool {
        match self {
            Self::AtLeast(least) => value >= least,
            Self::AtMost(most) => value <= most,
            Self::Within(low, high) => (low..=high).contains(&value),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Unit {
    Share,
    Number,
    Seconds,
}

/// A figure beside what is required and what is hoped for.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Headline {
    pub(super) name: &'static str,
    pub(super) unit: Unit,
    /// None where no case says anything of it.
    pub(super) value: Option<f64>,
    /// The interval of 95 %; none where there is none.
    pub(super) lo95: Option<f64>,
    pub(super) hi95: Option<f64>,
    /// How many of how many, or of how many.
    pub(super) cases: String,
    /// None where nothing is required.
    pub(super) required: Option<Target>,
    pub(super) goal: Option<Target>,
    pub(super) note: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reached {
    Goal,
    Required,
    Missed,
    Unknown,
}

impl Headline {
    pub(super) fn reached(&self) -> Reached {
        let (Some(value), Some(required)) = (self.value, self.required) else {
            return Reached::Unknown;
        };
        match self.goal {
            Some(goal) if goal.is_met(value) => Reached::Goal,
            _ if required.is_met(value) => Reached::Required,
            _ => Reached::Missed,
        }
    }

    /// A figure of which nothing is required, or nothing was stored.
    pub(super) fn new(name: &'static str, unit: Unit, value: Option<f64>, cases: usize) -> Self {
        let cases = cases.to_string();
        let (lo95, hi95, required, goal) = (None, None, None, None);
        Self { name, unit, value, lo95, hi95, cases, required, goal, note: String::new() }
    }

    pub(super) fn of_rate(name: &'static str, rate: &Rate) -> Self {
        let is_known = rate.n > 0;
        Self {
            name,
            unit: Unit::Share,
            value: rate.share,
            lo95: is_known.then_some(rate.lo95),
            hi95: is_known.then_some(rate.hi95),
            cases: format!("{}/{}", rate.of, rate.n),
            required: None,
            goal: None,
            note: String::new(),
        }
    }

    pub(super) fn of_median(name: &'static str, unit: Unit, median: Option<Median>) -> Self {
        Self {
            lo95: median.map(|median| median.lo95),
            hi95: median.map(|median| median.hi95),
            ..Self::new(
                name,
                unit,
                median.map(|median| median.value),
                median.map_or(0, |median| median.n),
            )
        }
    }

    /// With what is required and what is hoped for.
    pub(super) fn with_targets(self, required: Target, goal: Target) -> Self {
        Self { required: Some(required), goal: Some(goal), ..self }
    }

    pub(super) fn noted(self, note: String) -> Self {
        Self { note, ..self }
    }
}

/// All targets with the figures of `scores`.
pub(super) fn headlines(scores: &Scores) -> Vec<Headline> {
    let mut all = match scores.tier {
        Tier::Home => identification::home(scores),
        Tier::Plain => identification::plain(scores),
    };
    all.extend(identification::all(scores));
    all.extend(estimation(scores));
    all.push(match scores.tier {
        Tier::Home => seconds_median(scores),
        Tier::Plain => seconds_mean(scores),
    });
    if let Some(own) = &scores.own {
        let note = format!("uniform: p = {:.2}", own.uniformity.p);
        let name = "runs of our own model, p at most .05";
        let row = Headline::of_rate(name, &own.significant).noted(note);
        all.push(row.with_targets(Within(0.02, 0.08), Within(0.02, 0.08)));
    }
    all
}

fn seconds_mean(scores: &Scores) -> Headline {
    let value = (scores.cases > 0).then_some(scores.seconds_mean);
    Headline::new("seconds a case on 2 cores, mean", Unit::Seconds, value, scores.cases)
        .with_targets(AtMost(25.0), AtMost(25.0))
        .noted(format!(
            "median {:.1}, at most {:.1}",
            scores.seconds_median.unwrap_or(0.0),
            scores.seconds_most
        ))
}

fn seconds_median(scores: &Scores) -> Headline {
    let value = scores.seconds_median;
    Headline::new("seconds a case on 2 cores, median", Unit::Seconds, value, scores.cases)
        .with_targets(AtMost(60.0), AtMost(20.0))
        .noted(format!("mean {:.1}, at most {:.1}", scores.seconds_mean, scores.seconds_most))
}

/// Targets of estimation: errors of estimates, coverage of intervals, stated probabilities.
fn estimation(scores: &Scores) -> Vec<Headline> {
    let (required, goal) = match scores.tier {
        Tier::Home => (0.03, 0.01),
        Tier::Plain => (0.05, 0.04),
    };
    let first = scores.reliability.iter().map(|bin| bin.right.n).sum();
    vec![
        Headline::of_median("error of estimates, median", Unit::Share, scores.parameter_error)
            .with_targets(AtMost(required), AtMost(goal)),
        Headline::of_rate("estimates whose 90 % interval holds the truth", &scores.intervals_hold)
            .with_targets(Within(0.85, 0.95), Within(0.85, 0.95)),
        gap_closed(scores.grr),
        probabilities(scores.calibration_error, first, &scores.stated),
    ]
}

/// The gap that is closed, of cases whose truth was named.
pub(super) fn gap_closed(median: Option<Median>) -> Headline {
    Headline::of_median("gap closed (fraction), median", Unit::Number, median)
        .with_targets(AtLeast(0.85), AtLeast(0.90))
}

/// How far stated probabilities of the `first` names of cases are from shares; beside it what was
/// stated of all names.
pub(super) fn probabilities(error: Option<f64>, first: usize, stated: &Stated) -> Headline {
    let row = Headline::new("error of stated probabilities", Unit::Number, error, first)
        .with_targets(AtMost(0.05), AtMost(0.05));
    let Some(mean) = stated.mean else { return row };
    let right = &stated.right;
    row.noted(format!(
        "of the first name of each case; of all, {mean:.3} stated and {}/{} right ({})",
        right.of,
        right.n,
        if stated.holds() { "within its interval" } else { "outside its interval" }
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_at_its_target_meets_it() {
        assert!(AtLeast(0.9).is_met(0.9) && !AtLeast(0.9).is_met(0.899));
        assert!(AtMost(0.02).is_met(0.02) && !AtMost(0.02).is_met(0.021));
        assert!(Within(0.02, 0.08).is_met(0.08) && !Within(0.02, 0.08).is_met(0.0));
    }

    #[test]
    fn goals_and_requirements_are_distinguished() {
        let of = |right: usize, n: usize| {
            let rate = Rate::from_outcomes((0..n).map(|i| i < right));
            let row = Headline::of_rate("name", &rate);
            row.with_targets(AtLeast(0.9), AtLeast(0.97)).reached()
        };
        assert_eq!(of(98, 100), Reached::Goal);
        assert_eq!(of(92, 100), Reached::Required);
        assert_eq!(of(80, 100), Reached::Missed);
        assert_eq!(of(0, 0), Reached::Unknown);
        let rate = Rate::from_outcomes([true]);
        assert_eq!(Headline::of_rate("name", &rate).reached(), Reached::Unknown);
    }
}
