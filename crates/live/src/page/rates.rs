//! What came in the last second.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::{Latency, Report};

/// How often figures are taken.
pub(super) const PER_SECOND: usize = 10;

/// From one time that figures are taken to the next.
pub(super) const EVERY: Duration = Duration::from_millis(1_000 / PER_SECOND as u64);

/// Figures are kept for so many seconds: what the plot shows.
const KEPT_S: usize = 10;

/// A source that gives nothing for so long has stalled.
const STALL: Duration = Duration::from_millis(500);

/// What a pipeline is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum State {
    /// No event came yet.
    Waiting,
    /// Events come.
    Live,
    /// None came for a while.
    Stalled,
    /// None will come any more.
    Ended,
}

/// Counts of a second, each per second.
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
    between: f64,
}

/// A second in the plots: its events, and how late its poses were, in milliseconds: half of them, 95 of 100
/// and 99 of 100 at most so, and the latest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Point {
    /// Where it ends, in seconds since the pipeline began.
    at_s: f64,
    events: f64,
    network: Option<[f64; 4]>,
    between: Option<[f64; 4]>,
}

impl Point {
    pub(super) fn new(
        at_s: f64,
        rates: &Rates,
        network: Option<Latency>,
        between: Option<Latency>,
    ) -> Self {
        let four =
            |latency: Latency| [latency.p50_ms, latency.p95_ms, latency.p99_ms, latency.max_ms];
        let events = rates.events;
        Self { at_s, events, network: network.map(four), between: between.map(four) }
    }

    /// Adds itself to those of the last seconds.
    pub(super) fn join(self, history: &mut Vec<Self>) {
        if history.len() >= KEPT_S * PER_SECOND {
            history.remove(0);
        }
        history.push(self);
    }
}

/// Reports of the last second.
pub(super) struct Recent {
    reports: VecDeque<Report>,
    heard: Option<Instant>,
}

impl Recent {
    pub(super) fn new() -> Self {
        Self { reports: VecDeque::new(), heard: None }
    }

    /// Takes a report of `now`. Returns what came since the one a second before.
    pub(super) fn take(&mut self, report: Report, now: Instant) -> Rates {
        if report.events > self.reports.back().map_or(0, |last| last.events) {
            self.heard = Some(now);
        }
        if self.reports.len() > PER_SECOND {
            self.reports.pop_front();
        }
        self.reports.push_back(report);
        self.reports.front().map_or_else(Rates::default, |first| since(first, &report))
    }

    pub(super) fn state(&self, is_over: bool, now: Instant) -> State {
        match self.heard {
            _ if is_over => State::Ended,
            None => State::Waiting,
            Some(heard) if now.saturating_duration_since(heard) >= STALL => State::Stalled,
            Some(_) => State::Live,
        }
    }
}

fn since(first: &Report, last: &Report) -> Rates {
    let passed_s = last.seconds - first.seconds;
    if passed_s <= 0.0 {
        return Rates::default();
    }
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
        between: rate(|report| report.between.poses),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Meter;

    #[test]
    fn rates_are_those_of_the_last_second() {
        let (began, nothing) = (Instant::now(), Meter::new().report());
        let mut recent = Recent::new();
        assert_eq!(recent.state(false, began), State::Waiting);
        let mut rates = Rates::default();
        for tick in 0..=40_u64 {
            let at_s = tick as f64 * 0.1;
            // 1000 a second for two seconds, 5000 a second later.
            let events = 100 * tick.min(20) + 500 * tick.saturating_sub(20);
            rates = recent.take(
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
