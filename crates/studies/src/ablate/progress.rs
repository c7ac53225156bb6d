//! Progress of a training, with an estimate of its duration.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use evpose_train::ProgressCallback;
use indicatif::ProgressBar;

use evpose_cli::progress::{bar, say};

/// Time after which the speed is known well enough for an estimate.
const ESTIMATE_AFTER: Duration = Duration::from_secs(5);

/// A progress bar of a training, and the callback that advances it. A line with an estimate of the
/// duration is printed after the first seconds, also without a terminal.
pub(super) fn training_bar(row: &str, seeds: usize) -> (ProgressBar, ProgressCallback) {
    let progress = bar(row, 0, "windows");
    // The callback comes from other threads.
    let (began, is_estimated) = (OnceLock::new(), AtomicBool::new(false));
    let bar_handle = progress.clone();
    let callback = ProgressCallback::new(move |done| {
        let &(start, first) = began.get_or_init(|| {
            bar_handle.set_length(done.total_samples);
            bar_handle.set_position(done.samples);
            // Samples of an earlier process carry no information about the speed of this one.
            bar_handle.reset_eta();
            (Instant::now(), done.samples)
        });
        bar_handle.set_position(done.samples);
        let elapsed = start.elapsed();
        if elapsed >= ESTIMATE_AFTER && !is_estimated.swap(true, Ordering::Relaxed) {
            let per_second = (done.samples - first) as f64 / elapsed.as_secs_f64();
            let left = done.total_samples - done.samples;
            // Suspended, so that the line does not tear the bar.
            bar_handle.suspend(|| say(estimate(per_second, left, done.total_samples, seeds)));
        }
    });
    (progress, callback)
}

/// The estimate: `left` of `of` windows remain in this training of a row.
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
