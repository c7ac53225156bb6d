//! Scores as a table.

use super::score::{Rate, Scores};
use crate::commands::gap::words::{percent, short};

/// The table, line by line.
pub(super) fn lines(scores: &Scores) -> Vec<String> {
    let mut lines = vec![format!("{:<44}{:>9}{:>8}   95 % interval", "", "cases", "share")];
    let mut row = |name: &str, rate: &Rate| lines.push(line(name, rate));
    row("visible singles named right", &scores.singles_right);
    for (strength, rate) in scores.by_strength.iter().filter(|(_, rate)| rate.n > 0) {
        row(&format!("  of strength {strength}"), rate);
    }
    row("wrong names, all cases", &scores.wrong_names);
    row("nulls with an effect named", &scores.nulls_named);
    row("nulls not called so", &scores.nulls_not_closed);
    row("parameters alone called so", &scores.parameters_right);
    row("pairs with both named", &scores.pairs_both);
    row("outside the catalogue, nothing named", &scores.outside_unnamed);
    row("numbers inside their 90 % interval", &scores.intervals_hold);
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), short);
    let share = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), percent);
    lines.push(format!(
        "{:<44}{:>17}",
        "error of numbers, median",
        share(scores.parameter_error_median)
    ));
    lines.push(format!(
        "{:<44}{:>17}",
        "share of the gap that is gone, median",
        number(scores.grr_median)
    ));
    lines.push(format!(
        "{:<44}{:>17}   {} at most",
        "seconds a case, median",
        number(scores.seconds_median),
        short(scores.seconds_most)
    ));
    lines.push("what was hidden: what was said".to_owned());
    for (hidden, said) in &scores.confusion {
        let said: Vec<String> = said.iter().map(|(what, n)| format!("{what} {n}")).collect();
        lines.push(format!("  {hidden}: {}", said.join(", ")));
    }
    lines
}

fn line(name: &str, rate: &Rate) -> String {
    let cases = format!("{}/{}", rate.of, rate.n);
    let share = rate.share.map_or_else(|| "-".to_owned(), percent);
    let interval = match rate.n {
        0 => String::new(),
        _ => format!("{} to {}", percent(rate.lo95), percent(rate.hi95)),
    };
    format!("{name:<44}{cases:>9}{share:>8}   {interval}")
}
