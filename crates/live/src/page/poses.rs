//! The newest poses, and the latencies of the last second.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Instant;

use hdrhistogram::Histogram;

use super::{Shared, lock};
use crate::meter::MAX_LATENCY_US;
use crate::sink::Sink;
use crate::{LatencySummary, LivePose, PoseOrigin};

const SLOTS: usize = super::rates::PER_SECOND;

/// Sink of the poses that a page shows.
pub struct PageSink {
    shared: Arc<Shared>,
    address: SocketAddr,
}

impl PageSink {
    pub(super) fn new(shared: Arc<Shared>, address: SocketAddr) -> Self {
        Self { shared, address }
    }
}

impl Sink for PageSink {
    fn name(&self) -> String {
        format!("page at http://{}", self.address)
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        lock(&self.shared.newest).record(pose);
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        lock(&self.shared.newest).is_over = true;
        Ok(())
    }
}

pub(super) struct NewestPoses {
    pub(super) network: OriginPoses,
    pub(super) propagated: OriginPoses,
    /// Whether the pipeline has ended.
    pub(super) is_over: bool,
}

impl NewestPoses {
    pub(super) fn new() -> Self {
        Self { network: OriginPoses::new(), propagated: OriginPoses::new(), is_over: false }
    }

    fn record(&mut self, pose: &LivePose) {
        let poses = match pose.origin {
            PoseOrigin::Network | PoseOrigin::Nobody => &mut self.network,
            PoseOrigin::Propagated | PoseOrigin::Held => &mut self.propagated,
        };
        let latency_us = u64::try_from(pose.latency.as_micros()).unwrap_or(MAX_LATENCY_US);
        poses.slot.saturating_record(latency_us.clamp(1, MAX_LATENCY_US));
        poses.pose = Some((pose.clone(), Instant::now()));
    }
}

pub(super) struct OriginPoses {
    /// The newest pose and its time of arrival.
    pub(super) pose: Option<(LivePose, Instant)>,
    /// Latencies since the last rotation.
    slot: Histogram<u64>,
    /// Latencies of the slots before, the newest last.
    slots: VecDeque<Histogram<u64>>,
}

impl OriginPoses {
    fn new() -> Self {
        let slots = std::iter::repeat_with(latencies).take(SLOTS).collect();
        Self { pose: None, slot: latencies(), slots }
    }

    /// Begins another slot. Returns the latencies of the last second, if there were poses.
    pub(super) fn rotate(&mut self) -> Option<LatencySummary> {
        let mut oldest = self.slots.pop_front()?;
        oldest.reset();
        self.slots.push_back(std::mem::replace(&mut self.slot, oldest));
        let mut second = latencies();
        // Histograms of equal bounds can be added.
        let added = self.slots.iter().try_for_each(|slot| second.add(slot));
        (added.is_ok() && !second.is_empty()).then(|| LatencySummary::from_histogram(&second))
    }
}

/// A histogram of two significant digits, as much as a plot can show.
fn latencies() -> Histogram<u64> {
    Histogram::new_with_bounds(1, MAX_LATENCY_US, 2).expect("bounds in order")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use evpose_core::Micros;
    use evpose_pose::body::BODY_JOINTS;

    use super::*;
    use evpose_pose::PoseEstimate;

    fn pose(origin: PoseOrigin, latency_us: u64) -> LivePose {
        let estimate = PoseEstimate::Body {
            joints_px: [None; BODY_JOINTS],
            scores: [0.0; BODY_JOINTS],
            score: 0.0,
        };
        LivePose {
            t: Micros(7),
            latency: Duration::from_micros(latency_us),
            origin,
            pose: estimate,
        }
    }

    #[test]
    fn latencies_are_those_of_the_last_second() {
        let mut newest = NewestPoses::new();
        for k in 1..=100 {
            newest.record(&pose(PoseOrigin::Network, 1_000 * k));
        }
        newest.record(&pose(PoseOrigin::Propagated, 200));
        let latency = newest.network.rotate().unwrap();
        assert_eq!(latency.poses, 100);
        for (is, want) in [(latency.p50_ms, 50.0), (latency.p95_ms, 95.0), (latency.p99_ms, 99.0)] {
            assert!((is / want - 1.0).abs() < 0.01, "{is} ms, not {want} ms");
        }
        assert_eq!(newest.propagated.rotate().unwrap().poses, 1);
        for _ in 1..SLOTS {
            assert_eq!(newest.network.rotate().unwrap().poses, 100);
        }
        assert_eq!(newest.network.rotate(), None);
        assert!(newest.network.pose.is_some(), "the newest pose stays");
    }
}
