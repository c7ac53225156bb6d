//! Counters of every stage, and histograms of latency.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use hdrhistogram::Histogram;
use serde::Serialize;

use crate::{LivePose, PoseOrigin};

/// Upper end of the latency histograms, in microseconds: a minute. Longer latencies count as this.
pub(crate) const MAX_LATENCY_US: u64 = 60_000_000;

/// A counter that any thread may increment.
#[derive(Debug, Default)]
pub struct Counter(AtomicU64);

impl Counter {
    /// Adds `count`.
    pub fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    /// The current count.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counters of every stage, incremented while the pipeline runs.
#[derive(Debug)]
pub struct Meter {
    began: Instant,
    /// Packets from the source.
    pub packets: Counter,
    /// Events from the source, without rejected ones.
    pub events: Counter,
    /// Events outside the sensor, or earlier than one before them.
    pub rejected: Counter,
    /// Packets that the source skipped as malformed.
    pub malformed: Counter,
    /// Packets that the queue dropped, and packets lost by the source.
    pub dropped_packets: Counter,
    /// Events of the packets that the queue dropped.
    pub dropped_events: Counter,
    /// Events that the front end processed.
    pub followed: Counter,
    /// Strides without an input because the network was busy.
    pub skipped_strides: Counter,
    /// Inputs of the network.
    pub images: Counter,
    /// Strides without an input because the representation had not changed.
    pub repeated: Counter,
    /// Total time in microseconds by which the replay clock was set back because a recording could
    /// not be read at its playback speed.
    pub slipped_us: Counter,
    /// Pauses of the source of at least [`LiveOptions::stall`](crate::LiveOptions::stall).
    pub stalls: Counter,
    /// Backward jumps of the time stamps: each begins another recording.
    pub restarts: Counter,
    /// Poses that sinks dropped because they could not keep up.
    pub dropped_poses: Counter,
    remarks: Mutex<Vec<String>>,
    network: Mutex<Histogram<u64>>,
    propagated: Mutex<Histogram<u64>>,
}

impl Default for Meter {
    fn default() -> Self {
        Self::new()
    }
}

impl Meter {
    /// All counters at zero, starting now.
    pub fn new() -> Self {
        Self {
            began: Instant::now(),
            packets: Counter::default(),
            events: Counter::default(),
            rejected: Counter::default(),
            malformed: Counter::default(),
            dropped_packets: Counter::default(),
            dropped_events: Counter::default(),
            followed: Counter::default(),
            skipped_strides: Counter::default(),
            images: Counter::default(),
            repeated: Counter::default(),
            slipped_us: Counter::default(),
            stalls: Counter::default(),
            restarts: Counter::default(),
            dropped_poses: Counter::default(),
            remarks: Mutex::default(),
            network: Mutex::new(histogram()),
            propagated: Mutex::new(histogram()),
        }
    }

    /// Keeps the remarks of the source, which are complete at its end.
    pub fn remark(&self, remarks: Vec<String>) {
        *self.remarks.lock().unwrap_or_else(PoisonError::into_inner) = remarks;
    }

    /// Remarks of the source, in sentences without a full stop; none before its end.
    pub fn remarks(&self) -> Vec<String> {
        self.remarks.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Counts a pose and adds its latency to the histogram of its origin.
    pub fn record(&self, pose: &LivePose) {
        let latency_us = u64::try_from(pose.latency.as_micros()).unwrap_or(MAX_LATENCY_US);
        let histogram = match pose.origin {
            PoseOrigin::Network | PoseOrigin::Nobody => &self.network,
            PoseOrigin::Propagated | PoseOrigin::Held => &self.propagated,
        };
        let mut histogram = histogram.lock().unwrap_or_else(PoisonError::into_inner);
        histogram.saturating_record(latency_us.clamp(1, MAX_LATENCY_US));
    }

    /// Latencies of the inferred and of the propagated poses since `before`, which is then set to
    /// now.
    pub fn latencies_since(&self, before: &mut LatencyBaseline) -> [LatencySummary; 2] {
        let LatencyBaseline { network, propagated } = before;
        [(&self.network, network), (&self.propagated, propagated)].map(|(all, before)| {
            let all = all.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let mut since = all.clone();
            // Histograms only grow, so that the earlier one is always contained in the later one.
            let _ = since.subtract(&*before);
            *before = all;
            LatencySummary::from_histogram(&since)
        })
    }

    /// A snapshot of all counters.
    pub fn report(&self) -> Report {
        let seconds = self.began.elapsed().as_secs_f64();
        // Counts stay valid if a thread has panicked.
        let latency = |histogram: &Mutex<Histogram<u64>>| {
            LatencySummary::from_histogram(
                &histogram.lock().unwrap_or_else(PoisonError::into_inner),
            )
        };
        Report {
            seconds,
            packets: self.packets.get(),
            events: self.events.get(),
            rejected: self.rejected.get(),
            malformed: self.malformed.get(),
            dropped_packets: self.dropped_packets.get(),
            dropped_events: self.dropped_events.get(),
            followed: self.followed.get(),
            skipped_strides: self.skipped_strides.get(),
            images: self.images.get(),
            repeated: self.repeated.get(),
            slipped_us: self.slipped_us.get(),
            stalls: self.stalls.get(),
            restarts: self.restarts.get(),
            dropped_poses: self.dropped_poses.get(),
            network: latency(&self.network),
            propagated: latency(&self.propagated),
        }
    }
}

/// Histograms of latency at an earlier time, empty by default: see [`Meter::latencies_since`].
#[derive(Debug, Clone)]
pub struct LatencyBaseline {
    network: Histogram<u64>,
    propagated: Histogram<u64>,
}

impl Default for LatencyBaseline {
    fn default() -> Self {
        Self { network: histogram(), propagated: histogram() }
    }
}

fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, MAX_LATENCY_US, 3).expect("bounds in order")
}

