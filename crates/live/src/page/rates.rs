//! Rates of the last second.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::{LatencySummary, Report};

pub(super) const PER_SECOND: usize = 10;

pub(super) const INTERVAL: Duration = Duration::from_millis(1_000 / PER_SECOND as u64);

/// Length of the history in seconds, as the plot shows it.
const HISTORY_S: usize = 10;

/// Time without events after which the page shows a stall.
const STALL: Duration = Duration::from_millis(500);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    /// Before the first event.
    Waiting,
    /// Events arrive.
    Live,
    /// No events for [`STALL`].
    Stalled,
    /// After the end.
    Ended,
}

/// Rates of all counters, per second.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(super) struct Rates {
    packets: f64,
    events: f64,
    rejected: f64,
    malformed: f64,
    dropped_packets: f64,
    dropped_events: f64,
    followed: f64,
    skipped_strides: f64,
    images: f64,
    repeated: f64,
    dropped_poses: f64,
    network: f64,
    propagated: f64,
}

/// A point of the plots: the rate of events, and the median, 0.95 quantile, 0.99 quantile and
/// maximum of the latencies of the last second, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Point {
    /// Time in seconds since the pipeline began.
    at_s: f64,
    events: f64,
    network: Option<[f64; 4]>,
    propagated: Option<[f64; 4]>,
}

impl Point {
    pub(super) fn new(
        at_s: f64,
        rates: &Rates,
        network: Option<LatencySummary>,
        propagated: Option<LatencySummary>,
    ) -> Self {
        let four = |latency: LatencySummary| {
            [latency.p50_ms, latency.p95_ms, latency.p99_ms, latency.max_ms]
        };
        let events = rates.events;
        Self { at_s, events, network: network.map(four), propagated: propagated.map(four) }
    }

    /// Appends itself to the history and removes the oldest point.
    pub(super) fn join(self, history: &mut Vec<Self>) {
        if history.len() >= HISTORY_S * PER_SECOND {
            history.remove(0);
        }
        history.push(self);
    }
}

/// A sliding window of reports over the last second.
pub(super) struct RateWindow {
    reports: VecDeque<Report>,
    last_events: Option<Instant>,
}

impl RateWindow {
    pub(super) fn new() -> Self {
        Self { reports: VecDeque::new(), last_events: None }
    }

    /// Appends the report at `now`. Returns the rates since the one a second before.
    pub(super) fn push(&mut self, report: Report, now: Instant) -> Rates {
        if report.events > self.reports.back().map_or(0, |last| last.events) {
            self.last_events = Some(now);
        }
        // There is one report more than intervals: the first and the last are a second apart.
        if self.reports.len() > PER_SECOND {
            self.reports.pop_front();
        }
        self.reports.push_back(report);
        self.reports.front().map_or_else(Rates::default, |first| since(first, &report))
    }

    pub(super) fn state(&self, is_over: bool, now: Instant) -> State {
        match self.last_events {
            _ if is_over => State::Ended,
            None => State::Waiting,
            Some(last_events) if now.saturating_duration_since(last_events) >= STALL => {
                State::Stalled
            }
            Some(_) => State::Live,
        }
    }
}

fn since(first: &Report, last: &Report) -> Rates {
    let passed_s = last.seconds - first.seconds;
    // The first report is both ends of the window: no time has passed.
    if passed_s <= 0.0 {
        return Rates::default();
    }
    // Counters of a meter that was replaced in between may be smaller than before.
    let rate =
        |count: fn(&Report) -> u64| count(last).saturating_sub(count(first)) as f64 / passed_s;
    Rates {
        packets: rate(|report| report.packets),
        events: rate(|report| report.events),
        rejected: rate(|report| report.rejected),
        malformed: rate(|report| report.malformed),
        dropped_packets: rate(|report| report.dropped_packets),
        dropped_events: rate(|report| report.dropped_events),
        followed: rate(|report| report.followed),
        skipped_strides: rate(|report| report.skipped_strides),
        images: rate(|report| report.images),
        repeated: rate(|report| report.repeated),
        dropped_poses: rate(|report| report.dropped_poses),
        network: rate(|report| report.network.poses),
        propagated: rate(|report| report.propagated.poses),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Meter;

    #[test]
    fn rates_are_those_of_the_last_second() {
        let (began, nothing) = (Instant::now(), Meter::new().report());
        let mut recent = RateWindow::new();
        assert_eq!(recent.state(false, began), State::Waiting);
        let mut rates = Rates::default();
        for tick in 0..=40_u64 {
            let at_s = tick as f64 * 0.1;
            // 1000 a second for two seconds, 5000 a second later.
            let events = 100 * tick.min(20) + 500 * tick.saturating_sub(20);
            rates = recent.push(
                Report { seconds: at_s, events, skipped_strides: tick, ..nothing },
                began + Duration::from_secs_f64(at_s),
            );
            if tick == 20 {
                assert!((rates.events - 1_000.0).abs() < 1e-6, "{rates:?}");
            }
        }
        assert!((rates.events - 5_000.0).abs() < 1e-6, "{rates:?}");
        assert!((rates.skipped_strides - 10.0).abs() < 1e-6, "{rates:?}");
        assert!(rates.rejected.abs() < 1e-9);
        let at = |s| recent.state(false, began + Duration::from_secs_f64(s));
        assert_eq!((at(4.2), at(4.6)), (State::Live, State::Stalled));
        assert_eq!(recent.state(true, began), State::Ended);
    }

    #[test]
    fn ten_seconds_are_kept() {
        let mut history = Vec::new();
        for k in 0..150 {
            Point::new(f64::from(k), &Rates::default(), None, None).join(&mut history);
        }
        assert_eq!((history.len(), history[0].at_s as u32), (100, 50));
    }
}
