//! Veiling glare: a share of all light is scattered evenly over the image.

use crate::event::{DURATION_S, HEIGHT, WIDTH};
use crate::scene::Scene;

/// Samples of the image's mean in a second; it changes smoothly.
const RATE_HZ: f64 = 1000.0;

/// Every how many pixels the mean is taken.
const STRIDE_PX: usize = 3;

#[derive(Debug)]
pub(super) struct Veil {
    share: f64,
    mean: Vec<f64>,
}

impl Veil {
    pub(super) fn new(scene: &Scene, share: f64) -> Self {
        let samples = (DURATION_S * RATE_HZ) as usize + 2;
        let mean = (0..samples)
            .map(|k| {
                let t_s = k as f64 / RATE_HZ;
                let (mut sum, mut count) = (0.0, 0.0);
                // A mean hardly changes with finer sampling.
                for y in (STRIDE_PX / 2..HEIGHT).step_by(STRIDE_PX) {
                    for x in (STRIDE_PX / 2..WIDTH).step_by(STRIDE_PX) {
                        sum += scene.luminance(x as f64, y as f64, t_s);
                        count += 1.0;
                    }
                }
                sum / count
            })
            .collect();
        Self { share, mean }
    }

    /// The logarithm of light under the veil.
    pub(super) fn over(&self, log_light: f64, t_s: f64) -> f64 {
        let place = (t_s * RATE_HZ).clamp(0.0, (self.mean.len() - 2) as f64);
        let k = place as usize;
        let mean = self.mean[k] + (self.mean[k + 1] - self.mean[k]) * (place - k as f64);
        ((1.0 - self.share) * log_light.exp() + self.share * mean).ln()
    }
}
