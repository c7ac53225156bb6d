//! Predictions of a scene at rest are repeated instead of inferred again.
//!
//! # Model
//! Representations come in batches. The mean representation of a batch sums to
//!
//! ```text
//!   S = 1/B · Σ over representations, channels, pixels of LNES
//! ```
//!
//! about half the number of pixels that fired within a window. If `S > rest_sum`, or nothing
//! was predicted yet, the batch is inferred; otherwise the predictions of the batch before are
//! repeated in their order.
//!
//! `S` is in proportion to the number of pixels: what moves passes over as large a part of a smaller
//! image, and every pixel is as noisy. So `rest_sum` is stated for 240x180 pixels and scales with
//! their number: 75 for 120x90, 18.75 for 60x45. The published camera's noise alone, 2600 events a
//! second, comes to about 130 of 240x180.
//!
//! # Source
//! EventHands, slow-motion mode: batches of 16 representations, a sum of 300, at 240x180.

use evpose_core::SensorSize;
use serde::{Deserialize, Serialize};

use crate::PoseError;

/// Threshold below which a scene is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StillnessConfig {
    /// Largest sum of the mean representation of a batch of a scene at rest, for 240x180 pixels;
    /// other sizes in proportion.
    pub rest_sum: f64,
}

impl Default for StillnessConfig {
    fn default() -> Self {
        Self { rest_sum: 300.0 }
    }
}

impl StillnessConfig {
    /// [`rest_sum`](Self::rest_sum) scaled to the pixels of `sensor`.
    pub fn rest_sum_of(&self, sensor: SensorSize) -> f64 {
        self.rest_sum * sensor.pixels() as f64 / SensorSize::DAVIS240C.pixels() as f64
    }

    /// The same, checked.
    pub(super) fn valid_rest_sum_of(&self, sensor: SensorSize) -> Result<f64, PoseError> {
        let rest_sum = self.rest_sum;
        let is_sum = rest_sum >= 0.0 && rest_sum.is_finite();
        PoseError::unless(is_sum, "rest_sum", rest_sum, "a number from 0")?;
        Ok(self.rest_sum_of(sensor))
    }
}

/// Skips the inference of batches without motion and repeats the predictions before.
#[derive(Debug, Clone)]
pub struct StillnessGate<P> {
    rest_sum: f64,
    previous: Vec<P>,
}

impl<P: Copy> StillnessGate<P> {
    /// A gate for representations of `sensor`, without predictions yet.
    ///
    /// # Errors
    /// If the sum is negative or no number.
    pub fn new(config: &StillnessConfig, sensor: SensorSize) -> Result<Self, PoseError> {
        Ok(Self { rest_sum: config.valid_rest_sum_of(sensor)?, previous: Vec::new() })
    }

    /// Whether a batch of `count` contiguous representations shows a scene at rest of which poses
    /// are known.
    pub fn is_at_rest(&self, representations: &[f32], count: usize) -> bool {
        let sum = representations.iter().copied().map(f64::from).sum::<f64>() / count.max(1) as f64;
        sum <= self.rest_sum && !self.previous.is_empty()
    }

    /// Takes the predictions of a batch.
    pub fn predicted(&mut self, poses: Vec<P>) {
        self.previous = poses;
    }

    /// The predictions of the batch before, for a batch of `count` representations: the last one
    /// again where there are fewer.
    pub fn repeat(&mut self, count: usize) -> &[P] {
        if let Some(&last) = self.previous.last() {
            // It only grows: a short batch must not drop poses that a longer one repeats.
            self.previous.resize(self.previous.len().max(count), last);
        }
        &self.previous[..count.min(self.previous.len())]
    }

    /// Drops every prediction.
    pub fn reset(&mut self) {
        self.previous.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HandParams;

    const SENSOR: SensorSize = SensorSize { width: 24, height: 18 };

    fn gate() -> StillnessGate<HandParams> {
        StillnessGate::new(&StillnessConfig::default(), SENSOR).expect("valid settings")
    }

    fn pose(number: f32) -> HandParams {
        HandParams { articulation: [number; 6], ..HandParams::default() }
    }

    /// `count` representations whose mean sums to `sum`.
    fn representations(count: usize, sum: f32) -> Vec<f32> {
        let mut all = vec![0.0; count * 2 * SENSOR.pixels()];
        for representation in all.chunks_exact_mut(2 * SENSOR.pixels()) {
            representation[..4].fill(0.25 * sum);
        }
        all
    }

    /// Poses of a batch that would be predicted as `number`, `number + 1`, …, and whether they are
    /// repeated.
    fn pass(
        gate: &mut StillnessGate<HandParams>,
        count: usize,
        sum: f32,
        number: f32,
    ) -> (Vec<f32>, bool) {
        let is_repeated = gate.is_at_rest(&representations(count, sum), count);
        if !is_repeated {
            gate.predicted((0..count).map(|i| pose(number + i as f32)).collect());
        }
        (gate.repeat(count).iter().map(|pose| pose.articulation[0]).collect(), is_repeated)
    }

    /// A hundredth of the published pixels: 3 instead of 300.
    #[test]
    fn what_moves_is_predicted_and_what_rests_is_repeated() {
        let mut gate = gate();
        assert_eq!(pass(&mut gate, 3, 0.0, 10.0), (vec![10.0, 11.0, 12.0], false), "the first");
        assert_eq!(pass(&mut gate, 3, 3.0, 20.0), (vec![10.0, 11.0, 12.0], true), "at the limit");
        assert_eq!(pass(&mut gate, 3, 3.1, 30.0), (vec![30.0, 31.0, 32.0], false));
        assert_eq!(pass(&mut gate, 3, 2.9, 40.0), (vec![30.0, 31.0, 32.0], true));
        gate.reset();
        assert_eq!(pass(&mut gate, 3, 0.0, 50.0), (vec![50.0, 51.0, 52.0], false));
    }

    #[test]
    fn batches_of_other_lengths_repeat_what_there_is() {
        let mut gate = gate();
        pass(&mut gate, 2, 9.0, 1.0);
        assert_eq!(pass(&mut gate, 1, 0.0, 9.0), (vec![1.0], true));
        assert_eq!(pass(&mut gate, 4, 0.0, 9.0), (vec![1.0, 2.0, 2.0, 2.0], true));
    }

    #[test]
    fn the_published_sum_goes_with_the_number_of_pixels() {
        let sum =
            |width, height| StillnessConfig::default().rest_sum_of(SensorSize { width, height });
        assert_eq!([sum(240, 180), sum(120, 90), sum(60, 45)], [300.0, 75.0, 18.75]);
    }

    #[test]
    fn a_sum_that_is_not_finite_is_refused() {
        for rest_sum in [-1.0, f64::NAN, f64::INFINITY] {
            let error = StillnessGate::<HandParams>::new(&StillnessConfig { rest_sum }, SENSOR);
            assert!(error.is_err_and(|error| error.to_string().contains("rest_sum")));
        }
    }
}
