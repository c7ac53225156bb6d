//! How training windows are varied.
//!
//! # Source
//! EventHands' training: window lengths log-uniform between 30 and 300 ms ("speed augmentation"),
//! the channels of the whole image swapped with probability 1/2, then those of each pixel.

use evpose_core::CounterRng;
use serde::{Deserialize, Serialize};

/// Random changes to a training window. `Default` is the published setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Augmentation {
    /// Shortest and longest window in milliseconds, log-uniform in between.
    pub window_ms: [u32; 2],
    /// Swap the channels of the whole image with probability 1/2.
    pub swap_image: bool,
    /// Swap the channels of each pixel with probability 1/2.
    pub swap_pixels: bool,
}

impl Default for Augmentation {
    fn default() -> Self {
        Self { window_ms: [30, 300], swap_image: true, swap_pixels: true }
    }
}

impl Augmentation {
    /// Draws a window length in frames of 1 ms.
    pub fn window_frames(&self, rng: &mut CounterRng) -> u32 {
        let [shortest, longest] = self.window_ms.map(|ms| (ms.max(1) as f32).ln());
        rng.uniform(shortest, longest).exp().round() as u32
    }

    /// Swaps channels of `planes`, `[2, height, width]`.
    pub fn swap_channels(&self, rng: &mut CounterRng, planes: &mut [f32]) {
        let (first, second) = planes.split_at_mut(planes.len() / 2);
        if self.swap_image && rng.chance(0.5) {
            first.swap_with_slice(second);
        }
        if self.swap_pixels {
            for (a, b) in first.chunks_mut(64).zip(second.chunks_mut(64)) {
                // One draw decides 64 pixels, a bit each.
                let bits = rng.bits();
                for (i, (a, b)) in a.iter_mut().zip(b).enumerate() {
                    if bits >> i & 1 == 1 {
                        std::mem::swap(a, b);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rng(index: u64) -> CounterRng {
        CounterRng::new(1, "test", index)
    }

    #[test]
    fn window_lengths_are_log_uniform() {
        let augmentation = Augmentation::default();
        let lengths: Vec<u32> =
            (0..20_000).map(|i| augmentation.window_frames(&mut rng(i))).collect();
        assert!(lengths.iter().all(|&length| (30..=300).contains(&length)));
        // Half of a log-uniform draw lies below the geometric mean, sqrt(30 · 300) = 94.9.
        let below = lengths.iter().filter(|&&length| length < 95).count();
        assert!((9_700..10_300).contains(&below), "{below}");
    }

    #[test]
    fn about_half_of_the_pixels_swap_and_none_is_lost() {
        let augmentation = Augmentation::default();
        let pixels = 10_000;
        let mut planes: Vec<f32> = (0..2 * pixels).map(|i| i as f32).collect();
        augmentation.swap_channels(&mut rng(0), &mut planes);
        let swapped = (0..pixels).filter(|&i| planes[i] != i as f32).count();
        assert!((4_700..5_300).contains(&swapped), "{swapped}");
        let total = |i: usize| planes[i] + planes[i + pixels];
        assert!((0..pixels).all(|i| total(i) == (2 * i + pixels) as f32));
    }

    #[test]
    fn without_swaps_nothing_changes() {
        let still = Augmentation { swap_image: false, swap_pixels: false, ..Default::default() };
        let mut planes = vec![1.0, 2.0, 3.0, 4.0];
        still.swap_channels(&mut rng(0), &mut planes);
        assert_eq!(planes, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn the_same_sample_is_varied_the_same_way() {
        let augmentation = Augmentation::default();
        let draw = |index| {
            let mut planes: Vec<f32> = (0..200).map(|i| i as f32).collect();
            let mut rng = rng(index);
            let length = augmentation.window_frames(&mut rng);
            augmentation.swap_channels(&mut rng, &mut planes);
            (length, planes)
        };
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
    }
}
