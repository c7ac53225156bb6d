//! How far a training is, and how long it will take.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use evpose_train::ProgressCallback;
use indicatif::ProgressBar;

use evpose_app::progress::{bar, say};

/// After this long, speed is known well enough for an estimate.
const AFTER: Duration = Duration::from_secs(5);

/// A bar for a training, and who moves it; a line with an estimate comes after the first seconds,
/// also where there is no terminal for a bar.
pub(super) fn training(row: &str, seeds: usize) -> (ProgressBar, ProgressCallback) {
    let progress = bar(row, 0, "windows");
    let (began, said) = (OnceLock::new(), AtomicBool::new(false));
    let moved = progress.clone();
    let callback = ProgressCallback::new(move |progress| {
        let &(start, first) = began.get_or_init(|| {
            moved.set_length(progress.total_samples);
            moved.set_position(progress.samples);
            // What an earlier process did says nothing of the speed of this one.
            moved.reset_eta();
            (Instant::now(), progress.samples)
        });
        moved.set_position(progress.samples);
        let elapsed = start.elapsed();
        if elapsed >= AFTER && !said.swap(true, Ordering::Relaxed) {
            let per_second = (progress.samples - first) as f64 / elapsed.as_secs_f64();
            let left = progress.total_samples - progress.samples;
            moved.suspend(|| say(estimate(per_second, left, progress.total_samples, seeds)));
        }
    });
    (progress, callback)
}

/// The line: `left` of `of` windows to go in this training of one row.
fn estimate(per_second: f64, left: u64, of: u64, seeds: usize) -> String {
    let minutes = |windows: u64| windows as f64 / per_second / 60.0;
    format!(
        "    {per_second:.0} windows/s: {:.1} min to go, {:.1} min for the {seeds} trainings of \
         this row",
        minutes(left),
        minutes(of * seeds as u64)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_what_is_left_over_the_speed() {
        let line = estimate(1000.0, 30_000, 120_000, 3);
        assert_eq!(
            line,
            "    1000 windows/s: 0.5 min to go, 6.0 min for the 3 trainings of this row"
        );
    }
}
