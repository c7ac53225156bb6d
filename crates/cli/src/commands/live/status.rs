//! Progress lines and the final summary on standard error.

use std::time::Duration;

use evpose_live::{Control, LatencyBaseline, LatencySummary, Report};

use crate::progress::note;

/// Prints a line every second until the program ends.
pub(super) fn print_each_second(control: &Control) {
    let control = control.clone();
    std::thread::spawn(move || {
        let (mut before, mut latencies) = (control.meter.report(), LatencyBaseline::default());
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let now = control.meter.report();
            note(progress_line(&before, &now, control.meter.latencies_since(&mut latencies)));
            before = now;
        }
    });
}

/// Rates and latencies from one report to the next.
fn progress_line(
    before: &Report,
    now: &Report,
    [network, propagated]: [LatencySummary; 2],
) -> String {
    // Two reports within a millisecond would make any rate.
    let seconds = (now.seconds - before.seconds).max(1e-3);
    let rate = |of: fn(&Report) -> u64| (of(now) - of(before)) as f64 / seconds;
    let mut line = format!(
        "{:7.1} s  {:6.2} M events/s  network {:4.0}/s p99 {:5.1} ms  propagated {:4.0}/s p99 {:5.1} ms",
        now.seconds,
        1e-6 * rate(|r| r.events),
        rate(|r| r.network.poses),
        network.p99_ms,
        rate(|r| r.propagated.poses),
        propagated.p99_ms,
    );
    // Only when it happens: a column of zeros hides the one that matters.
    let dropped = rate(|r| r.dropped_events);
    if dropped > 0.0 {
        line += &format!("  {:.2} M events/s dropped", 1e-6 * dropped);
    }
    line
}

/// Prints the totals of a pipeline.
pub(super) fn print_summary(report: &Report) {
    let latency = |name: &str, l: &LatencySummary| {
        note(format!(
            "{name:<11}{:>8} poses {:>7.1}/s   latency p50 {:.2}, p95 {:.2}, p99 {:.2}, max {:.2} ms",
            l.poses,
            report.per_second(l.poses),
            l.p50_ms,
            l.p95_ms,
            l.p99_ms,
            l.max_ms
        ));
    };
    note(format!(
        "{:.1} s, {} events, {:.2} M events/s",
        report.seconds,
        report.events,
        1e-6 * report.per_second(report.events)
    ));
    latency("network", &report.network);
    latency("propagated", &report.propagated);
    note(format!(
        "source:  {} rejected, {} malformed packets, {} stalls, {} restarts",
        report.rejected, report.malformed, report.stalls, report.restarts
    ));
    if report.slipped_us > 0 {
        note(format!(
            "         replay clock set back by {:.2} s: the recording could not be followed in time",
            1e-6 * report.slipped_us as f64
        ));
    }
    note(format!(
        "queue:   {} packets dropped, {} events",
        report.dropped_packets, report.dropped_events
    ));
    note(format!(
        "network: {} inputs, {} strides skipped while it was busy, {} without a change",
        report.images, report.skipped_strides, report.repeated
    ));
    note(format!("sinks:   {} poses dropped", report.dropped_poses));
}
