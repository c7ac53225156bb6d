//! Scores as a table of the terminal.

use super::group::Group;
use super::part::tier_name;
use super::score::Scores;
use super::stats::Rate;
use super::targets::{Headline, Reached, Target, Unit};
use evpose_report::format::short;

pub(super) fn lines(scores: &Scores) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<46}{:>9}{:>8}  {:<17}{:>10}{:>10}  ",
        "", "cases", "", "95 % interval", "required", "goal"
    )];
    lines.extend(scores.headlines.iter().map(line));
    lines.extend(groups(scores));
    lines.push(format!(
        "{}, {} went wrong; programs {}",
        cases(scores),
        scores.misses.len(),
        scores.commits.join(", ")
    ));
    lines
}

pub(super) fn cases(scores: &Scores) -> String {
    let plans: Vec<String> = scores.plans.iter().map(u64::to_string).collect();
    let word = if plans.len() == 1 { "plan" } else { "plans" };
    let tier = tier_name(scores.tier);
    format!("{} cases of {word} {} ({tier})", scores.cases, plans.join(", "))
}

/// The scores as a table in Markdown, and those of the groups as another.
pub(super) fn markdown(scores: &Scores) -> String {
    let mut text = rows(&scores.headlines);
    text += "\n| hidden | cases | visible effects named | names right | conventions aside | \
             as expected | cases with a wrong name |\n|---|---|---|---|---|---|---|\n";
    for group in std::iter::once(&scores.all).chain(&scores.groups) {
        let Group { recall, precision, precision_of_hidden, exact, wrong, .. } = group;
        let rates = [recall, precision, precision_of_hidden, exact, wrong].map(rate).join(" | ");
        text += &format!("| {} | {} | {rates} |\n", group.name, group.cases);
    }
    text + &format!("\n{}; programs {}.\n", cases(scores), scores.commits.join(", "))
}

pub(super) fn rows(headlines: &[Headline]) -> String {
    let row = |headline: &Headline| {
        let measured = match headline.value {
            None => "-".to_owned(),
            Some(value) => {
                let value = spaced(&figure(headline.unit, value));
                // A share has its count before it, other figures the number of cases behind them.
                match headline.cases.contains('/') {
                    true => format!("{} ({value})", headline.cases),
                    false => format!("{value} (of {})", headline.cases),
                }
            }
        };
        let required = headline
            .required
            .map_or_else(|| "-".to_owned(), |required| spaced(&target(headline.unit, required)));
        let word = match headline.reached() {
            Reached::Missed => "**missed**",
            Reached::Goal | Reached::Required => "met",
            Reached::Unknown if headline.value.is_none() => "no figure",
            Reached::Unknown => "",
        };
        let words = [word, &headline.note].into_iter().filter(|words| !words.is_empty());
        let words = words.collect::<Vec<_>>().join("; ");
        let interval = spaced(&interval(headline));
        format!("| {} | {measured} | {interval} | {required} | {words} |\n", headline.name)
    };
    let rows: String = headlines.iter().map(row).collect();
    format!("| | measured | 95 % interval | required | |\n|---|---|---|---|---|\n{rows}")
}

/// Count, share and interval; nothing of no cases.
pub(super) fn rate(rate: &Rate) -> String {
    rate.share.map_or_else(String::new, |share| {
        let (low, high) = (percent(rate.lo95), percent(rate.hi95));
        format!(
            "{}/{} ({}, {} to {high})",
            rate.of,
            rate.n,
            percent(share),
            low.trim_end_matches(" %")
        )
    })
}

pub(super) fn percent(share: f64) -> String {
    spaced(&figure(Unit::Share, share))
}

/// A figure with a space before the sign of percent, as pages have it.
fn spaced(figure: &str) -> String {
    figure.replace('%', " %")
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
    let aim = |aim: Option<Target>| aim.map_or_else(String::new, |aim| target(headline.unit, aim));
    let line = format!(
        "{:<46}{:>9}{value:>8}  {:<17}{:>10}{:>10}  {}{note}",
        headline.name,
        headline.cases,
        interval(headline),
        aim(headline.required),
        aim(headline.goal),
        word(headline.reached())
    );
    line.trim_end().to_owned()
}

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

pub(super) fn target(unit: Unit, target: Target) -> String {
    match target {
        Target::AtLeast(least) => format!(">= {}", figure(unit, least)),
        Target::AtMost(most) => format!("<= {}", figure(unit, most)),
        Target::Within(low, high) => {
            format!("{} to {}", figure(unit, low).trim_end_matches('%'), figure(unit, high))
        }
    }
}

pub(super) fn word(reached: Reached) -> &'static str {
    match reached {
        Reached::Goal => "goal met",
        Reached::Required => "met",
        Reached::Missed => "MISSED",
        Reached::Unknown => "",
    }
}
