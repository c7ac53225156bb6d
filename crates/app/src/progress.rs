//! Progress bars and lines on the terminal. Progress goes to standard error, results to standard
//! output.

use std::fmt::Display;
use std::io::Write as _;

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar over `total` units with the name `unit`; hidden unless standard error is a
/// terminal.
pub fn bar(what: &str, total: u64, unit: &str) -> ProgressBar {
    let template = format!(
        "{{prefix:>12}} [{{bar:34}}] {{human_pos}}/{{human_len}} {unit}  {{per_sec}}  {{eta}} left"
    );
    // The template is a valid constant, so that the fallback is never used.
    let style = ProgressStyle::with_template(&template)
        .map_or_else(|_| ProgressStyle::default_bar(), |style| style.progress_chars("=> "));
    ProgressBar::new(total).with_style(style).with_prefix(what.to_owned())
}

/// A status line; hidden unless standard error is a terminal.
pub fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    spinner
}

/// Prints a line of results to standard output. Ends the program if the reader has gone, as with `|
/// head`.
pub fn say(line: impl Display) {
    if writeln!(std::io::stdout(), "{line}").is_err() {
        std::process::exit(1);
    }
}

/// Prints a line of progress to standard error, so that standard output holds results alone.
pub fn note(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