/// Quantiles of latency in milliseconds, counted from the newest event that a pose depends on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LatencySummary {
    /// Number of poses.
    pub poses: u64,
    /// Median.
    pub p50_ms: f64,
    /// 0.95 quantile.
    pub p95_ms: f64,
    /// 0.99 quantile.
    pub p99_ms: f64,
    /// Maximum.
    pub max_ms: f64,
}

impl LatencySummary {
    pub(crate) fn from_histogram(histogram: &Histogram<u64>) -> Self {
        let ms = |us: u64| us as f64 * 1e-3;
        Self {
            poses: histogram.len(),
            p50_ms: ms(histogram.value_at_quantile(0.50)),
            p95_ms: ms(histogram.value_at_quantile(0.95)),
            p99_ms: ms(histogram.value_at_quantile(0.99)),
            max_ms: ms(histogram.max()),
        }
    }
}

/// A snapshot of a [`Meter`]. Rates are per second of host time, over all of [`Self::seconds`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "as in `Meter`")]
pub struct Report {
    /// Host time since the pipeline began.
    pub seconds: f64,
    pub packets: u64,
    pub events: u64,
    pub rejected: u64,
    pub malformed: u64,
    pub dropped_packets: u64,
    pub dropped_events: u64,
    pub followed: u64,
    pub skipped_strides: u64,
    pub images: u64,
    pub repeated: u64,
    pub slipped_us: u64,
    pub stalls: u64,
    pub restarts: u64,
    pub dropped_poses: u64,
    /// Inferred poses.
    pub network: LatencySummary,
    /// Propagated poses.
    pub propagated: LatencySummary,
}

impl Report {
    /// `count` per second of host time.
    pub fn per_second(&self, count: u64) -> f64 {
        count as f64 / self.seconds.max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use evpose_core::Micros;
    use evpose_pose::body::BODY_JOINTS;

    use super::*;
    use evpose_pose::PoseEstimate;

    #[test]
    fn latencies_since_a_baseline_exclude_earlier_ones() {
        let meter = Meter::new();
        let add = |origin, ms| {
            let pose = PoseEstimate::Body {
                joints_px: [None; BODY_JOINTS],
                scores: [0.0; BODY_JOINTS],
                score: 0.0,
            };
            let latency = Duration::from_millis(ms);
            meter.record(&LivePose { t: Micros(0), latency, origin, pose });
        };
        let mut before = LatencyBaseline::default();
        (0..100).for_each(|_| add(PoseOrigin::Network, 900));
        add(PoseOrigin::Propagated, 7);
        let [network, propagated] = meter.latencies_since(&mut before);
        assert_eq!((network.poses, propagated.poses), (100, 1));
        assert!((network.p99_ms / 900.0 - 1.0).abs() < 0.01, "{network:?}");
        (0..10).for_each(|_| add(PoseOrigin::Network, 3));
        let [network, propagated] = meter.latencies_since(&mut before);
        assert_eq!((network.poses, propagated.poses), (10, 0));
        assert!((network.p99_ms / 3.0 - 1.0).abs() < 0.01, "{network:?}");
        assert!((meter.report().network.p99_ms / 900.0 - 1.0).abs() < 0.01, "all of them");
    }
}
