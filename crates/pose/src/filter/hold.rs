//! Poses of windows that show next to nothing are those of the last window that showed more.
//!
//! # Model
//! Events come from motion: a hand at rest is not seen, and a network that is shown an empty window
//! predicts its mean pose. So a pose counts only if the representation of its window sums to more
//! than `rest_sum`, or if there was none before. As in [`StillnessConfig`], the sum is stated for
//! 240x180 pixels. Here every window is looked at alone, so that poses do not depend on batches.

use evpose_core::SensorSize;

use super::StillnessConfig;
use crate::PoseError;

/// Holds the last pose that events showed.
#[derive(Debug, Clone)]
pub struct HoldAtRest<P> {
    rest_sum: f64,
    last: Option<P>,
}

impl<P: Copy> HoldAtRest<P> {
    /// For representations of `sensor`, without poses yet.
    ///
    /// # Errors
    /// If the sum is negative or no number.
    pub fn new(config: &StillnessConfig, sensor: SensorSize) -> Result<Self, PoseError> {
        Ok(Self { rest_sum: config.valid_rest_sum_of(sensor)?, last: None })
    }

    /// The pose that counts for a window with the values of `representation`, of which the network
    /// predicted `predicted`. One that `is_seen` nowhere in particular counts as one at rest.
    pub fn pose(&mut self, representation: &[f32], predicted: &P, is_seen: bool) -> P {
        let sum: f64 = representation.iter().map(|&value| f64::from(value)).sum();
        match self.last {
            Some(last) if sum <= self.rest_sum || !is_seen => last,
            // The first pose counts even for an empty window, since there is nothing to hold.
            _ => *self.last.insert(*predicted),
        }
    }

    /// Forgets the last pose.
    pub fn reset(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HandParams;

    #[test]
    fn empty_windows_repeat_the_last_pose_that_was_seen() {
        let config = StillnessConfig { rest_sum: 4.0 };
        let mut hold = HoldAtRest::new(&config, SensorSize::DAVIS240C).unwrap();
        let pose = |k: f32| HandParams { articulation: [k; 6], ..HandParams::default() };
        let (full, empty) = ([1.0f32; 5], [1.0f32, 1.0, 1.0, 1.0, 0.0]);
        // There is nothing to hold at first.
        assert_eq!(hold.pose(&empty, &pose(1.0), true), pose(1.0));
        assert_eq!(hold.pose(&full, &pose(2.0), true), pose(2.0));
        assert_eq!(hold.pose(&empty, &pose(3.0), true), pose(2.0));
        assert_eq!(hold.pose(&full, &pose(4.0), true), pose(4.0));
        assert_eq!(hold.pose(&full, &pose(6.0), false), pose(4.0), "seen nowhere");
        hold.reset();
        assert_eq!(hold.pose(&empty, &pose(5.0), true), pose(5.0));
        let wrong = StillnessConfig { rest_sum: -1.0 };
        assert!(HoldAtRest::<HandParams>::new(&wrong, SensorSize::DAVIS240C).is_err());
    }
}
