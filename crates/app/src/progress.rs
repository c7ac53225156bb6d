//! Progress bars and lines on the terminal. Progress goes to standard error, results to standard output.

use std::fmt::Display;
use std::io::Write as _;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `total` units that are called `unit`; silent where standard error is no terminal.
pub fn bar(what: &str, total: u64, unit: &str) -> ProgressBar {
    let template = format!(
        "{{prefix:>12}} [{{bar:34}}] {{human_pos}}/{{human_len}} {unit}  {{per_sec}}  {{eta}} left"
    );
    // The template is ours and valid; the default bar is a fair stand-in if it ever is not.
    let style = ProgressStyle::with_template(&template)
        .map_or_else(|_| ProgressStyle::default_bar(), |style| style.progress_chars("=> "));
    ProgressBar::new(total).with_style(style).with_prefix(what.to_owned())
}

/// A line that says what is being done; silent where standard error is no terminal.
pub fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    spinner
}

/// A line of result. Where nobody reads it any more, as behind `| head`, the program ends.
pub fn say(line: impl Display) {
    if writeln!(std::io::stdout(), "{line}").is_err() {
        std::process::exit(1);
    }
}

/// A line about the work, on standard error: standard output may be what somebody reads on.
pub fn note(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
