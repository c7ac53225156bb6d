//! Lines and progress bars. Progress and errors go to standard error, results to standard output.

use std::fmt::Display;
use std::io::Write as _;

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar over `total` units with the name `unit`; hidden unless standard error is a
/// terminal.
pub(crate) fn bar(what: &str, total: u64, unit: &str) -> ProgressBar {
    let template =
        format!("{{prefix:>14}} [{{bar:34}}] {{human_pos}}/{{human_len}} {unit}  {{eta}} left");
    // The template is a valid constant, so that the fallback is never used.
    let style = ProgressStyle::with_template(&template)
        .map_or_else(|_| ProgressStyle::default_bar(), |style| style.progress_chars("=> "));
    ProgressBar::new(total).with_style(style).with_prefix(what.to_owned())
}

/// Prints a line of results. Ends the program if the reader has gone, as with `| head`.
pub(crate) fn say(line: impl Display) {
    if writeln!(std::io::stdout(), "{line}").is_err() {
        std::process::exit(1);
    }
}

/// Prints a line of results above a bar, which is hidden and prints nothing without a terminal.
pub(crate) fn say_above(bar: &ProgressBar, line: impl Display) {
    if bar.is_hidden() {
        say(line);
    } else {
        bar.println(line.to_string());
    }
}

pub(crate) fn report_error(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "gapbench: {message}");
}
