//! Progress bars and lines on the terminal. Progress goes to standard error, results to standard
//! output.

use std::fmt::Display;
use std::io::{IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::{Duration, Instant};

use evpose_train::ProgressCallback;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, TermLike};

/// Time between lines of progress where standard error is no terminal: often enough to see that work goes on,
/// rare enough for a log.
const EVERY: Duration = Duration::from_secs(10);

/// A progress bar over `total` units with the name `unit`; where standard error is no terminal, a line every ten
/// seconds.
pub fn bar(what: &str, total: u64, unit: &str) -> ProgressBar {
    let template = format!(
        "{{prefix:>12}} [{{bar:34}}] {{human_pos}}/{{human_len}} {unit}  {{per_sec}}  {{eta}} left"
    );
    // Without a total nothing can be said of what is left.
    let line = match total {
        0 => format!("{{prefix}}: {{human_pos}} {unit}, {{per_sec}}"),
        _ => {
            format!("{{prefix}}: {{human_pos}} of {{human_len}} {unit}, {{per_sec}}, {{eta}} left")
        }
    };
    let bar = drawn(ProgressBar::new(total), &template, &line);
    bar.with_prefix(what.to_owned())
}

/// A bar by `template` on a terminal, and by `line` elsewhere.
fn drawn(bar: ProgressBar, template: &str, line: &str) -> ProgressBar {
    let is_terminal = std::io::stderr().is_terminal();
    if !is_terminal {
        let log = Box::new(LogLines::new(EVERY));
        // Once a second is often enough to be up to date when a line is due.
        bar.set_draw_target(ProgressDrawTarget::term_like_with_hz(log, 1));
    }
    // The templates are valid constants, so that the fallback is never used.
    let style = ProgressStyle::with_template(if is_terminal { template } else { line });
    bar.with_style(style.map_or_else(|_| ProgressStyle::default_bar(), |s| s.progress_chars("=> ")))
}

/// A draw target that is a log: what was drawn last becomes a line now and then, and nothing is taken back.
#[derive(Debug)]
struct LogLines {
    every: Duration,
    state: Mutex<LogState>,
}

#[derive(Debug)]
struct LogState {
    text: String,
    last: Instant,
    /// Lines so far, for tests.
    #[cfg(test)]
    lines: Vec<String>,
}

impl LogLines {
    fn new(every: Duration) -> Self {
        let state = LogState {
            text: String::new(),
            last: Instant::now(),
            #[cfg(test)]
            lines: Vec::new(),
        };
        Self { every, state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, LogState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl TermLike for LogLines {
    fn width(&self) -> u16 {
        160
    }

    fn move_cursor_up(&self, _: usize) -> std::io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> std::io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> std::io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> std::io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> std::io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> std::io::Result<()> {
        self.state().text.push_str(text);
        Ok(())
    }

    fn clear_line(&self) -> std::io::Result<()> {
        self.state().text.clear();
        Ok(())
    }

    fn flush(&self) -> std::io::Result<()> {
        let mut state = self.state();
        // What is drawn while no line is due would be out of date in the next one.
        let text = std::mem::take(&mut state.text);
        if state.last.elapsed() >= self.every && !text.trim().is_empty() {
            state.last = Instant::now();
            note(text.trim());
            #[cfg(test)]
            state.lines.push(text.trim().to_owned());
        }
        Ok(())
    }
}

/// A progress bar of a training with the name `label`, and the callback that advances it.
pub fn training_bar(label: &str) -> (ProgressBar, ProgressCallback) {
    // Its total is that of the first report.
    let progress = bar(label, 1, "samples");
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

/// A status line; where standard error is no terminal, a line of it every ten seconds.
pub fn spinner() -> ProgressBar {
    let spinner = drawn(ProgressBar::new_spinner(), "{spinner} {msg}", "{msg} ({elapsed})");
    // Messages come seldom, and without ticks the spinner would stand still.
    spinner.enable_steady_tick(Duration::from_millis(100));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_there_is_no_terminal_a_line_comes_now_and_then() {
        let target = |every| Box::leak(Box::new(LogLines::new(every))) as &LogLines;
        let draw = |log: &LogLines, text: &str| {
            assert!(log.clear_line().is_ok() && log.write_str(text).is_ok() && log.flush().is_ok());
        };
        let often = target(Duration::ZERO);
        for text in ["rendering: 4 of 40 stills ", "", "rendering: 5 of 40 stills"] {
            draw(often, text);
        }
        let lines = often.state().lines.clone();
        assert_eq!(lines, ["rendering: 4 of 40 stills", "rendering: 5 of 40 stills"]);
        let seldom = target(Duration::from_secs(3600));
        (0..100).for_each(|_| draw(seldom, "inferring"));
        assert!(seldom.state().lines.is_empty());
    }
}
