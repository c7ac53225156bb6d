//! What came, what was dropped where, and how late poses were.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use hdrhistogram::Histogram;
use serde::Serialize;

use crate::{LivePose, Origin};

/// Latencies are kept to three digits, up to this long, in microseconds; later ones count as this.
pub(crate) const LONGEST_US: u64 = 60_000_000;

/// A number that any thread raises.
#[derive(Debug, Default)]
pub struct Count(AtomicU64);

impl Count {
    /// Adds.
    pub fn add(&self, more: u64) {
        self.0.fetch_add(more, Ordering::Relaxed);
    }

    /// What it came to.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts of every stage, raised while the pipeline runs.
#[derive(Debug)]
pub struct Meter {
    began: Instant,
    /// Packets from the source.
    pub packets: Count,
    /// Events from the source, without those that were rejected.
    pub events: Count,
    /// Events outside the sensor, or earlier than one before them.
    pub rejected: Count,
    /// Packets that the source passed over because they made no sense.
    pub malformed: Count,
    /// Packets that the queue dropped, and those that a source lost.
    pub dropped_packets: Count,
    /// Events of the packets that the queue dropped.
    pub dropped_events: Count,
    /// Events that the eye followed.
    pub followed: Count,
    /// Strides at which the network was busy, so that nothing was made for it.
    pub skipped_strides: Count,
    /// Images that the network was shown.
    pub images: Count,
    /// Images with nothing new, so that an earlier answer stood.
    pub repeated: Count,
    /// For how long, in microseconds, a recording was late because it could not be read as fast as it was
    /// to be played: its clock was set back by as much.
    pub slipped_us: Count,
    /// How often the source gave nothing for a while.
    pub stalls: Count,
    /// How often time jumped back.
    pub restarts: Count,
    /// Poses that sinks dropped because they could not keep up.
    pub dropped_poses: Count,
    network: Mutex<Histogram<u64>>,
    between: Mutex<Histogram<u64>>,
}

impl Default for Meter {
    fn default() -> Self {
        Self::new()
    }
}

impl Meter {
    /// Nothing happened yet.
    pub fn new() -> Self {
        Self {
            began: Instant::now(),
            packets: Count::default(),
            events: Count::default(),
            rejected: Count::default(),
            malformed: Count::default(),
            dropped_packets: Count::default(),
            dropped_events: Count::default(),
            followed: Count::default(),
            skipped_strides: Count::default(),
            images: Count::default(),
            repeated: Count::default(),
            slipped_us: Count::default(),
            stalls: Count::default(),
            restarts: Count::default(),
            dropped_poses: Count::default(),
            network: Mutex::new(histogram()),
            between: Mutex::new(histogram()),
        }
    }

    /// Counts a pose and its latency.
    pub fn pose(&self, pose: &LivePose) {
        let latency_us = u64::try_from(pose.latency.as_micros()).unwrap_or(LONGEST_US);
        let histogram = match pose.origin {
            Origin::Network => &self.network,
            Origin::Propagated => &self.between,
        };
        let mut histogram = histogram.lock().unwrap_or_else(PoisonError::into_inner);
        histogram.saturating_record(latency_us.clamp(1, LONGEST_US));
    }

    /// How late poses were since `before` was last brought up to date, those of the network and those
    /// between: this does so.
    pub fn latencies_since(&self, before: &mut Latencies) -> [Latency; 2] {
        let Latencies { network, between } = before;
        [(&self.network, network), (&self.between, between)].map(|(all, before)| {
            let all = all.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let mut since = all.clone();
            // It only ever grows: there is nothing to subtract that it has not.
            let _ = since.subtract(&*before);
            *before = all;
            Latency::of(&since)
        })
    }

    /// All of it so far.
    pub fn report(&self) -> Report {
        let seconds = self.began.elapsed().as_secs_f64();
        let latency = |histogram: &Mutex<Histogram<u64>>| {
            Latency::of(&histogram.lock().unwrap_or_else(PoisonError::into_inner))
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
            between: latency(&self.between),
        }
    }
}

/// Latencies of all poses up to a moment, none to begin with: see [`Meter::latencies_since`].
#[derive(Debug, Clone)]
pub struct Latencies {
    network: Histogram<u64>,
    between: Histogram<u64>,
}

impl Default for Latencies {
    fn default() -> Self {
        Self { network: histogram(), between: histogram() }
    }
}

fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, LONGEST_US, 3).expect("bounds in order")
}

/// How late poses were, in milliseconds from the newest event that they take into account.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Latency {
    /// How many poses.
    pub poses: u64,
    /// Half of them were at most so late.
    pub p50_ms: f64,
    /// 95 of 100.
    pub p95_ms: f64,
    /// 99 of 100.
    pub p99_ms: f64,
    /// The latest.
    pub max_ms: f64,
}

impl Latency {
    pub(crate) fn of(histogram: &Histogram<u64>) -> Self {
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

/// What a pipeline did. Rates are per second of this machine's clock, over all of [`Self::seconds`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(missing_docs, reason = "as in `Meter`")]
pub struct Report {
    /// Since the pipeline began.
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
    /// Poses of the network.
    pub network: Latency,
    /// Poses between them.
    pub between: Latency,
}

impl Report {
    /// A count per second.
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
    fn latencies_of_a_while_are_those_of_no_other() {
        let meter = Meter::new();
        let add = |origin, ms| {
            let answer =
                PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS] };
            let latency = Duration::from_millis(ms);
            meter.pose(&LivePose { t: Micros(0), latency, origin, pose: answer });
        };
        let mut before = Latencies::default();
        (0..100).for_each(|_| add(Origin::Network, 900));
        add(Origin::Propagated, 7);
        let [network, between] = meter.latencies_since(&mut before);
        assert_eq!((network.poses, between.poses), (100, 1));
        assert!((network.p99_ms / 900.0 - 1.0).abs() < 0.01, "{network:?}");
        (0..10).for_each(|_| add(Origin::Network, 3));
        let [network, between] = meter.latencies_since(&mut before);
        assert_eq!((network.poses, between.poses), (10, 0));
        assert!((network.p99_ms / 3.0 - 1.0).abs() < 0.01, "{network:?}");
        assert!((meter.report().network.p99_ms / 900.0 - 1.0).abs() < 0.01, "all of them");
    }
}
