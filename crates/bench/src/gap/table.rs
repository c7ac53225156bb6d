//! Scores as a table of the terminal.

use super::group::Group;
use super::part::PlanId;
use super::score::Scores;
use super::stats::Rate;
use super::targets::{Headline, Reached, Target, Unit};
use evpose_report::format::short;

/// The table, line by line.
pub(super) fn lines(scores: &Scores) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<40}{:>9}{:>8}  {:<17}{:>10}{:>10}  ",
        "", "cases", "", "95 % interval", "required", "goal"
    )];
    lines.extend(scores.headlines.iter().map(line));
    lines.extend(groups(scores));
    lines.push(format!(
        "{} cases of plan {} ({}), {} went wrong; programs {}",
        scores.cases,
        scores.plan,
        PlanId { seed: scores.plan, tier: scores.tier }.tier_name(),
        scores.misses.len(),
        scores.commits.join(", ")
    ));
    lines
}

/// Recall, precision, exact sets, wrong names and times of every group.
fn groups(scores: &Scores) -> Vec<String> {
    let header = format!(
        "{:<24}{:>6}{:>12}{:>12}{:>12}{:>12}{:>10}",
        "", "cases", "recall", "precision", "as expected", "wrong name", "median s"
    );
    let count = |rate: &Rate| format!("{}/{}", rate.of, rate.n);
    let line = |group: &Group| {
        let Group { recall, precision, exact, wrong, .. } = group;
        format!(
            "{:<24}{:>6}{:>12}{:>12}{:>12}{:>12}{:>10}",
            group.name,
            group.cases,
            count(recall),
            count(precision),
            count(exact),
            count(wrong),
            group.seconds.map_or_else(|| "-".to_owned(), |seconds| short(seconds.value))
        )
    };
    std::iter::once(header).chain(scores.groups.iter().map(line)).collect()
}

fn line(headline: &Headline) -> String {
    let value = headline.value.map_or_else(|| "-".to_owned(), |v| figure(headline.unit, v));
    let note = match headline.note.as_str() {
        "" => String::new(),
        note => format!(" ({note})"),
    };
    let line = format!(
        "{:<40}{:>9}{value:>8}  {:<17}{:>10}{:>10}  {}{note}",
        headline.name,
        headline.cases,
        interval(headline),
        target(headline.unit, headline.required),
        target(headline.unit, headline.goal),
        word(headline.reached())
    );
    line.trim_end().to_owned()
}

/// A figure in its unit.
pub(super) fn figure(unit: Unit, value: f64) -> String {
    match unit {
        // Targets of one in a hundred want a decimal.
        Unit::Share => format!("{}%", (1e3 * value).round() / 10.0),
        Unit::Number => short(value),
        Unit::Seconds => format!("{} s", short(value)),
    }
}

/// An interval in the unit of a figure; nothing where there is none.
pub(super) fn interval(headline: &Headline) -> String {
    let (Some(low), Some(high)) = (headline.lo95, headline.hi95) else { return String::new() };
    format!("{} to {}", figure(headline.unit, low), figure(headline.unit, high))
}

/// A target in the unit of its figure.
pub(super) fn target(unit: Unit, target: Target) -> String {
    match target {
        Target::AtLeast(least) => format!(">= {}", figure(unit, least)),
        Target::AtMost(most) => format!("<= {}", figure(unit, most)),
        Target::Within(low, high) => {
            format!("{} to {}", figure(unit, low).trim_end_matches('%'), figure(unit, high))
        }
    }
}

/// Whether a target is reached, in a word or two.
pub(super) fn word(reached: Reached) -> &'static str {
    match reached {
        Reached::Goal => "goal met",
        Reached::Required => "met",
        Reached::Missed => "MISSED",
        Reached::Unknown => "",
    }
}
