//! Poses that are shown, and how late those of the last second were.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Instant;

use hdrhistogram::Histogram;

use super::{Shared, lock};
use crate::meter::LONGEST_US;
use crate::sink::Sink;
use crate::{Latency, LivePose, Origin};

/// Slots that make up the last second.
const SLOTS: usize = super::rates::PER_SECOND;

/// Gives a page the poses that it shows.
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

    fn take(&mut self, pose: &LivePose) -> io::Result<()> {
        lock(&self.shared.newest).take(pose);
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        lock(&self.shared.newest).is_over = true;
        Ok(())
    }
}

/// The newest poses.
pub(super) struct Newest {
    pub(super) network: Lane,
    pub(super) between: Lane,
    /// Whether no pose will come any more.
    pub(super) is_over: bool,
}

impl Newest {
    pub(super) fn new() -> Self {
        Self { network: Lane::new(), between: Lane::new(), is_over: false }
    }

    fn take(&mut self, pose: &LivePose) {
        let lane = match pose.origin {
            Origin::Network => &mut self.network,
            Origin::Propagated => &mut self.between,
        };
        let latency_us = u64::try_from(pose.latency.as_micros()).unwrap_or(LONGEST_US);
        lane.slot.saturating_record(latency_us.clamp(1, LONGEST_US));
        lane.pose = Some((pose.clone(), Instant::now()));
    }
}

/// Poses of one origin.
pub(super) struct Lane {
    /// The newest and when it came.
    pub(super) pose: Option<(LivePose, Instant)>,
    /// Latencies since the last turn.
    slot: Histogram<u64>,
    /// Latencies of the turns before, the newest last.
    slots: VecDeque<Histogram<u64>>,
}

impl Lane {
    fn new() -> Self {
        let slots = std::iter::repeat_with(latencies).take(SLOTS).collect();
        Self { pose: None, slot: latencies(), slots }
    }

    /// Ends a slot. Returns the latencies of the last second, if there were poses.
    pub(super) fn turn(&mut self) -> Option<Latency> {
        let mut oldest = self.slots.pop_front()?;
        oldest.reset();
        self.slots.push_back(std::mem::replace(&mut self.slot, oldest));
        let mut second = latencies();
        // All have the same bounds.
        let added = self.slots.iter().try_for_each(|slot| second.add(slot));
        (added.is_ok() && !second.is_empty()).then(|| Latency::of(&second))
    }
}

/// To two digits: what a plot can show.
fn latencies() -> Histogram<u64> {
    Histogram::new_with_bounds(1, LONGEST_US, 2).expect("bounds in order")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use std::time::Duration;

    use evpose_core::Micros;
    use evpose_pose::body::BODY_JOINTS;

    use super::*;
    use evpose_pose::PoseEstimate;

    fn pose(origin: Origin, latency_us: u64) -> LivePose {
        let answer =
            PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS] };
        LivePose { t: Micros(7), latency: Duration::from_micros(latency_us), origin, pose: answer }
    }

    #[test]
    fn latencies_are_those_of_the_last_second() {
        let mut newest = Newest::new();
        for k in 1..=100 {
            newest.take(&pose(Origin::Network, 1_000 * k));
        }
        newest.take(&pose(Origin::Propagated, 200));
        let latency = newest.network.turn().unwrap();
        assert_eq!(latency.poses, 100);
        for (is, want) in [(latency.p50_ms, 50.0), (latency.p95_ms, 95.0), (latency.p99_ms, 99.0)] {
            assert!((is / want - 1.0).abs() < 0.01, "{is} ms, not {want} ms");
        }
        assert_eq!(newest.between.turn().unwrap().poses, 1);
        for _ in 1..SLOTS {
            assert_eq!(newest.network.turn().unwrap().poses, 100);
        }
        assert_eq!(newest.network.turn(), None);
        assert!(newest.network.pose.is_some(), "the newest pose stays");
    }
}
