//! What somebody who watches is told.

use std::time::Duration;

use evpose_live::{Control, Latencies, Latency, Report};

use evpose_app::progress::note;

/// A line every second, until the program ends.
pub(super) fn each_second(control: &Control) {
    let control = control.clone();
    std::thread::spawn(move || {
        let (mut before, mut latencies) = (control.meter.report(), Latencies::default());
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let now = control.meter.report();
            note(line(&before, &now, control.meter.latencies_since(&mut latencies)));
            before = now;
        }
    });
}

/// What happened between two reports, and how late poses between them were.
fn line(before: &Report, now: &Report, [network, between]: [Latency; 2]) -> String {
    let seconds = (now.seconds - before.seconds).max(1e-3);
    let rate = |of: fn(&Report) -> u64| (of(now) - of(before)) as f64 / seconds;
    let mut line = format!(
        "{:7.1} s  {:6.2} M events/s  network {:4.0}/s p99 {:5.1} ms  between {:4.0}/s p99 {:5.1} ms",
        now.seconds,
        1e-6 * rate(|r| r.events),
        rate(|r| r.network.poses),
        network.p99_ms,
        rate(|r| r.between.poses),
        between.p99_ms,
    );
    let dropped = rate(|r| r.dropped_events);
    if dropped > 0.0 {
        line += &format!("  {:.2} M events/s dropped", 1e-6 * dropped);
    }
    line
}

/// All of it.
pub(super) fn at_the_end(report: &Report) {
    let latency = |name: &str, l: &Latency| {
        note(format!(
            "{name:<9}{:>8} poses {:>7.1}/s   latency p50 {:.2}, p95 {:.2}, p99 {:.2}, max {:.2} ms",
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
    latency("between", &report.between);
    note(format!(
        "source:  {} rejected, {} malformed packets, {} stalls, {} restarts",
        report.rejected, report.malformed, report.stalls, report.restarts
    ));
    if report.slipped_us > 0 {
        note(format!(
            "         read {:.2} s later than it was to be played",
            1e-6 * report.slipped_us as f64
        ));
    }
    note(format!(
        "queue:   {} packets dropped, {} events",
        report.dropped_packets, report.dropped_events
    ));
    note(format!(
        "network: {} images shown, {} strides skipped while it was busy, {} with nothing new",
        report.images, report.skipped_strides, report.repeated
    ));
    note(format!("sinks:   {} poses dropped", report.dropped_poses));
}
