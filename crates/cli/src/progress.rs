//! Progress bars and lines on the terminal. Progress goes to standard error, results to standard
//! output.

use std::fmt::Display;
use std::io::{IsTerminal as _, Write as _};
use std::sync::Once;
use std::sync::atomic::{AtomicU64, Ordering};

use evpose_train::ProgressCallback;
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

/// A progress bar of a training with the name `label`, and the callback that advances it.
pub fn training_bar(label: &str) -> (ProgressBar, ProgressCallback) {
    let progress = bar(label, 0, "samples");
    let (handle, began) = (progress.clone(), Once::new());
    let callback = ProgressCallback::new(move |done| {
        began.call_once(|| {
            handle.set_length(done.total_samples);
            handle.set_position(done.samples);
            // Samples of an earlier process carry no information about the speed of this one.
            handle.reset_eta();
        });
        handle.set_position(done.samples);
    });
    (progress, callback)
}

/// A status line; hidden unless standard error is a terminal.
pub fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    spinner
}

/// Prints a line of results to standard output. Ends the program if that cannot be written.
pub fn say(line: impl Display) {
    if let Err(error) = writeln!(std::io::stdout(), "{line}") {
        say_unwritten(&error);
        std::process::exit(1);
    }
}

/// Says on standard error why standard output cannot be written: not that its reader has gone, as with `| head`.
pub fn say_unwritten(error: &std::io::Error) {
    if error.kind() != std::io::ErrorKind::BrokenPipe {
        note(format!("evpose: standard output: {error}"));
    }
}

/// Prints a line of progress to standard error, so that standard output holds results alone.
pub fn note(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Progress of work that takes minutes: a bar, or a line at each tenth where standard error is no
/// terminal and a bar would be hidden.
pub struct LongProgress {
    bar: ProgressBar,
    label: String,
    unit: &'static str,
    total: u64,
    done: AtomicU64,
    has_lines: bool,
}

impl LongProgress {
    /// Progress over `total` units.
    pub fn new(label: &str, total: u64, unit: &'static str) -> Self {
        let has_lines = !std::io::stderr().is_terminal();
        Self {
            bar: bar(label, total, unit),
            label: label.to_owned(),
            unit,
            total,
            done: AtomicU64::new(0),
            has_lines,
        }
    }

    /// Adds units that are done, from any thread.
    pub fn inc(&self, count: u64) {
        self.bar.inc(count);
        let before = self.done.fetch_add(count, Ordering::Relaxed);
        if let Some(line) = self.line(before, before + count).filter(|_| self.has_lines) {
            note(line);
        }
    }

    /// The line when a tenth of the whole is passed on the way from `before` to `now`.
    fn line(&self, before: u64, now: u64) -> Option<String> {
        let tenths = |done: u64| (10 * done).checked_div(self.total).unwrap_or(0);
        (tenths(now) > tenths(before))
            .then(|| format!("{}: {now} of {} {}", self.label, self.total, self.unit))
    }

    /// Takes the bar away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_work_says_each_tenth_once() {
        let progress = LongProgress::new("rendering", 40, "stills");
        let lines: Vec<String> = (0..40).filter_map(|done| progress.line(done, done + 1)).collect();
        assert_eq!(lines.len(), 10);
        assert_eq!(
            (lines[0].as_str(), lines[9].as_str()),
            ("rendering: 4 of 40 stills", "rendering: 40 of 40 stills")
        );
        assert_eq!(LongProgress::new("reading", 0, "images").line(0, 1), None);
    }
}
